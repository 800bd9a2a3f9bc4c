//! Every view shows what it is for.

use super::{fixture, window};
use eframe::egui::{Rect, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::{By, NodeT as _, Queryable as _};
use grip_link::message::daemon::{Appended, Health};
use grip_scope::feed::Feed;
use grip_scope::{Model, SourceStatus, Span};
use gripmon::Scope;
use gripmon::layout::Panel;
use gripmon::strip::StripId;

#[test]
fn every_plot_is_there_with_its_curves_values_and_units() {
    let harness = window(fixture::grasp(), Panel::Events);
    for strip in StripId::ALL {
        let found = harness.query_all_by_label_contains(&format!("{} plot", strip.title())).count();
        // Neither travel nor a reference is there.
        let empty = matches!(strip, StripId::Travel | StripId::Reference);
        assert_eq!(found, usize::from(!empty), "{strip:?}");
    }
    let why = "+ 2 empty\nTravel: This source measures no travel.\nMotion reference: This source has no motion reference.";
    harness.get_by_label(why);
    for curve in [
        "stylus",
        "normal force",
        "commanded",
        "estimate",
        "limit",
        "E_sc",
        "evidence",
        "shear",
        "slip speed",
    ] {
        assert!(harness.query_all_by_label(curve).count() >= 1, "{curve}");
    }
    // The newest command and the limit, with their unit.
    assert!(harness.query_all_by_label("12.00").count() >= 1);
    assert!(harness.query_all_by_label("40.00").count() >= 1);
    assert!(harness.query_all_by_label("N").count() >= 3);
    harness.get_by_label("Object and events");
    harness.get_by_label("Overview of all data");
}

#[test]
fn flags_of_esc_are_those_of_the_value_beside_them() {
    let mut harness = window(fixture::grasp(), Panel::Events);
    // At the end nothing slips any more; the fixture's slip shows that it knows nothing.
    for (to_s, flags) in [(2.0, 0), (1.05, 1), (0.8, 0)] {
        harness.state_mut().state.window.show(Span::new(0.5, to_s));
        harness.run();
        let found = harness.query_all_by_label("! no information").count();
        assert_eq!(found, flags, "at {to_s}");
    }
}

#[test]
fn the_health_panel_reports_rates_losses_clocks_latency_stages_and_sensors() {
    let mut harness = window(fixture::grasp(), Panel::Health);
    for name in [
        "sample rate",
        "rows lost",
        "CRC errors",
        "dropped inside",
        "clock offset",
        "real time",
        "p50",
        "p99",
        "p99.9",
        "max",
        "observation",
        "pressure",
    ] {
        assert!(harness.query_all_by_label(name).count() >= 1, "{name}");
    }
    for value in [
        "9.999 kHz",
        "! 3",
        "! 2",
        "60.00 \u{b5}s",
        "400.0 \u{b5}s",
        "2.000 ms",
        "granted",
        "! frozen",
        "1.234 ms +- 40.00 \u{b5}s",
    ] {
        assert!(harness.query_all_by_label(value).count() >= 1, "{value}");
    }
    harness.get_by_label("Latency histogram");
    // An older daemon reports quantiles only, a young one has sent nothing yet.
    for (appended, stated) in [
        (None, "This gripd is older than gripmon and sends quantiles only."),
        (Some(Appended::default()), "No command was sent yet."),
    ] {
        let health = Health { appended, ..fixture::health() };
        harness.state().shared.engine().model.take(Feed::Health(Box::new(health)));
        harness.run();
        harness.get_by_label(stated);
        harness.get_by_label("clock offset");
        assert_eq!(harness.query_all_by_label("Latency histogram").count(), 0);
    }
    harness.get_by_label_contains("10.0 % of samples");
}

#[test]
fn a_sensor_that_never_sent_anything_is_not_called_good() {
    let harness = window(fixture::grasp(), Panel::Health);
    // The stylus is good, the array frozen; there is neither travel nor a reference.
    assert_eq!(harness.query_all_by_label("good").count(), 1);
    assert_eq!(harness.query_all_by_label("\u{2013}").count(), 2);
}

/// Rectangles of the controls and labels in the lines at the top and at the bottom.
fn in_the_lines(harness: &Harness<'_, Scope>, high: f32) -> Vec<(String, Rect)> {
    let named = harness.query_all(By::new().predicate(|node| node.label().is_some()));
    let lines = named.filter_map(|node| {
        let rect = node.rect();
        let name = node.accesskit_node().label().unwrap_or_default();
        (rect.bottom() < 110.0 || rect.top() > high - 56.0).then_some((name, rect))
    });
    lines.filter(|(_, rect)| rect.height() < 30.0 && rect.width() > 0.0).collect()
}

#[test]
fn nothing_in_the_lines_at_top_and_bottom_stands_over_another() {
    for (wide, panel) in [
        (480.0, None),
        (760.0, Some(Panel::Health)),
        (1000.0, None),
        (1257.0, None),
        (1360.0, Some(Panel::Events)),
    ] {
        let mut harness = window(fixture::grasp(), Panel::Health);
        let state = &mut harness.state_mut().state;
        state.layout.panel = panel;
        state.layout.plots.clear();
        state.cursors = [Some(1.0), Some(1.5)];
        state.armed = true;
        state.complain("/a/long/path/to/a/file/that/could/not/be/written/gripmon-0001.mcap: cannot be written (no space is left on this device, and so on and on)");
        harness.set_size(vec2(wide, 700.0));
        harness.run();
        let found = in_the_lines(&harness, 700.0);
        assert!(found.len() > 15, "{found:?}");
        for (i, (name, rect)) in found.iter().enumerate() {
            assert!(rect.left() >= 0.0 && rect.right() <= wide, "{wide}: {name} {rect:?}");
            for (other, there) in &found[i + 1..] {
                let both = rect.intersect(*there);
                let apart = both.width() < 0.5 || both.height() < 0.5;
                assert!(apart, "{wide}: {name} {rect:?} and {other} {there:?}");
            }
        }
    }
}

#[test]
fn events_are_listed_with_what_is_known_of_them() {
    let harness = window(fixture::grasp(), Panel::Events);
    harness.get_by_label_contains("0.9500 s  gross slip");
    let known = "by vibration), statistic 8.0, confidence > 99.9 %, ruled out: knock and arm stop, \
                 possible: motion, 50.0 +- 2.0 mm/s (travel)";
    assert_eq!(harness.query_all_by_label_contains(known).count(), 2);
    harness.get_by_label_contains("the pressure array is frozen");
}

#[test]
fn the_curves_of_a_study_take_the_place_of_the_plots() {
    let harness = window(fixture::study(), Panel::Health);
    harness.get_by_label("Learning of surface2 plot");
    harness.get_by_label("twenty starts each");
    // The nets once, not over the curves of each plot.
    for net in ["gd", "lm"] {
        harness.get_by_label(net);
    }
    assert_eq!(harness.query_all_by_label("Stylus plot").count(), 0);
}

#[test]
fn an_empty_window_states_why() {
    let harness = window(Model::new(1 << 20), Panel::Health);
    harness.get_by_label_contains("No stylus samples yet.");
    assert!(harness.query_all_by_label_contains("no source").count() >= 1);
    harness.get_by_label_contains("This source has no figures of a link");
    // Of what is being read nothing is known yet.
    let mut model = Model::new(1 << 20);
    model.take(Feed::Status(SourceStatus::Loading { done: 0.34 }));
    let harness = window(model, Panel::Health);
    assert!(harness.query_all_by_label_contains("loading, 34 %").count() >= 1);
    assert!(harness.query_all_by_label_contains("is being read").count() >= 1);
    assert_eq!(harness.query_all_by_label_contains("This source has no forces").count(), 0);
}

#[test]
fn trouble_is_a_state_with_a_sentence() {
    for (status, sentence) in [
        (
            SourceStatus::Waiting { reason: "no daemon answers".into(), again_in_s: 2.0 },
            "no daemon answers; trying again in 2.0 s",
        ),
        (SourceStatus::Stalled { for_s: 3.0 }, "no samples for 3.0 s"),
        (
            SourceStatus::Failed { sentence: "run.mcap: not a recording".into() },
            "run.mcap: not a recording",
        ),
        (SourceStatus::Loading { done: 0.25 }, "loading, 25 %"),
    ] {
        let mut model = fixture::grasp();
        model.take(Feed::Status(status));
        window(model, Panel::Command).get_by_label(sentence);
    }
}
