//! Data that no gripper should send are shown, never a crash.

use super::{fixture, window};
use egui_kittest::kittest::Queryable as _;
use grip_scope::feed::{EventKind, EventMark, Feed, RowBlock};
use grip_scope::{Channel, Model};
use gripmon::layout::Panel;

fn block(times_us: Vec<u64>, values: Vec<f32>) -> Feed {
    Feed::Rows(RowBlock {
        times_us,
        columns: vec![(Channel::Stylus, values)],
        ..RowBlock::default()
    })
}

#[test]
fn absurd_values_and_times_are_drawn() {
    let mut model = Model::new(8 << 20);
    model.take(block(vec![0, 100, 200, 300], vec![f32::NAN, 1e30, -1e30, f32::INFINITY]));
    model.take(block(
        vec![250, 240, u64::MAX / 2, u64::MAX],
        vec![1e-5, 2e-5, f32::MIN_POSITIVE, 0.0],
    ));
    model.take(Feed::Event(EventMark::plain(f64::NAN, EventKind::Fault, "when?")));
    model.take(Feed::Event(EventMark::plain(1e300, EventKind::Gap, "late")));
    for panel in Panel::ALL {
        let harness = window(model.clone(), panel);
        harness.get_by_label_contains("Stylus plot");
    }
}

#[test]
fn one_sample_and_slow_and_fast_rates_are_drawn() {
    for (rate_hz, rows) in [(100, 1), (100, 50), (20_000, 40_000)] {
        let mut model = Model::new(8 << 20);
        model.take(Feed::Rows(fixture::rows(&[Channel::Stylus], rate_hz, 0, rows)));
        window(model, Panel::Health).get_by_label_contains("Stylus plot");
    }
}

#[test]
fn views_far_from_the_data_and_of_no_length_are_drawn() {
    let mut harness = window(fixture::grasp(), Panel::Cursors);
    for (from_s, to_s) in [(1e9, 1e9 + 1.0), (-5.0, -4.0), (1.0, 1.0), (0.0, 1e7)] {
        harness.state_mut().state.window.show(grip_scope::Span { from_s, to_s });
        harness.state_mut().state.cursors = [Some(from_s), Some(1e300)];
        harness.run();
        harness.get_by_label_contains("Stylus plot");
    }
}

#[test]
fn a_window_as_small_as_it_gets_is_drawn() {
    let mut harness = window(fixture::grasp(), Panel::Health);
    harness.set_size(eframe::egui::vec2(480.0, 320.0));
    harness.run();
    harness.get_by_label("Pause");
}
