//! Where curves open: behind samples that are missing, and nowhere else, in whatever order a source reports.

use super::Model;
use super::tests::{rows, state};
use crate::feed::{DerivedBlock, EventKind, Feed, RowBlock};
use crate::{Channel, Span};
use grip_link::message::daemon::Gripper;

fn model(feeds: impl IntoIterator<Item = Feed>) -> Model {
    let mut model = Model::new(1 << 24);
    feeds.into_iter().for_each(|feed| model.take(feed));
    model
}

/// Rows at 1 kHz, behind a gap.
fn behind_gap(from_us: u64, count: usize) -> Feed {
    Feed::Rows(RowBlock { broken: true, ..rows(from_us, 1000, &vec![1.0; count]) })
}

/// Times of the points before which a curve is open.
fn breaks(model: &Model, channel: Channel) -> Vec<f64> {
    let mut points = Vec::new();
    assert!(model.series(channel).unwrap().points(Span::new(0.0, 99.0), 10_000, &mut points));
    points.iter().filter(|point| point[1].is_nan()).map(|point| point[0]).collect()
}

/// What is reported of a state: every curve has the same points.
fn states(times: &[f64]) -> Vec<Feed> {
    times.iter().map(|t_s| Feed::State(state(*t_s))).collect()
}

#[test]
fn curves_of_states_open_behind_the_gap_though_older_states_come_behind_its_rows() {
    let mut feeds = vec![
        Feed::Gripper(Gripper { force_max_n: Some(30.0), ..Gripper::NONE }),
        Feed::Rows(rows(900_000, 1000, &[1.0; 90])),
        Feed::State(state(0.98)),
        Feed::Rows(rows(1_000_000, 1000, &[1.0; 11])),
        behind_gap(1_250_000, 10),
    ];
    feeds.extend(states(&[0.99, 1.0, 1.255, 1.258]));
    let model = model(feeds);
    for channel in [Channel::Statistic, Channel::Command, Channel::ForceLimit] {
        assert_eq!(breaks(&model, channel), [1.255], "{channel:?}");
    }
    assert_eq!(model.series(Channel::Statistic).unwrap().at(1.1), None);
    assert_eq!(model.series(Channel::Statistic).unwrap().at(0.985), Some(300.0));
}

#[test]
fn every_gap_of_a_batch_opens_the_curves_of_states() {
    let mut feeds = vec![
        Feed::Rows(rows(1_000_000, 1000, &[1.0; 11])),
        behind_gap(1_100_000, 11),
        behind_gap(1_300_000, 11),
    ];
    feeds.extend(states(&[1.005, 1.01, 1.1, 1.11, 1.305, 1.309]));
    assert_eq!(breaks(&model(feeds), Channel::Statistic), [1.1, 1.305]);
}

#[test]
fn nothing_is_missing_before_the_first_rows() {
    let mut feeds = states(&[0.98, 0.99]);
    feeds.push(Feed::Preview(rows(5_000_000, 1000, &[1.0; 10])));
    feeds.push(behind_gap(1_000_000, 11));
    feeds.extend(states(&[1.0, 1.01]));
    let model = model(feeds);
    assert_eq!(breaks(&model, Channel::Statistic), [0.0; 0]);
    assert!(model.events().marks.iter().all(|mark| mark.kind != EventKind::Gap));
}

const OWN: [Channel; 9] = [
    Channel::Band0,
    Channel::OwnStatistic,
    Channel::OwnEsc,
    Channel::EscLow,
    Channel::EscHigh,
    Channel::OwnEstimate,
    Channel::EstimateLow,
    Channel::EstimateHigh,
    Channel::SlipSpeed,
];

/// What is derived each few milliseconds, and while an object slips.
fn derived(broken: bool, bands: &[f64], evidences: &[f64]) -> Feed {
    let mut block = DerivedBlock { broken, ..DerivedBlock::default() };
    let (of_bands, of_slips) = OWN.split_at(2);
    for (times, channels) in [(bands, of_bands), (evidences, of_slips)] {
        times.iter().for_each(|t_s| block.put(*t_s, channels.iter().map(|of| (*of, 1.0))));
    }
    Feed::Derived(Box::new(block))
}

#[test]
fn everything_derived_opens_behind_a_gap_that_is_short() {
    let model = model([
        Feed::Rows(rows(1_000_000, 1000, &[1.0; 11])),
        derived(false, &[1.004, 1.008], &[1.005, 1.008]),
        behind_gap(1_200_000, 11),
        // The first evidence behind the gap comes a block later than the first bands.
        derived(true, &[1.204, 1.208], &[]),
        Feed::Rows(rows(1_211_000, 1000, &[1.0; 10])),
        derived(false, &[1.212, 1.216], &[1.214, 1.218]),
    ]);
    for channel in OWN {
        let is_evidence = !breaks(&model, channel).contains(&1.204);
        let expected = if is_evidence { 1.214 } else { 1.204 };
        assert_eq!(breaks(&model, channel), [expected], "{channel:?}");
    }
    assert_eq!(breaks(&model, Channel::OwnEsc), [1.214]);
}

#[test]
fn another_observer_opens_what_is_derived_though_no_sample_is_missing() {
    let model = model([
        Feed::Rows(rows(1_000_000, 1000, &[1.0; 40])),
        derived(false, &[1.004, 1.008], &[1.005, 1.008]),
        derived(true, &[1.012, 1.016], &[1.013, 1.016]),
        derived(false, &[1.02, 1.024], &[1.021, 1.024]),
        Feed::State(state(1.005)),
        Feed::State(state(1.025)),
    ]);
    assert_eq!(breaks(&model, Channel::Band0), [1.012]);
    assert_eq!(breaks(&model, Channel::SlipSpeed), [1.013]);
    assert_eq!(breaks(&model, Channel::Statistic), [0.0; 0]);
}

/// Rows of the stylus, and of the travel where it is there.
fn with_travel(from_us: u64, broken: bool, travel: bool) -> Feed {
    let mut block = rows(from_us, 1000, &[1.0; 10]);
    if travel {
        block.columns.push((Channel::Travel, vec![2.0; 10]));
    }
    Feed::Rows(RowBlock { broken, ..block })
}

#[test]
fn a_channel_that_is_missing_for_whole_blocks_is_open_there() {
    let model = model([
        with_travel(1_000_000, false, true),
        with_travel(1_010_000, false, true),
        with_travel(1_020_000, false, false),
        with_travel(1_030_000, false, false),
        with_travel(1_040_000, false, true),
        with_travel(1_050_000, false, true),
    ]);
    assert_eq!(breaks(&model, Channel::Travel), [1.04]);
    assert_eq!(breaks(&model, Channel::Stylus), [0.0; 0]);
    let travel = model.series(Channel::Travel).unwrap();
    assert_eq!((travel.at(1.019), travel.at(1.03), travel.at(1.04)), (Some(2.0), None, Some(2.0)));
}

#[test]
fn a_channel_that_is_missing_right_behind_a_gap_is_open_until_it_is_there() {
    let model = model([
        with_travel(1_000_000, false, true),
        with_travel(1_100_000, true, false),
        with_travel(1_110_000, false, true),
    ]);
    assert_eq!(breaks(&model, Channel::Stylus), [1.1]);
    assert_eq!(breaks(&model, Channel::Travel), [1.11]);
}

#[test]
fn a_gap_before_rows_that_cannot_be_shown_is_one_before_the_next_that_can() {
    let model = model([
        Feed::Rows(rows(1_000_000, 1000, &[1.0; 11])),
        behind_gap(1_005_000, 2),
        Feed::Rows(rows(1_100_000, 1000, &[1.0; 11])),
    ]);
    assert_eq!(model.health().late_rows, 2);
    assert_eq!(breaks(&model, Channel::Stylus), [1.1]);
}
