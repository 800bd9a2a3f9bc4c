//! The history against naive scans, its bounds in bytes, and everything that sources should not send.

use super::series::Series;
use super::{Bucket, Doing, Model};
use crate::feed::{EventKind, EventMark, Feed, ObserverSettings, RowBlock, SourceStatus};
use crate::{Channel, Span};
use grip_link::device::{Fate, Truth};
use grip_link::message::daemon::{GripState, Scene, SensorHealth};
use proptest::prelude::{
    Just, Strategy, TestCaseError, any, prop_assert, prop_assert_eq, prop_oneof, proptest,
};
use slip_core::{PipelineState, units::Micros};

/// Times (us) and values: mostly even, sometimes not, sometimes with gaps.
fn samples() -> impl Strategy<Value = Vec<(u64, f32, bool)>> {
    let step = prop_oneof![20 => Just(50_u64), 2 => 1_u64..200, 1 => 1000_u64..100_000];
    let value = prop_oneof![
        30 => -1.0_f32..1.0,
        1 => Just(f32::NAN),
        1 => Just(1e30_f32),
        1 => Just(f32::NEG_INFINITY),
        1 => any::<f32>(),
    ];
    let one = (step, value, proptest::bool::weighted(0.002));
    proptest::collection::vec(one, 1..6000).prop_map(|steps| {
        let mut t_us = 1_000_000;
        let row = |(step, value, broken)| {
            t_us += step;
            (t_us, value, broken)
        };
        steps.into_iter().map(row).collect()
    })
}

fn seconds(us: u64) -> f64 {
    us as f64 / 1e6
}

fn series_of(samples: &[(u64, f32, bool)]) -> Series {
    let mut series = Series::new(Channel::Stylus);
    samples.iter().for_each(|(t, value, broken)| series.push(seconds(*t), *value, *broken));
    series
}

/// Extremes and finite count of samples.
fn naive<'a>(samples: impl IntoIterator<Item = &'a (f64, f32)>) -> (u64, f32, f32) {
    let values = samples.into_iter().map(|(_, v)| *v).filter(|v| v.is_finite());
    values.fold((0, f32::INFINITY, f32::NEG_INFINITY), |(n, low, high), v| {
        (n + 1, low.min(v), high.max(v))
    })
}

/// Takes the finite samples in order, each once, as many for a part as it counts: they must be those of its time, but for 16 at its borders,
/// and their extremes the part's.
fn scan(parts: &[Bucket], times: &[(f64, f32)], span: Span) -> Result<(), TestCaseError> {
    let inside = times.iter().filter(|(t, v)| span.holds(*t) && v.is_finite());
    let mut rest: Vec<(f64, f32)> = inside.copied().collect();
    for part in parts.iter().filter(|part| part.count > 0) {
        let count = usize::try_from(part.count).unwrap();
        prop_assert!(count <= rest.len(), "{} more than {}", count, rest.len());
        let taken: Vec<(f64, f32)> = rest.drain(..count).collect();
        let (_, low, high) = naive(&taken);
        prop_assert_eq!((part.min, part.max), (low, high));
        let early = taken.iter().filter(|(t, _)| *t < part.from_s - 1e-9).count();
        let late = taken.iter().filter(|(t, _)| *t > part.to_s + 1e-9).count();
        prop_assert!(early <= 16 && late <= 16, "{} {} of {:?}", early, late, part);
    }
    prop_assert_eq!(rest.len(), 0);
    Ok(())
}

proptest! {
    #![proptest_config(proptest::test_runner::Config::with_cases(128))]

    #[test]
    fn an_envelope_is_a_scan_of_all_samples(
        samples in samples(),
        (from, length) in (0.0_f64..1.0, 0.0_f64..1.2),
        columns in prop_oneof![1_usize..12, 1_usize..300],
    ) {
        let series = series_of(&samples);
        // Even times are kept to a part of a microsecond: the scan uses the same ones.
        let all = series.span().unwrap();
        let times = kept(&series);
        prop_assert_eq!(times.len(), samples.len());
        for ((t, ..), (kept, _)) in samples.iter().zip(&times) {
            prop_assert!((seconds(*t) - kept).abs() <= 2.1e-6, "{} {}", t, kept);
        }
        let from_s = all.from_s - 0.01 + from * all.length_s();
        let span = Span::new(from_s, from_s + 1e-6 + length * all.length_s());
        let mut parts = Vec::new();
        series.envelope(span, columns, &mut parts);
        prop_assert!(parts.len() <= columns);
        scan(&parts, &times, span)?;
        let (count, low, high) = naive(times.iter().filter(|(t, _)| span.holds(*t)));
        let stats = series.stats(span);
        prop_assert_eq!(stats.map_or(0, |stats| stats.count), count);
        if let Some(stats) = stats {
            prop_assert_eq!((stats.min, stats.max), (low, high));
        }
    }

    #[test]
    fn parts_of_few_samples_are_exact(from_us in 0_u32..100_000, per_part in 1_u32..255, columns in 2_usize..200) {
        let samples: Vec<(u64, f32, bool)> =
            (0_u16..5000).map(|k| (1_000_000 + 50 * u64::from(k), f32::from(k), false)).collect();
        let series = series_of(&samples);
        let times = kept(&series);
        let length_s = 50e-6 * f64::from(per_part) * f64::from(u32::try_from(columns).unwrap());
        let from_s = 1.0 + f64::from(from_us) / 1e6;
        let mut parts = Vec::new();
        series.envelope(Span::new(from_s, from_s + length_s), columns, &mut parts);
        let (_, but_the_last) = parts.split_last().unwrap();
        for part in but_the_last {
            let inside = times.iter().filter(|(t, _)| (part.from_s..part.to_s).contains(t));
            prop_assert_eq!((part.count, part.min, part.max), naive(inside));
        }
    }
}

/// Every sample with the time at which it is kept.
fn kept(series: &Series) -> Vec<(f64, f32)> {
    let store = &series.store;
    (store.first()..store.end()).map(|n| (store.time(n).unwrap(), store.value(n))).collect()
}

pub(super) fn rows(from_us: u64, step_us: u64, values: &[f32]) -> RowBlock {
    let times_us = (0..).map(|k| from_us + k * step_us).take(values.len()).collect();
    let columns = vec![(Channel::Stylus, values.to_vec())];
    RowBlock { times_us, columns, ..RowBlock::default() }
}

pub(super) fn state(t_s: f64) -> PipelineState {
    PipelineState {
        t: Micros::from_seconds(t_s),
        scene: Scene::Holding,
        grip: GripState::Holding,
        statistic: Some(0.5),
        command_n: Some(2.0),
        rate_hz: 1000,
        ..PipelineState::UNKNOWN
    }
}

fn kinds(model: &Model) -> Vec<EventKind> {
    model.events().marks.iter().map(|mark| mark.kind).collect()
}

/// The needed force of states is a fan of three curves, open where it is not known.
#[test]
fn a_fan_of_the_needed_force_has_three_curves_and_is_open_where_nothing_is_known() {
    const FAN: [Channel; 3] = [Channel::NeedLow, Channel::Need, Channel::NeedHigh];
    let mut model = Model::new(1 << 20);
    model.take(Feed::Rows(rows(1_000_000, 1000, &[1.0; 400])));
    model.take(Feed::State(state(1.0)));
    assert!(FAN.iter().all(|channel| model.series(*channel).is_none()));
    for k in 1..=30_u8 {
        let need_n = (!(11..=20).contains(&k)).then_some(f32::from(k));
        let scaled = |times: f32| need_n.map(|need_n| times * need_n);
        model.take(Feed::State(PipelineState {
            need_low_n: scaled(0.5),
            need_n,
            need_high_n: scaled(1.5),
            admissible_m_s2: Some(2.0),
            ..state(1.0 + 0.01 * f64::from(k))
        }));
    }
    let at = |channel, t_s| model.series(channel).and_then(|series: &Series| series.at(t_s));
    for (t_s, need_n) in [(1.05, 5.0), (1.3, 30.0)] {
        let found = FAN.map(|channel| at(channel, t_s));
        assert_eq!(found, [0.5 * need_n, need_n, 1.5 * need_n].map(Some), "at {t_s} s");
    }
    for channel in FAN {
        assert!(at(channel, 1.15).is_none_or(f32::is_nan), "{channel:?}");
        let series = model.series(channel).unwrap();
        let mut parts = Vec::new();
        series.envelope(Span::new(1.0, 1.31), 62, &mut parts);
        let known = parts.iter().filter(|part| part.count > 0);
        let open = |part: &Bucket| (1.105..1.205).contains(&f64::midpoint(part.from_s, part.to_s));
        assert_eq!(known.clone().map(|part| part.count).sum::<u64>(), 20, "{channel:?}");
        assert!(known.clone().all(|part| part.min.is_finite() && part.max.is_finite()));
        assert!(!known.clone().any(open), "{channel:?}");
    }
}

#[test]
fn a_spike_of_one_sample_is_seen_at_every_zoom_of_an_hour() {
    let mut series = Series::new(Channel::Stylus);
    let (rate, hour_s) = (2000_u32, 3600_u32);
    let spike = 5_000_123;
    for k in 0..rate * hour_s {
        let value = if k == spike { 1.0 } else { 1e-3 };
        series.push(f64::from(k) / f64::from(rate), value, false);
    }
    let at_s = f64::from(spike) / f64::from(rate);
    let mut parts = Vec::new();
    for (width_s, columns) in [(3600.0, 1), (3600.0, 1920), (600.0, 77), (1.0, 1000), (0.01, 3)] {
        let span = Span::new(at_s - 0.3 * width_s, at_s + 0.7 * width_s);
        series.envelope(span, columns, &mut parts);
        let seen = parts.iter().filter(|part| part.max == 1.0).count();
        assert_eq!(seen, 1, "{width_s} s in {columns}");
    }
    assert_eq!(series.at(at_s), Some(1.0));
    let stats = series.stats(Span::new(0.0, 3600.0)).unwrap();
    assert_eq!((stats.max, stats.count), (1.0, u64::from(rate * hour_s)));
    let exact = 1e-3 + 0.999 / f64::from(rate * hour_s);
    assert!((stats.mean / exact - 1.0).abs() < 1e-5, "{}", stats.mean);
}

#[test]
fn memory_stays_within_its_bound_and_the_oldest_go_first() {
    let limit = 4_000_000;
    let mut model = Model::new(limit);
    let mut time_us = 0;
    for block in 0..1000_u16 {
        let mut values = vec![f32::from(block); 1000];
        values[417] = if block % 7 == 0 { f32::NAN } else { -1.0 };
        let mut rows = rows(time_us, 50, &values);
        rows.broken = block % 10 == 0;
        rows.columns.push((Channel::NormalForce, values));
        time_us += 50_000;
        model.take(Feed::Rows(rows));
        assert!(model.bytes() <= limit, "{} at block {block}", model.bytes());
    }
    let series = model.series(Channel::Stylus).unwrap();
    let (have, kept) = (series.span().unwrap(), kept(series));
    assert!(have.from_s > 20.0 && have.from_s < 40.0 && (have.to_s - 49.99995).abs() < 1e-9);
    // What the pyramid knows is what a look at each sample shows, behind what was dropped too.
    for span in [have, Span::new(0.0, 35.0), Span::new(36.0, 49.3), Span::new(49.0, 49.002)] {
        let stats = series.stats(span).map(|stats| (stats.count, stats.min, stats.max));
        let wanted = naive(kept.iter().filter(|(t, _)| span.holds(*t)));
        assert_eq!(stats.unwrap_or((0, f32::INFINITY, f32::NEG_INFINITY)), wanted, "{span:?}");
    }
}

#[test]
fn a_reading_at_an_even_rate_takes_five_bytes() {
    let mut series = Series::new(Channel::Stylus);
    let count = 1 << 20;
    (0..count).for_each(|k| series.push(f64::from(k) * 50e-6, 1.0, false));
    let bytes = series.bytes() as f64 / f64::from(count);
    assert!(bytes < 5.5, "{bytes}");
}

#[test]
fn time_that_goes_back_begins_another_run_and_single_late_rows_are_left_out() {
    let mut model = Model::new(1 << 24);
    model.take(Feed::Rows(rows(5_000_000, 1000, &[1.0; 100])));
    let mut late = rows(5_100_000, 1000, &[2.0; 10]);
    late.times_us[4] = 5_090_000;
    model.take(Feed::Rows(late));
    assert_eq!(model.health().late_rows, 1);
    assert!(model.is_device_time());
    model.take(Feed::State(state(5.1)));
    model.take(Feed::Rows(rows(20_000, 1000, &[3.0; 100])));
    assert_eq!(kinds(&model), [EventKind::Clock]);
    let text = &model.events().marks.iter().next().unwrap().text;
    assert!(text.contains("5.109") && text.contains("0.020"), "{text}");
    let series = model.series(Channel::Stylus).unwrap();
    let span = series.span().unwrap();
    assert!((span.from_s - 5.0).abs() < 1e-9 && (span.to_s - 6.208).abs() < 1e-9, "{span:?}");
    assert_eq!(series.latest().unwrap().1, 3.0);
    let mut parts = Vec::new();
    series.envelope(Span::new(6.0, 6.3), 3, &mut parts);
    assert!(parts.iter().any(|part| part.broken));
    assert!(!model.is_device_time());
    // A state of the run before is left out, one of this run is not.
    model.take(Feed::State(state(5.11)));
    model.take(Feed::State(state(0.11)));
    assert_eq!(model.health().stray_states, 1);
    assert!((model.series(Channel::Statistic).unwrap().latest().unwrap().0 - 6.199).abs() < 1e-9);
}

#[test]
fn a_statistic_is_evidence_in_seconds_of_the_interval_in_force() {
    let mut model = Model::new(1 << 24);
    let evidence_s = |model: &Model| model.series(Channel::Statistic).unwrap().latest().unwrap().1;
    model.take(Feed::State(state(1.0)));
    assert_eq!((evidence_s(&model), model.info().interval_s()), (300.0, 600.0));
    model.take(Feed::Observes(ObserverSettings::Source { interval_s: 60.0 }));
    model.take(Feed::State(state(1.1)));
    assert_eq!((evidence_s(&model), model.info().evidence_axis()), (30.0, [1e-4, 600.0]));
}

#[test]
fn readings_that_are_none_leave_gaps_and_huge_ones_do_not_set_the_scale() {
    let mut model = Model::new(1 << 24);
    let mut values: Vec<f32> = (0..1000_u16).map(|k| 1e-6 * f32::from(k % 10)).collect();
    (values[100], values[200], values[300]) = (f32::NAN, 1e30, f32::INFINITY);
    model.take(Feed::Rows(rows(0, 1000, &values)));
    let series = model.series(Channel::Stylus).unwrap();
    let all = series.span().unwrap();
    assert_eq!(model.health().huge, 2);
    let (low, high) = series.robust_range(all).unwrap();
    assert!(low == 0.0 && (high - 9e-6).abs() < 1e-9, "{low} {high}");
    assert_eq!(series.stats(all).unwrap().max, 1e30);
    let mut parts = Vec::new();
    series.envelope(all, 10, &mut parts);
    let broken: Vec<bool> = parts.iter().map(|part| part.broken).collect();
    assert_eq!(broken.iter().filter(|broken| **broken).count(), 2, "{broken:?}");
    assert!(series.at(0.1).unwrap().is_nan());
}

#[test]
fn lost_rows_are_a_gap_among_the_events() {
    let mut model = Model::new(1 << 24);
    model.take(Feed::Rows(rows(0, 1000, &[1.0; 50])));
    model.take(Feed::Rows(RowBlock { broken: true, lost: 10, ..rows(60_000, 1000, &[1.0; 50]) }));
    assert_eq!(kinds(&model), [EventKind::Gap]);
    assert_eq!(model.events().marks.iter().next().unwrap().text, "10 rows are missing, 11.0 ms");
    let gaps: Vec<Span> =
        model.events().gaps.within(Span::new(0.0, 1.0)).map(|stretch| stretch.span).collect();
    assert_eq!(gaps, [Span::new(0.049, 0.06)]);
    let series = model.series(Channel::Stylus).unwrap();
    assert_eq!([0.0495, 0.055, 0.06].map(|t_s| series.at(t_s)), [Some(1.0), None, Some(1.0)]);
}

#[test]
fn faults_reflexes_and_scenes_come_from_the_states() {
    let mut model = Model::new(1 << 24);
    model.take(Feed::State(state(1.0)));
    let slipping = PipelineState {
        scene: Scene::Slipping,
        grip: GripState::Slipping,
        command_n: Some(2.2),
        ..state(1.1)
    };
    model.take(Feed::State(slipping));
    let mut ill = state(1.2);
    ill.sensors[0] = SensorHealth::Frozen;
    model.take(Feed::State(ill));
    model.take(Feed::State(PipelineState { t: Micros(1_250_000), ..ill }));
    model.take(Feed::State(state(1.3)));
    assert_eq!(kinds(&model), [EventKind::Reflex, EventKind::Fault, EventKind::Recovered]);
    let all = Span::new(0.0, 9.0);
    let doings: Vec<(Doing, f64, f64)> = model
        .events()
        .doings
        .within(all)
        .map(|stretch| (stretch.what, stretch.span.from_s, stretch.span.to_s))
        .collect();
    let [holding, slipping] = [Doing::Held, Doing::Slipping];
    assert_eq!(doings, [(holding, 1.0, 1.1), (slipping, 1.1, 1.2), (holding, 1.2, 1.3)]);
    let faults: Vec<Span> = model.events().faults.within(all).map(|stretch| stretch.span).collect();
    assert_eq!(faults, [Span::new(1.2, 1.3)]);
}

#[test]
fn what_a_simulator_knows_of_the_object_stands_over_what_the_pipeline_thinks() {
    let mut model = Model::new(1 << 24);
    let fates = [None, Some(Fate::Held), Some(Fate::Crushed), Some(Fate::Dropped)];
    for (k, fate) in (0_u8..).zip(fates) {
        model.take(Feed::Truth(Truth { needed_n: 7.0, fate }));
        model.take(Feed::State(state(1.0 + 0.1 * f64::from(k))));
    }
    // Also while the arm moves.
    model.take(Feed::Truth(Truth { needed_n: 7.0, fate: Some(Fate::Slipping) }));
    model.take(Feed::State(PipelineState { scene: Scene::Moving, ..state(1.35) }));
    // Without a truth the pipeline decides, and the needed force is open.
    model.take(Feed::State(state(1.4)));
    let all = Span::new(0.0, 9.0);
    let doings: Vec<Doing> =
        model.events().doings.within(all).map(|stretch| stretch.what).collect();
    let what = [Doing::Held, Doing::Crushed, Doing::Dropped, Doing::Slipping, Doing::Held];
    assert_eq!(doings, what);
    let need = model.series(Channel::NeedTruth).unwrap();
    assert!(need.at(1.25) == Some(7.0) && need.latest().unwrap().1.is_nan());
}

#[test]
fn events_are_found_from_any_time_on() {
    let mut model = Model::new(1 << 24);
    model.take(Feed::Rows(rows(1_000_000, 1000, &[1.0; 1500])));
    for (t_s, kind) in
        [(1.5, EventKind::Incipient), (1.6, EventKind::Gross), (1.9, EventKind::Ended)]
    {
        model.take(Feed::Event(EventMark::plain(t_s, kind, "x")));
    }
    model.mark(1.7, "here");
    assert_eq!(model.events().marks.from(1.61).unwrap().kind, EventKind::Marker);
    assert_eq!(model.events().marks.at(1.59).unwrap().kind, EventKind::Incipient);
    assert!(model.events().marks.from(1.91).is_none());
    assert_eq!(model.events().marks.within(Span::new(1.6, 1.8)).count(), 2);
    let slips: Vec<(EventKind, Span)> = model
        .events()
        .slips
        .within(Span::new(0.0, 9.0))
        .map(|stretch| (stretch.what, stretch.span))
        .collect();
    let (first, second) = (Span::new(1.5, 1.6), Span::new(1.6, 1.9));
    assert_eq!(slips, [(EventKind::Incipient, first), (EventKind::Gross, second)]);
}

#[test]
fn the_revision_changes_with_what_is_seen_and_only_then() {
    let mut model = Model::new(1 << 24);
    model.take(Feed::Status(SourceStatus::Live));
    let before = model.revision();
    model.take(Feed::Status(SourceStatus::Live));
    assert_eq!(model.revision(), before);
    model.take(Feed::Status(SourceStatus::Idle));
    assert_ne!(model.revision(), before);
}

#[test]
fn a_preview_shows_what_is_not_loaded_yet_and_goes_when_all_is() {
    let mut model = Model::new(1 << 24);
    model.take(Feed::Preview(rows(5_000_000, 1000, &[7.0; 10])));
    model.take(Feed::Rows(rows(0, 1000, &[1.0; 1000])));
    let envelope = |model: &Model| {
        let mut parts = Vec::new();
        let series = model.series(Channel::Stylus).unwrap();
        series.envelope(Span::new(0.0, 10.0), 10, &mut parts);
        parts.iter().map(|part| part.max).collect::<Vec<_>>()
    };
    assert_eq!(envelope(&model), [1.0, 7.0]);
    assert!((model.span().unwrap().to_s - 5.009).abs() < 1e-9);
    model.take(Feed::Status(SourceStatus::Complete { note: String::new() }));
    assert_eq!(envelope(&model), [1.0]);
}

proptest! {
    #![proptest_config(proptest::test_runner::Config::with_cases(200))]

    #[test]
    fn whatever_a_source_sends_the_axis_goes_on_and_memory_is_bounded(
        blocks in proptest::collection::vec(
            (prop_oneof![3 => 0_u64..10_000_000, 1 => any::<u64>()], 0_u64..5000, 1_usize..2000, any::<f32>(), any::<bool>()),
            1..40,
        ),
        states in proptest::collection::vec(prop_oneof![3 => 0.0_f64..10.0, 1 => any::<f64>()], 0..40),
    ) {
        let limit = 500_000;
        let mut model = Model::new(limit);
        let mut states = states.into_iter();
        let mut end_s = 0.0;
        for (from_us, step_us, count, value, broken) in blocks {
            let times_us = (0..count as u64).map(|k| from_us.wrapping_add(k * step_us)).collect();
            let columns = vec![(Channel::Stylus, vec![value; count])];
            model.take(Feed::Rows(RowBlock { times_us, columns, broken, ..RowBlock::default() }));
            if let Some(t_s) = states.next() {
                model.take(Feed::State(state(t_s)));
                model.take(Feed::Event(EventMark::plain(t_s, EventKind::Link, "x")));
            }
            prop_assert!(model.end_s() >= end_s && model.end_s().is_finite());
            end_s = model.end_s();
            // What is being worked on: one open chunk of each channel, and the events.
            prop_assert!(model.bytes() <= limit + 200_000, "{}", model.bytes());
        }
        let mut parts = Vec::new();
        for channel in model.channels() {
            let series = model.series(channel).unwrap();
            if let Some(span) = series.span() {
                prop_assert!(span.from_s <= span.to_s);
                series.envelope(span, 100, &mut parts);
                prop_assert!(parts.windows(2).all(|pair| pair[0].to_s <= pair[1].from_s + 1e-9));
                let range = series.robust_range(span);
                prop_assert!(range.is_none_or(|(low, high)| low <= high));
            }
        }
        prop_assert!(model.events().marks.iter().all(|mark| mark.t_s.is_finite()));
    }
}
