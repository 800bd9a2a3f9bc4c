//! Every control does what its label states.

use super::{fixture, window};
use eframe::egui::Key;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable as _;
use grip_scope::feed::{EventKind, EventMark, Feed};
use grip_scope::trigger::Condition;
use grip_scope::trigger::TriggerMode;
use gripmon::Scope;
use gripmon::layout::{Look, Panel};
use gripmon::time::Following;

pub(crate) fn click(harness: &mut Harness<'_, Scope>, label: &str) {
    harness.get_by_label(label).click();
    harness.run();
}

pub(crate) fn press(harness: &mut Harness<'_, Scope>, key: Key) {
    harness.key_press(key);
    harness.run();
}

fn seen(harness: &Harness<'_, Scope>) -> (f64, f64) {
    let scope = harness.state();
    let span = scope.state.window.visible(scope.shared.engine().model.span());
    (span.from_s, span.to_s)
}

#[test]
fn a_paused_view_stands_while_data_go_on() {
    let mut harness = window(fixture::grasp(), Panel::Health);
    press(&mut harness, Key::End);
    click(&mut harness, "Pause");
    assert!(harness.state().shared.engine().paused, "its source asks for no frames");
    let before = seen(&harness);
    let later = fixture::rows(&[grip_scope::Channel::Stylus], 10_000, 20_000, 30_000);
    harness.state().shared.engine().model.take(Feed::Rows(later));
    harness.run();
    assert_eq!(seen(&harness), before);
    click(&mut harness, "Follow");
    assert!(!harness.state().shared.engine().paused);
    assert!((seen(&harness).1 - 2.9999).abs() < 1e-6, "{:?}", seen(&harness));
    press(&mut harness, Key::Space);
    assert_eq!(harness.state().state.window.following(), Following::Held);
}

#[test]
fn events_are_jumped_to_forth_and_back() {
    let mut harness = window(fixture::grasp(), Panel::Health);
    let times: Vec<f64> =
        harness.state().shared.engine().model.events().marks.iter().map(|mark| mark.t_s).collect();
    assert!(times.len() >= 6);
    click(&mut harness, "Event >");
    assert_eq!(harness.state().state.event_s, Some(times[0]));
    press(&mut harness, Key::N);
    assert_eq!(harness.state().state.event_s, Some(times[1]));
    click(&mut harness, "< Event");
    let (from_s, to_s) = seen(&harness);
    assert_eq!(harness.state().state.event_s, Some(times[0]));
    assert!(from_s < times[0] && to_s > times[0]);
    press(&mut harness, Key::P);
    assert_eq!(harness.state().state.message.as_ref().unwrap().text, "No earlier event.");
    click(&mut harness, "Close message");
    assert!(harness.state().state.message.is_none());
}

#[test]
fn cursors_measure_what_lies_between_them() {
    let mut harness = window(fixture::grasp(), Panel::Cursors);
    harness.get_by_label("Set both cursors to measure what lies between them.");
    click(&mut harness, "Set A");
    click(&mut harness, "Set B");
    let scope = harness.state_mut();
    scope.state.cursors = [Some(1.0), Some(1.5)];
    harness.run();
    harness.get_by_label("500.0 ms");
    harness.get_by_label("2.000 Hz");
    let heading = |band: usize| {
        let name = grip_scope::Channel::BANDS[band].name();
        let places = harness.query_all_by_label(name).map(|node| node.rect().left_top());
        places.max_by(|a, b| a.x.total_cmp(&b.x)).unwrap()
    };
    assert!(heading(0).y < heading(1).y && heading(1).y < heading(5).y);
    // The spike of one sample is in the peak-to-peak value, to its last digit.
    assert!(harness.query_all_by_label_contains("2.0").count() >= 1);
    let stats = {
        let engine = harness.state().shared.engine();
        engine
            .model
            .series(grip_scope::Channel::Stylus)
            .unwrap()
            .stats(grip_scope::Span::new(1.0, 1.5))
            .unwrap()
    };
    assert!((stats.max - fixture::SPIKE_M).abs() < 1e-9 && fixture::SPIKE_US < 1_500_000);
    let text = grip_scope::format::with_unit(stats.peak_to_peak().into(), "m");
    harness.get_by_label_contains(&text);
    press(&mut harness, Key::Z);
    assert_eq!(seen(&harness), (1.0, 1.5));
    press(&mut harness, Key::C);
    assert_eq!(harness.state().state.cursors, [None; 2]);
}

#[test]
fn a_trigger_stops_at_what_it_waits_for_once() {
    let mut harness = window(fixture::grasp(), Panel::Trigger);
    click(&mut harness, "Single");
    assert_eq!(harness.state().state.layout.trigger.mode, TriggerMode::Single);
    let form = harness.state().state.layout.trigger;
    assert_eq!((form.condition, form.event), (Condition::Event, EventKind::Gross));
    click(&mut harness, "Arm");
    harness.get_by_label("armed, waiting");
    {
        let mut engine = harness.state().shared.engine();
        engine.look();
        let rows =
            |from, to| Feed::Rows(fixture::rows(&[grip_scope::Channel::Stylus], 10_000, from, to));
        engine.model.take(rows(20_000, 21_000));
        engine.model.take(Feed::Event(EventMark::plain(2.05, EventKind::Gross, "x")));
        engine.look();
        engine.model.take(rows(21_000, 30_000));
        engine.look();
    }
    harness.run();
    let (from_s, to_s) = seen(&harness);
    assert!((from_s - 1.95).abs() < 1e-6 && (to_s - 2.45).abs() < 1e-6, "{from_s} {to_s}");
    assert!(!harness.state().state.armed && harness.state().state.triggered == 1);
}

/// A tenth of a second more, and what the trigger makes of it.
fn tenth(harness: &mut Harness<'_, Scope>, number: usize) {
    let (from, to) = (number * 1000, (number + 1) * 1000);
    let rows = fixture::rows(&[grip_scope::Channel::Stylus], 10_000, from, to);
    {
        let mut engine = harness.state().shared.engine();
        engine.model.take(Feed::Rows(rows));
        engine.look();
    }
    harness.run();
}

#[test]
fn an_automatic_trigger_leaves_a_paused_view_and_counts_only_what_it_finds() {
    let mut harness = window(fixture::grasp(), Panel::Trigger);
    click(&mut harness, "Auto");
    click(&mut harness, "Arm");
    tenth(&mut harness, 20);
    tenth(&mut harness, 21);
    let swept = seen(&harness);
    assert!((swept.1 - 2.2).abs() < 1e-3 && harness.state().state.triggered == 0, "{swept:?}");
    press(&mut harness, Key::Space);
    tenth(&mut harness, 22);
    assert_eq!(seen(&harness), swept);
    press(&mut harness, Key::Space);
    tenth(&mut harness, 23);
    let mark = EventMark::plain(2.405, EventKind::Gross, "x");
    harness.state().shared.engine().model.take(Feed::Event(mark));
    (24..30).for_each(|number| tenth(&mut harness, number));
    assert_eq!(harness.state().state.triggered, 1);
    // The hit is shown as what the trigger does, and can be paused like everything else.
    let hit = seen(&harness);
    assert!((hit.0 - 2.305).abs() < 1e-6 && !harness.state().state.is_paused(), "{hit:?}");
    press(&mut harness, Key::Space);
    (30..45).for_each(|number| tenth(&mut harness, number));
    assert_eq!(seen(&harness), hit);
    press(&mut harness, Key::Space);
    tenth(&mut harness, 45);
    assert!((seen(&harness).1 - 4.6).abs() < 1e-3, "{:?}", seen(&harness));
}

#[test]
fn a_trigger_searches_a_recording_from_the_left_edge_and_states_where_there_is_nothing() {
    let mut model = fixture::grasp();
    model.take(Feed::Status(grip_scope::SourceStatus::Complete { note: String::new() }));
    let mut harness = window(model, Panel::Trigger);
    press(&mut harness, Key::T);
    harness.run();
    assert!((seen(&harness).0 - 0.85).abs() < 1e-6, "{:?}", seen(&harness));
    assert!(!harness.state().state.armed && harness.state().state.triggered == 1);
    press(&mut harness, Key::T);
    harness.run();
    let message = harness.state().state.message.clone().unwrap();
    assert_eq!(message.text, "The trigger finds nothing after 0.9500 s.");
    assert!(!harness.state().state.armed);
}

#[test]
fn keys_do_nothing_behind_a_dialog_but_close_it() {
    let mut harness = window(fixture::grasp(), Panel::Command);
    click(&mut harness, "Arm commands");
    click(&mut harness, "Release ..");
    let before = seen(&harness);
    for key in [Key::H, Key::T, Key::L, Key::ArrowUp, Key::Space] {
        press(&mut harness, key);
    }
    let state = &harness.state().state;
    assert!(!state.armed && state.command.asks_release);
    assert_eq!((state.layout.panel, state.layout.theme), (Some(Panel::Command), Look::Dark));
    assert_eq!(seen(&harness), before);
    press(&mut harness, Key::Escape);
    assert!(!harness.state().state.command.asks_release);
    click(&mut harness, "?");
    press(&mut harness, Key::H);
    assert_eq!(harness.state().state.layout.panel, Some(Panel::Command));
    press(&mut harness, Key::Escape);
    assert!(!harness.state().state.help);
    press(&mut harness, Key::H);
    assert_eq!(harness.state().state.layout.panel, Some(Panel::Health));
}
