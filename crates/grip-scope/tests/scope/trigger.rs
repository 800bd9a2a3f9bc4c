//! Triggers: what is found, what is shown before and behind it, and how often.

use grip_scope::feed::{EventKind, EventMark, RowBlock};
use grip_scope::trigger::{Condition, Found, TriggerMode, TriggerSettings};
use grip_scope::{Channel, Feed, Model, Trigger};

/// A tenth of a second of a stylus that is 0 but for one sample.
fn tenth(model: &mut Model, number: u64, spike: Option<usize>) {
    let times_us = (0..100).map(|k| number * 100_000 + k * 1000).collect();
    let mut values = vec![0.0; 100];
    if let Some(at) = spike {
        values[at] = 1.0;
    }
    let columns = vec![(Channel::Stylus, values)];
    model.take(Feed::Rows(RowBlock { times_us, columns, ..RowBlock::default() }));
}

/// Waits for the stylus at 0.5.
fn stylus(condition: Condition, before_s: f64, window_s: f64) -> TriggerSettings {
    let (channel, level) = (Channel::Stylus, 0.5);
    TriggerSettings { condition, channel, level, before_s, window_s, ..TriggerSettings::default() }
}

fn rising(mode: TriggerMode) -> Trigger {
    Trigger::new(TriggerSettings { mode, ..stylus(Condition::RisingEdge, 0.05, 0.2) })
}

fn event(event: EventKind) -> TriggerSettings {
    TriggerSettings { event, before_s: 0.05, window_s: 0.1, ..TriggerSettings::default() }
}

fn run(trigger: &mut Trigger, spikes: &[(u64, usize)]) -> Vec<Found> {
    let mut model = Model::new(1 << 24);
    let mut shown = Vec::new();
    for number in 0..20 {
        let spike = spikes.iter().find(|spike| spike.0 == number).map(|spike| spike.1);
        tenth(&mut model, number, spike);
        shown.extend(trigger.poll(&model));
    }
    shown
}

fn near(found: &Found, from_s: f64, to_s: f64) -> bool {
    let (Found::Hit(span) | Found::Sweep(span)) = found;
    (span.from_s - from_s).abs() < 1e-9 && (span.to_s - to_s).abs() < 1e-9
}

#[test]
fn a_level_is_found_with_what_came_before_it() {
    let shown = run(&mut rising(TriggerMode::Normal), &[(3, 40), (9, 0)]);
    assert_eq!(shown.len(), 2, "{shown:?}");
    assert!(near(&shown[0], 0.29, 0.49) && near(&shown[1], 0.85, 1.05), "{shown:?}");
}

#[test]
fn a_single_trigger_shows_what_it_finds_once() {
    let mut single = rising(TriggerMode::Single);
    assert_eq!(run(&mut single, &[(3, 40), (9, 0)]).len(), 1);
    assert!(single.is_done());
}

#[test]
fn an_automatic_trigger_shows_the_newest_where_nothing_is_found() {
    let shown = run(&mut rising(TriggerMode::Auto), &[]);
    assert!(shown.len() > 10, "{shown:?}");
    let last = shown.last().unwrap();
    assert!(near(last, 1.799, 1.999), "{last:?}");
    let shown = run(&mut rising(TriggerMode::Auto), &[(9, 0)]);
    let hits: Vec<&Found> = shown.iter().filter(|found| matches!(found, Found::Hit(_))).collect();
    assert!(hits.len() == 1 && near(hits[0], 0.85, 1.05), "{shown:?}");
    assert!(run(&mut rising(TriggerMode::Normal), &[]).is_empty());
}

#[test]
fn an_event_is_found_and_the_past_is_not() {
    let mut model = Model::new(1 << 24);
    tenth(&mut model, 0, None);
    model.take(Feed::Event(EventMark::plain(0.05, EventKind::Gross, "old")));
    let mut trigger = waiting(&model, EventKind::Gross);
    tenth(&mut model, 1, None);
    model.take(Feed::Event(EventMark::plain(0.15, EventKind::Gross, "new")));
    model.take(Feed::Event(EventMark::plain(0.16, EventKind::Gap, "other")));
    assert_eq!(trigger.poll(&model), None);
    tenth(&mut model, 2, None);
    assert!(near(&trigger.poll(&model).unwrap(), 0.1, 0.2));
    assert_eq!(trigger.poll(&model), None);
    // What is there already is found where it is asked for.
    let found = [0.0, 0.05, 0.15].map(|from_s| event(EventKind::Gross).first_after(&model, from_s));
    assert_eq!(found, [Some(0.05), Some(0.15), None]);
}

/// A trigger on this kind, looked at once before anything happens.
fn waiting(model: &Model, kind: EventKind) -> Trigger {
    let mut trigger = Trigger::new(event(kind));
    assert_eq!(trigger.poll(model), None);
    trigger
}

#[test]
fn events_are_found_however_the_looks_fall_between_rows_and_events() {
    let mut model = Model::new(1 << 24);
    let mut trigger = waiting(&model, EventKind::Gross);
    let mut hits = Vec::new();
    for number in 0..10 {
        tenth(&mut model, number, None);
        hits.extend(trigger.poll(&model));
        if number == 4 || number == 7 {
            // The rows of that time, and those after it, were looked at before it came.
            let t_s = 0.1 * number as f64 + 0.01;
            model.take(Feed::Event(EventMark::plain(t_s, EventKind::Gross, "late")));
            hits.extend(trigger.poll(&model));
        }
    }
    assert!(hits.len() == 2, "{hits:?}");
    assert!(near(&hits[0], 0.36, 0.46) && near(&hits[1], 0.66, 0.76), "{hits:?}");
}

#[test]
fn a_gap_and_a_mark_in_the_past_are_found() {
    let mut model = Model::new(1 << 24);
    tenth(&mut model, 0, None);
    let (mut gap, mut marker) =
        (waiting(&model, EventKind::Gap), waiting(&model, EventKind::Marker));
    // The gap stands where the rows ended before it, which is how far the trigger has looked.
    let columns = vec![(Channel::Stylus, vec![0.0; 100])];
    let times_us = (0..100).map(|k| 300_000 + k * 1000).collect();
    model.take(Feed::Rows(RowBlock { times_us, columns, broken: true, ..RowBlock::default() }));
    assert!(near(&gap.poll(&model).unwrap(), 0.049, 0.149));
    assert_eq!(gap.poll(&model), None);
    assert_eq!(marker.poll(&model), None);
    model.mark(0.05, "here");
    assert!(near(&marker.poll(&model).unwrap(), 0.0, 0.1));
    assert_eq!(marker.poll(&model), None);
}

#[test]
fn of_events_that_come_together_each_outside_the_window_shown_is_found() {
    let mut model = Model::new(1 << 24);
    let mut trigger = waiting(&model, EventKind::Gross);
    (0..6).for_each(|number| tenth(&mut model, number, None));
    for t_s in [0.1, 0.12, 0.3] {
        model.take(Feed::Event(EventMark::plain(t_s, EventKind::Gross, "x")));
    }
    let hits: Vec<Found> = (0..5).filter_map(|_| trigger.poll(&model)).collect();
    assert!(hits.len() == 2, "{hits:?}");
    assert!(near(&hits[0], 0.05, 0.15) && near(&hits[1], 0.25, 0.35), "{hits:?}");
}

/// Ten thousand rows at 10 kHz for each value, one block after the other.
fn seconds(model: &mut Model, values: &[f32], spikes: &[usize]) {
    for (second, value) in (0..).zip(values) {
        let mut rows = vec![*value; 10_000];
        for row in spikes.iter().filter(|row| **row / 10_000 == second) {
            rows[*row % 10_000] = 1.0;
        }
        let times_us = (0..10_000).map(|row| 1_000_000 * second as u64 + 100 * row).collect();
        let columns = vec![(Channel::Stylus, rows)];
        model.take(Feed::Rows(RowBlock { times_us, columns, ..RowBlock::default() }));
    }
}

#[test]
fn edges_and_levels_are_found_to_the_sample_in_a_long_history() {
    let mut model = Model::new(1 << 24);
    seconds(&mut model, &[0.0; 100], &[300_123, 300_500, 990_000]);
    for condition in [Condition::RisingEdge, Condition::Above] {
        let trigger = stylus(condition, 0.001, 0.005);
        let mut found = vec![0.0];
        while let Some(at_s) = trigger.first_after(&model, trigger.behind(found[found.len() - 1])) {
            found.push(at_s);
            assert!(found.len() < 10, "{found:?}");
        }
        let wanted = [0.0, 30.0123, 30.05, 99.0];
        assert!(found.len() == 4 && found.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-9));
    }
    // Downwards: behind each spike, not before the first one.
    let down = stylus(Condition::FallingEdge, 0.001, 0.005);
    assert!((down.first_after(&model, 0.0).unwrap() - 30.0124).abs() < 1e-9);
    assert!((down.first_after(&model, 98.5).unwrap() - 99.0001).abs() < 1e-9);
}

fn from_s(found: &Found) -> f64 {
    let (Found::Hit(span) | Found::Sweep(span)) = found;
    span.from_s
}

#[test]
fn a_level_is_found_without_an_edge_and_again_behind_each_window() {
    let mut model = Model::new(1 << 24);
    seconds(&mut model, &[1.0], &[]);
    let mut trigger = Trigger::new(stylus(Condition::Above, 0.05, 0.2));
    assert_eq!(trigger.poll(&model), None);
    let mut edge = rising(TriggerMode::Normal);
    assert_eq!(edge.poll(&model), None);
    let mut hits = Vec::new();
    for second in 1..3_u64 {
        for tenth in 0..10 {
            let from_us = 1_000_000 * second + 100_000 * tenth;
            let times_us = (0..1000).map(|row| from_us + 100 * row).collect();
            let columns = vec![(Channel::Stylus, vec![if second < 2 { 1.0 } else { 0.0 }; 1000])];
            model.take(Feed::Rows(RowBlock { times_us, columns, ..RowBlock::default() }));
            hits.extend(trigger.poll(&model));
            assert_eq!(edge.poll(&model), None);
        }
    }
    // Each window begins where the one before ends, for as long as it stays above.
    assert!(hits.len() >= 5 && hits.len() <= 7, "{hits:?}");
    assert!((from_s(&hits[0]) - 0.95).abs() < 1e-3, "{hits:?}");
    let apart = hits.windows(2).all(|two| from_s(&two[1]) + 0.051 >= from_s(&two[0]) + 0.2);
    assert!(apart, "{hits:?}");
}

#[test]
fn states_that_come_behind_the_rows_of_their_time_are_not_missed() {
    use grip_scope::feed::DerivedBlock;
    let mut model = Model::new(1 << 24);
    let rising = stylus(Condition::RisingEdge, 0.05, 0.1);
    let evidence = TriggerSettings { channel: Channel::OwnStatistic, level: 600.0, ..rising };
    let mut trigger = Trigger::new(evidence);
    let mut hits = Vec::new();
    for number in 0..10_u64 {
        tenth(&mut model, number, None);
        // The rows are looked at before what is derived from them is there.
        hits.extend(trigger.poll(&model));
        let mut block = DerivedBlock::default();
        for k in 0..10_u64 {
            let evidence_s = if (number, k) == (4, 3) { 900.0 } else { 0.1 };
            let t_s = 0.1 * number as f64 + 0.01 * k as f64;
            block.put(t_s, [(Channel::OwnStatistic, evidence_s)]);
        }
        model.take(Feed::Derived(Box::new(block)));
        hits.extend(trigger.poll(&model));
    }
    assert!(hits.len() == 1 && near(&hits[0], 0.38, 0.48), "{hits:?}");
}
