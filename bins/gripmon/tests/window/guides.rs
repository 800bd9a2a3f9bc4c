//! What explains: a slip, and the tour of the first start.

use super::controls::press;
use super::{fixture, window};
use eframe::egui::Key;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable as _;
use grip_scope::{Channel, EventKind, EventMark, Feed};
use gripmon::Scope;
use gripmon::layout::{Layout, Panel};
use gripmon::state::ViewState;

fn shows(harness: &Harness<'_, Scope>, text: &str) -> bool {
    harness.query_all_by_label_contains(text).count() > 0
}

#[test]
fn a_slip_is_explained_by_keyboard() {
    let mut harness = window(fixture::grasp(), Panel::Health);
    harness.state_mut().state.event_s = Some(0.95);
    press(&mut harness, Key::W);
    for text in [
        "Slip at 0.9000 s, 200.0 ms long",
        "Other causes",
        "estimate of the adequate force, 9.50 N at first, 9.50 N at last",
    ] {
        assert!(shows(&harness, text), "{text}");
    }
    press(&mut harness, Key::Escape);
    assert!(!shows(&harness, "Slip at 0.9000 s"));
    harness.state_mut().state.event_s = Some(0.1);
    press(&mut harness, Key::W);
    assert!(shows(&harness, "No slip yet"));
    press(&mut harness, Key::W);
    assert_eq!(harness.state().state.explain, None);
}

#[test]
fn a_slip_that_comes_later_does_not_replace_what_is_read() {
    let mut harness = window(fixture::grasp(), Panel::Health);
    press(&mut harness, Key::W);
    assert!(shows(&harness, "Slip at 0.9000 s"));
    let later = EventMark::plain(2.5, EventKind::Gross, "gross");
    {
        let mut engine = harness.state().shared.engine();
        engine.model.take(Feed::Rows(fixture::rows(&[Channel::Stylus], 10_000, 20_000, 30_000)));
        engine.model.take(Feed::Event(later));
    }
    harness.run();
    assert!(shows(&harness, "Slip at 0.9000 s"));
    press(&mut harness, Key::W);
    press(&mut harness, Key::W);
    assert!(shows(&harness, "Slip at 2.5000 s"));
}

#[test]
fn without_a_pointer_cursor_a_goes_to_the_event_that_was_gone_to() {
    let mut harness = window(fixture::grasp(), Panel::Health);
    // Behind the begin of the pipeline.
    press(&mut harness, Key::N);
    press(&mut harness, Key::N);
    press(&mut harness, Key::A);
    press(&mut harness, Key::B);
    let [a, b] = harness.state().state.cursors;
    assert_eq!(a, Some(0.9));
    assert_ne!(b, a, "both are seen");
}

#[test]
fn the_tour_is_shown_once_has_three_hints_and_ends_with_escape() {
    let mut harness = window(fixture::grasp(), Panel::Health);
    assert!(!shows(&harness, "1 of 3"), "nobody began it");
    harness.state_mut().state.tour_once();
    harness.run();
    for hint in ["1 of 3: Time", "2 of 3: Slips", "3 of 3: Panels and files"] {
        assert!(shows(&harness, hint), "{hint}");
        press(&mut harness, Key::Enter);
    }
    assert_eq!(harness.state().state.tour, None);
    // What is remembered states that it was shown, from its first hint on.
    let remembered = harness.state().layout();
    assert!(remembered.toured && !Layout::default().toured);
    let mut again = ViewState::new(remembered);
    again.tour_once();
    assert_eq!(again.tour, None);
    // From the keys it is shown again.
    harness.key_press_modifiers(eframe::egui::Modifiers::SHIFT, Key::Questionmark);
    harness.run();
    harness.get_by_label("Tour").click();
    harness.run();
    assert!(shows(&harness, "1 of 3: Time") && !harness.state().state.help);
    press(&mut harness, Key::Escape);
    assert!(!shows(&harness, "of 3: "));
}
