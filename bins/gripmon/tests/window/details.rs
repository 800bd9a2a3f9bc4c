//! What stands beside, over and between the plots: pairs that belong together, units, notes, what a low or narrow window shows.

use super::labels::{control, painted};
use super::{fixture, window};
use eframe::egui::vec2;
use egui_kittest::kittest::Queryable as _;
use grip_scope::feed::{DerivedBlock, EventMark, Feed, ObserverSettings, RowBlock};
use grip_scope::trigger::Condition;
use grip_scope::{Channel, EventKind, Model, Span};
use gripmon::layout::Panel;
use gripmon::strip::StripId;

#[test]
fn the_enclosure_stands_beside_the_value_of_the_same_observer() {
    let mut model = fixture::grasp();
    // The source states 0.2, the scope's own observer 0.5 with its enclosure.
    model.take(Feed::State(fixture::state(1.05)));
    let mut block = DerivedBlock::default();
    let esc = [(Channel::OwnEsc, 0.5), (Channel::EscLow, 0.4), (Channel::EscHigh, 0.6)];
    block.put(1.99, esc);
    model.take(Feed::Derived(Box::new(block)));
    let mut harness = window(model, Panel::Events);
    let plots = &mut harness.state_mut().state.layout.plots;
    plots.iter_mut().for_each(|plot| plot.shown = plot.plot == StripId::Esc);
    harness.run();
    let place = |label: &str| harness.get_by_label(label).rect();
    let (own, bounds) = (place("own E_sc"), harness.get_by_label_contains("400.0 mW .. 600.0 mW"));
    let theirs = place("E_sc");
    assert!(theirs.bottom() <= own.top() + 1.0, "{theirs:?} {own:?}");
    assert!(bounds.rect().top() >= own.bottom() - 2.0, "{own:?} {:?}", bounds.rect());
    assert_eq!(harness.query_all_by_label("500.0").count(), 1);
}

#[test]
fn the_needed_force_is_named_by_its_quantiles_and_a_source_without_has_no_fan() {
    let only_force = |model| {
        let mut harness = window(model, Panel::Events);
        let plots = &mut harness.state_mut().state.layout.plots;
        plots.iter_mut().for_each(|plot| plot.shown = plot.plot == StripId::Force);
        harness.run();
        harness
    };
    let harness = only_force(fixture::grasp());
    let name = harness.get_by_label("needed force (10 / 50 / 90 %)").rect();
    let values = harness.get_by_label_contains("3.25 / 4.00 / 6.75 N").rect();
    assert!(values.top() >= name.bottom() - 2.0 && name.width() < 190.0, "{name:?} {values:?}");
    let mut model = Model::new(1 << 20);
    fixture::greet(&mut model, true);
    model.take(Feed::State(fixture::state(0.4)));
    let harness = only_force(model);
    harness.get_by_label("commanded");
    assert_eq!(harness.query_all_by_label_contains("needed force").count(), 0);
}

#[test]
fn a_lone_value_of_pressure_is_a_curve_and_an_array_is_a_picture() {
    let mut model = Model::new(1 << 20);
    let channels = [Channel::Stylus, Channel::Pressure];
    let mut block = fixture::rows(&channels, 1000, 0, 1000);
    block.columns[1].1.fill(7.25);
    model.take(Feed::Rows(block));
    let harness = window(model, Panel::Events);
    harness.get_by_label("Pressure plot");
    harness.get_by_label("Pressure axis");
    harness.get_by_label("pressure");
    harness.get_by_label("7.250");
    assert_eq!(harness.query_all_by_label("no frame").count(), 0);
    let harness = window(fixture::grasp(), Panel::Events);
    assert_eq!(harness.query_all_by_label("Pressure axis").count(), 0);
    assert!(harness.query_all_by_label_contains("4 taxels").count() == 1);
}

#[test]
fn a_pointer_over_the_events_is_over_them_in_every_frame() {
    let mut harness = window(fixture::grasp(), Panel::Health);
    let lane = harness.get_by_label("Object and events").rect();
    harness.hover_at(lane.center());
    harness.run_steps(2);
    for step in 0..6 {
        harness.step();
        let hover_s = harness.state().state.hover_s;
        assert!(hover_s.is_some_and(|t_s| (t_s - 1.0).abs() < 0.01), "{step}: {hover_s:?}");
    }
    harness.hover_at(lane.center() + vec2(0.0, 500.0));
    harness.run_steps(2);
    harness.remove_cursor();
    harness.run();
    assert_eq!(harness.state().state.hover_s, None);
}

#[test]
fn a_level_that_is_typed_means_the_same_whatever_it_was_before() {
    let mut harness = window(fixture::grasp(), Panel::Trigger);
    harness.state_mut().state.layout.trigger.condition = Condition::RisingEdge;
    for (channel, unit, factor) in [
        (Channel::Stylus, "\u{b5}m", 1e-6),
        (Channel::NormalForce, "N", 1.0),
        (Channel::SlipSpeed, "mm/s", 1e-3),
        (Channel::Statistic, "s", 1.0),
    ] {
        harness.state_mut().state.layout.trigger.channel = channel;
        for level in [0.0, 2e-9, 0.5, 40.0, 1e6] {
            harness.state_mut().state.layout.trigger.level = level;
            harness.run();
            let shown = control(&harness, "Level").value().unwrap();
            assert_eq!(shown.trim_start_matches(|c: char| "0123456789.,-e ".contains(c)), unit);
            control(&harness, "Level").set_value_accesskit(3.0);
            harness.run();
            let is = harness.state().state.layout.trigger.level;
            assert!((is / factor - 3.0).abs() < 1e-9, "{channel:?} from {level}: {is}");
        }
    }
}

#[test]
fn a_level_may_be_typed_with_its_unit() {
    let mut harness = window(fixture::grasp(), Panel::Trigger);
    harness.state_mut().state.layout.trigger.condition = Condition::Above;
    harness.state_mut().state.layout.trigger.channel = Channel::Stylus;
    harness.run();
    control(&harness, "Level").click();
    harness.run();
    control(&harness, "Level").type_text("0.2 mm");
    harness.run();
    harness.key_press(eframe::egui::Key::Enter);
    harness.run();
    let level = harness.state().state.layout.trigger.level;
    assert!((level / 2e-4 - 1.0).abs() < 1e-9, "{level}");
}

#[test]
fn an_interval_that_the_source_does_not_report_is_called_the_shipped_one() {
    let mut harness = window(fixture::grasp(), Panel::Health);
    let shipped = "interval 600 s of the shipped settings";
    for (settings, note, observed) in [
        (None, shipped, 0),
        (Some(ObserverSettings::Source { interval_s: 3600.0 }), "interval 3600 s", 0),
        (Some(ObserverSettings::Shipped), shipped, 1),
    ] {
        let reported = settings.map(Feed::Observes);
        reported.into_iter().for_each(|feed| harness.state().shared.engine().model.take(feed));
        harness.run();
        assert!(painted(&harness).iter().any(|text| text == note), "{settings:?}");
        harness.get_by_label(&format!("Slip evidence plot {note}"));
        assert_eq!(harness.query_all_by_label("shipped settings").count(), observed);
    }
}

#[test]
fn a_limit_above_the_plot_is_reported_at_its_edge() {
    let mut harness = window(fixture::grasp(), Panel::Health);
    let reported = |text: &String| text.starts_with("limit 40.00 N");
    assert!(painted(&harness).iter().any(reported));
    let scale = gripmon::plot::Scale::new(gripmon::plot::Kind::Linear, 0.0, 50.0);
    harness.state_mut().state.values = vec![(StripId::Force, scale)];
    harness.run();
    assert!(!painted(&harness).iter().any(reported));
}

#[test]
fn the_axis_states_whether_its_times_are_those_of_the_device() {
    let mut harness = window(fixture::grasp(), Panel::Health);
    assert!(painted(&harness).iter().any(|text| text == "s, device time"));
    let again = fixture::rows(&[Channel::Stylus], 10_000, 0, 1000);
    harness.state().shared.engine().model.take(Feed::Rows(again));
    harness.run();
    assert!(painted(&harness).iter().any(|text| text == "s, over restarts"));
}

/// Thirty thousand gaps, slips and events, all seen.
fn crowded() -> Model {
    let mut model = Model::new(64 << 20);
    for gap in 0..30_000 {
        let block = fixture::rows(&[Channel::Stylus], 1000, 20 * gap, 20 * gap + 5);
        model.take(Feed::Rows(RowBlock { broken: true, ..block }));
        let t_s = 0.02 * gap as f64;
        let kind = if gap % 2 == 0 { EventKind::Gross } else { EventKind::Ended };
        model.take(Feed::Event(EventMark::plain(t_s, kind, "x")));
    }
    model
}

#[test]
fn a_crowd_of_gaps_slips_and_events_is_drawn_with_as_few_shapes_as_can_be_told_apart_and_counted() {
    let mut harness = window(crowded(), Panel::Health);
    let shapes = harness.output().shapes.len();
    // Ten plots, each with at most a wash for each of some 800 points.
    assert!(shapes < 20_000, "{shapes}");
    let events = harness.get_by_label("Object and events").value().unwrap();
    assert_eq!(events, "50,000 events");
    assert!(painted(&harness).contains(&events));
    // Gaps are counted, also those that no list holds any more.
    let gaps = harness.get_by_label("gaps").rect();
    let count = harness.get_by_label("! 29,999").rect();
    assert!((gaps.center().y - count.center().y).abs() < 3.0);
    // The newest are seen as well as the oldest.
    let seen = harness.state().shared.engine().model.span().unwrap();
    for at_s in [seen.to_s - 1.0, seen.to_s - 300.0] {
        harness.state_mut().state.window.show(Span::new(at_s - 5.0, at_s + 0.9));
        harness.run();
        let reported = harness.get_by_label("Object and events").value().unwrap();
        assert!(reported != "0 events", "{at_s}");
    }
}

#[test]
fn a_small_window_stays_usable_with_every_panel() {
    for panel in Panel::ALL {
        let mut harness = window(fixture::grasp(), panel);
        harness.set_size(vec2(800.0, 500.0));
        harness.run();
        let stylus = harness.get_by_label("Stylus plot").rect();
        assert!(stylus.width() > 300.0 && stylus.height() > 30.0, "{panel:?}: {stylus:?}");
        // Plots that have no room are reported, and none stands over another or over the axis.
        let plots: Vec<_> = harness.query_all_by_label_contains(" plot").collect();
        let mut rects: Vec<_> = (plots.iter())
            .filter(|node| !node.value().unwrap_or_default().starts_with('+'))
            .map(|node| node.rect())
            .collect();
        rects.sort_by(|a, b| a.top().total_cmp(&b.top()));
        assert!(rects.windows(2).all(|two| two[0].bottom() <= two[1].top()), "{rects:?}");
        let overview = harness.get_by_label("Overview of all data").rect();
        let last = rects[rects.len() - 1];
        assert!(last.bottom() <= overview.top() - 20.0, "{panel:?}: {last:?} {overview:?}");
        // Of ten, two have no data.
        harness.get_by_label_contains(&format!("+ {} plots", StripId::ALL.len() - 2 - rects.len()));
        for label in ["Pause", "Event >", "Command", "?"] {
            let rect = control(&harness, label).rect();
            assert!(rect.right() <= 800.0 && rect.bottom() <= 500.0, "{label}: {rect:?}");
        }
    }
    // Without a panel the values have room beside the plots.
    let mut harness = window(fixture::grasp(), Panel::Health);
    harness.state_mut().state.layout.panel = None;
    harness.set_size(vec2(800.0, 500.0));
    harness.run();
    assert!(
        harness.query_all_by_label("12.00").count() + harness.query_all_by_label("stylus").count()
            > 0
    );
}
