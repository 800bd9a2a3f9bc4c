//! The table of many grippers: what it reports after messages, what clicks and keys do, how one is opened and left again.

#![expect(clippy::unwrap_used, reason = "test code")]

#[path = "../../../../bins/gripmon/tests/window/fixture.rs"]
#[expect(dead_code, reason = "the tests of gripmon need more of it")]
mod fixture;
mod grippers;
mod roster;

use core::sync::atomic::{AtomicU64, Ordering};
use core::time::Duration;
use eframe::egui::{Context, Key, RawInput, Ui};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT as _, Queryable as _};
use grip_link::message::FaultCode;
use grip_link::message::daemon::{PipelineState, RealTime, Scene, SensorHealth};
use grip_scope::feed::{DaemonInfo, Feed};
use grip_scope::{Model, SourceStatus};
use gripmon::engine::Engine;
use gripmon::layout::{Layout, Look};
use gripmon::scope::{self, Scope, Shared};
use gripmon::state::ViewState;
use gripmon_fleet::grippers::{FleetFeed, Member, Received, Roster};
use gripmon_fleet::{Hall, Lead, Lobby, Request, opened};
use grippers::{health, many, member, of, reported, state};
use std::sync::Arc;

/// A table, and what it left to the window.
struct Held {
    lobby: Lobby,
    requests: Vec<Request>,
    prepared: bool,
}

fn window(roster: Roster) -> Harness<'static, Held> {
    let hall = Arc::new(Hall::new(roster));
    let lobby = Lobby::new(hall, Look::Dark, "tcp/127.0.0.1:7447".to_owned());
    let held = Held { lobby, requests: Vec::new(), prepared: false };
    let frame = |ui: &mut Ui, held: &mut Held| {
        if !core::mem::replace(&mut held.prepared, true) {
            scope::prepare(ui.ctx(), Look::Dark);
        }
        let requests = held.lobby.ui(ui);
        held.requests.extend(requests);
    };
    let mut harness = Harness::builder().with_size([1400.0, 600.0]).build_ui_state(frame, held);
    harness.run_steps(2);
    harness
}

fn receive(harness: &mut Harness<'_, Held>, feeds: impl IntoIterator<Item = FleetFeed>) {
    let hall = Arc::clone(&harness.state().lobby.hall);
    feeds.into_iter().for_each(|feed| hall.take(feed));
    harness.run_steps(2);
}

/// What the rows state, from top to bottom.
fn rows(harness: &Harness<'_, Held>) -> Vec<String> {
    let mut rows: Vec<(f32, String)> = harness
        .query_all_by_label_contains("Gripper 5a5a")
        .filter_map(|node| Some((node.rect().top(), node.accesskit_node().label()?)))
        .collect();
    rows.sort_by(|a, b| a.0.total_cmp(&b.0));
    rows.into_iter().map(|(_, label)| label).collect()
}

/// Their last digits.
fn numbers(harness: &Harness<'_, Held>) -> Vec<String> {
    let digits = |row: String| row.split(", ").nth(1).map(|uid| uid[uid.len() - 2..].to_owned());
    rows(harness).into_iter().filter_map(digits).collect()
}

fn states(harness: &Harness<'_, Held>, number: u16) -> String {
    let uid = format!("{number:04x}, ");
    rows(harness).into_iter().find(|row| row.contains(&uid)).unwrap_or_default()
}

/// 1 holds, 2 slips with a bad sensor, 3 has a fault, 4 is gone.
fn four() -> Roster {
    let mut roster = Roster::default();
    let slipping = PipelineState {
        scene: Scene::Slipping,
        sensors: [SensorHealth::Good, SensorHealth::Lost, SensorHealth::Good, SensorHealth::Good],
        lost: 12,
        ..state(7.0)
    };
    let stopped = PipelineState { fault: FaultCode(0x1f), ..state(1.0) };
    for (number, site, state) in [
        (1, "hall-1", state(4.5)),
        (2, "hall-2", slipping),
        (3, "hall-1", stopped),
        (4, "hall-2", state(2.0)),
    ] {
        let member = member(site, number);
        roster.take(of(&member, 0.0, Received::Came));
        roster.take(of(&member, 1.0, reported(&state)));
        roster.take(of(&member, 1.1, health(u32::from(number) * 10)));
    }
    roster.take(of(&member("hall-2", 4), 1.5, Received::Gone));
    roster.take(FleetFeed::Status(SourceStatus::Live));
    roster
}

#[test]
fn the_table_states_what_the_messages_reported() {
    let mut harness = window(four());
    assert_eq!(rows(&harness).len(), 4);
    let stated = states(&harness, 2);
    for part in ["Site hall-2", "Scene slipping", "Meas N 7.00", "Slips 20", "Sensors travel lost"]
    {
        assert!(stated.contains(part), "{part}: {stated}");
    }
    for label in ["4 grippers", "1 with a fault", "1 gone", "1 with a bad sensor", "0 silent"] {
        assert!(harness.query_by_label(label).is_some(), "{label}");
    }
    assert!(harness.query_by_label("connected to tcp/127.0.0.1:7447").is_some());
    let well = reported(&state(3.25));
    receive(&mut harness, [of(&member("hall-1", 3), 2.0, well)]);
    let stated = states(&harness, 3);
    assert!(stated.contains("Fault -") && stated.contains("Meas N 3.25"), "{stated}");
    assert!(harness.query_by_label("0 with a fault").is_some());
}

#[test]
fn titles_order_and_words_filter() {
    let mut harness = window(four());
    assert_eq!(numbers(&harness), ["01", "03", "02", "04"]);
    for (title, wanted) in [
        ("Order by Meas N", ["02", "01", "04", "03"]),
        ("Order by Meas N", ["03", "04", "01", "02"]),
        ("Order by !", ["03", "04", "02", "01"]),
        ("Order by Slips", ["04", "03", "02", "01"]),
    ] {
        harness.get_by_label(title).click();
        harness.run_steps(2);
        assert_eq!(numbers(&harness), wanted, "{title}");
    }
    harness.get_by_label("1 gone").click();
    harness.run_steps(2);
    assert_eq!(numbers(&harness), ["04"]);
    harness.key_press(Key::Escape);
    harness.run_steps(2);
    assert_eq!(rows(&harness).len(), 4);
    harness.key_press(Key::Slash);
    harness.run_steps(2);
    harness.get_by_label("Filter").type_text("hall-1 fault");
    harness.run_steps(2);
    assert_eq!(numbers(&harness), ["03"]);
    harness.get_by_label("Filter").type_text(" nothing");
    harness.run_steps(2);
    assert_eq!(rows(&harness).len(), 0);
}

#[test]
fn a_click_opens_a_gripper_and_so_does_enter() {
    let mut harness = window(four());
    harness.get_by_label_contains("Gripper 5a5a5a5a5a5a5a5a5a5a5a5a5a5a0002").click();
    harness.run_steps(2);
    let open =
        |number| Request::Open(member(if number == 2 { "hall-2" } else { "hall-1" }, number));
    assert_eq!(harness.state().requests, [open(2)]);
    // The one that was opened stays chosen; keys go on from there, and not beyond the ends.
    for (key, wanted) in [
        (Key::ArrowUp, member("hall-1", 3)),
        (Key::Home, member("hall-1", 1)),
        (Key::ArrowUp, member("hall-1", 1)),
        (Key::End, member("hall-2", 4)),
        (Key::PageUp, member("hall-1", 1)),
        (Key::ArrowDown, member("hall-1", 3)),
    ] {
        harness.key_press(key);
        harness.run_steps(2);
        assert_eq!(harness.state().lobby.table.chosen, Some(wanted), "{key:?}");
    }
    harness.key_press(Key::Enter);
    harness.run_steps(2);
    assert_eq!(harness.state().requests, [open(2), open(3)]);
    harness.key_press(Key::S);
    harness.run_steps(2);
    assert_eq!(harness.state().requests.last(), Some(&Request::Picture));
}

#[test]
fn of_a_thousand_grippers_only_those_that_are_seen_are_drawn() {
    let mut harness = window(many(1000));
    let seen = rows(&harness);
    assert!((10..40).contains(&seen.len()), "{}", seen.len());
    assert!(seen[0].contains("0000, "), "{}", seen[0]);
    harness.key_press(Key::End);
    harness.run_steps(3);
    let seen = rows(&harness);
    assert!((10..40).contains(&seen.len()), "{}", seen.len());
    assert!(seen.last().is_some_and(|row| row.contains("03e7, ")), "{:?}", seen.last());
    assert!(harness.query_by_label("1000 grippers").is_some());
}

#[test]
fn what_is_wrong_with_the_way_there_is_reported() {
    let mut harness = window(Roster::default());
    for (status, reported) in [
        (
            SourceStatus::Connecting { what: "the router at x".into(), before: String::new() },
            "connecting to the router at x",
        ),
        (
            SourceStatus::Waiting { reason: "no router answers at x".into(), again_in_s: 2.0 },
            "no router answers at x; trying again in 2.0 s",
        ),
        (SourceStatus::Failed { sentence: "no endpoint".into() }, "no endpoint"),
    ] {
        receive(&mut harness, [FleetFeed::Status(status)]);
        assert!(harness.query_by_label(reported).is_some(), "{reported}");
    }
    receive(&mut harness, [FleetFeed::Unreadable]);
    assert!(harness.query_by_label("! 1 unreadable messages").is_some());
}

#[test]
fn a_table_without_updates_asks_for_no_further_frame() {
    let mut harness = window(four());
    harness.step();
    let output = &harness.output().viewport_output[&eframe::egui::ViewportId::ROOT];
    assert_eq!(output.repaint_delay, Duration::MAX);
}

/// The view of one gripper that reports every n-th sample, and where it leads.
fn view(every_nth: u16, mut model: Model) -> Harness<'static, (Scope, Vec<Lead>)> {
    let (name, place) = ("hall-1/5a".to_owned(), "tcp/127.0.0.1:7447".to_owned());
    let (may_command, dry_run) = (false, false);
    let real_time = RealTime::Other(u8::MAX);
    model.take(Feed::Welcome(DaemonInfo {
        name,
        place,
        may_command,
        dry_run,
        real_time,
        every_nth,
    }));
    let shared = Arc::new(Shared::new(Engine::new(model, None)));
    let scope = Scope::new(shared, ViewState::new(Layout::default()));
    let mut prepared = false;
    let frame = move |ui: &mut Ui, (scope, leads): &mut (Scope, Vec<Lead>)| {
        if !core::mem::replace(&mut prepared, true) {
            scope::prepare(ui.ctx(), Look::Dark);
        }
        leads.push(opened(ui, scope, "hall-1/5a"));
        let _effects = scope.ui(ui);
    };
    let held = (scope, Vec::new());
    let mut harness = Harness::builder().with_size([1400.0, 900.0]).build_ui_state(frame, held);
    harness.run_steps(3);
    harness
}

fn leads(harness: &mut Harness<'_, (Scope, Vec<Lead>)>) -> bool {
    harness.run_steps(2);
    core::mem::take(&mut harness.state_mut().1).contains(&Lead::Back)
}

#[test]
fn a_gripper_without_samples_is_reported_so_where_they_would_be() {
    let mut model = Model::new(1 << 20);
    (0..50).for_each(|i| model.take(Feed::State(fixture::state(0.2 * f64::from(i)))));
    let harness = view(0, model);
    let none = "Stylus: Nothing: this gripper sends no samples here.";
    assert!(harness.query_by_label_contains(none).is_some());
    assert!(harness.query_by_label_contains("sends no samples (samples_every = 0").is_some());
    assert!(harness.query_by_label("Force plot").is_some(), "forces come with its state");
    let harness = view(10, fixture::grasp());
    assert!(harness.query_by_label("sends every 10th sample").is_some());
    assert!(harness.query_by_label("Stylus plot").is_some());
}

#[test]
fn escape_leads_back_unless_it_closes_something() {
    let mut harness = view(1, fixture::grasp());
    assert!(!leads(&mut harness));
    harness.state_mut().0.state.report("Something was done.");
    harness.key_press(Key::Escape);
    assert!(!leads(&mut harness), "it closes the message");
    harness.key_press(Key::Escape);
    assert!(leads(&mut harness));
    harness.get_by_label("< All grippers").click();
    assert!(leads(&mut harness));
}

/// The rows of a table keep their gripper while others come.
#[test]
fn a_gripper_that_comes_does_not_take_the_place_of_the_chosen_one() {
    let mut harness = window(four());
    harness.key_press(Key::End);
    harness.run_steps(2);
    let chosen: Option<Member> = Some(member("hall-2", 4));
    assert_eq!(harness.state().lobby.table.chosen, chosen);
    receive(&mut harness, [of(&member("hall-0", 9), 2.0, Received::Came)]);
    assert_eq!(numbers(&harness)[0], "09");
    harness.key_press(Key::Enter);
    harness.run_steps(2);
    assert_eq!(harness.state().requests, [Request::Open(member("hall-2", 4))]);
}

#[test]
fn updates_paint_a_table_that_is_seen_and_none_that_is_hidden() {
    let (ctx, requests) = (Context::default(), Arc::<AtomicU64>::default());
    let counted = Arc::clone(&requests);
    ctx.set_request_repaint_callback(move |_| {
        counted.fetch_add(1, Ordering::Relaxed);
    });
    let hall = Hall::new(four());
    // What was asked for is painted; the first frames of a window ask for more of them.
    let paint = || {
        for _ in 0..3 {
            let mut output = ctx.run_ui(RawInput::default(), |_| {});
            output.textures_delta.clear();
        }
    };
    let asked = |hidden: bool, feed: Option<FleetFeed>| {
        hall.set_hidden(hidden);
        paint();
        requests.store(0, Ordering::Relaxed);
        feed.into_iter().for_each(|feed| hall.take(feed));
        hall.paint(&ctx);
        requests.load(Ordering::Relaxed)
    };
    let at = |at_s| Some(of(&member("hall-1", 1), at_s, reported(&state(1.0))));
    assert!(asked(false, at(2.0)) > 0);
    assert_eq!(asked(false, None), 0, "nothing is new");
    assert_eq!(asked(true, at(3.0)), 0, "hidden");
    assert!(asked(false, at(4.0)) > 0);
}
