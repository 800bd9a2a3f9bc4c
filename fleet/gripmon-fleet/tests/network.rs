//! A real router in this process and a made-up gripper on it: the table and the view of one are filled, and informed when all of it goes.

#![expect(clippy::unwrap_used, clippy::panic, reason = "test code")]

#[path = "../../grip-fleet/tests/rig/mod.rs"]
#[expect(dead_code, reason = "the tests of grip-fleet need more of it")]
mod place;
#[path = "../../../crates/grip-scope/tests/scope/rig.rs"]
#[expect(dead_code, reason = "the tests of grip-scope need more of it")]
mod rig;

use grip_fleet::net::{Announced, Session};
use grip_fleet::{EventLog, Part, wire};
use grip_link::message::daemon::{GripState, Gripper, Health, LinkState, PipelineState, Scene};
use grip_link::message::{DeviceState, Kind};
use grip_scope::{Channel, EventKind, Model, SourceSpec, SourceStatus};
use gripmon_fleet::Hall;
use gripmon_fleet::grippers::{Column, Member, Roster};
use gripmon_fleet::source::{FleetHandle, FleetPlace, GripperAt, Network};
use place::{announced, endpoint, notice, patient, router};
use rig::{Watch, pause, samples};
use slip_core::units::Micros;
use std::sync::Arc;

/// Looks before a test has hung.
const PATIENCE: u32 = 60_000;

/// A daemon that reports a state in each turn.
struct Daemon {
    announced: Announced,
    _session: Session,
    log: EventLog,
    turns: u64,
}

impl Daemon {
    fn start(network: &Network) -> Self {
        let session = network.open().unwrap();
        let announced = announced(&session, &member(), &[Part::About]);
        let log = EventLog::new(7, 1 << 16);
        Self { announced, _session: session, log, turns: 0 }
    }

    fn turn(&mut self) {
        self.turns += 1;
        let state = PipelineState {
            t: Micros(self.turns * 10_000),
            scene: Scene::Holding,
            grip: GripState::Holding,
            device: DeviceState::from_code(2),
            statistic: Some(0.5),
            command_n: Some(5.0),
            applied_n: Some(4.5),
            rate_hz: 1000,
            ..PipelineState::UNKNOWN
        };
        let head = self.log.head();
        let state = wire(Kind::STATE, |out| state.write(out).unwrap());
        self.announced.publish(Part::State, head, &state);
        let health = Health { link: LinkState::Stream, slips: 3, ..Health::default() };
        let health = wire(Kind::HEALTH, |out| health.write(out).unwrap());
        self.announced.publish(Part::Health, head, &health);
        let gripper = Gripper {
            uid: member().uid.0,
            force_max_n: Some(33.0),
            link: LinkState::Stream,
            ..Gripper::NONE
        };
        let gripper = wire(Kind::GRIPPER, |out| gripper.write(out).unwrap());
        let log = &self.log;
        let with_log = |use_it: &mut dyn FnMut(&EventLog)| use_it(log);
        self.announced.answer(&with_log, &[gripper, health], "");
        while let Some(question) = self.announced.question() {
            let about = br#"{"program":"gripd 1","firmware":"1.2.3","model":"file"}"#;
            question.reply(about).unwrap();
        }
    }

    fn report(&mut self, text: &str) {
        let wire = notice(text);
        let id = self.log.append(wire.clone());
        self.announced.publish(Part::Events, id, &wire);
    }
}

fn member() -> Member {
    place::member(0x77)
}

/// Looks at the table until it reports this of the gripper.
fn until(hall: &Hall, mut meanwhile: impl FnMut(), done: impl Fn(&Roster) -> bool) {
    for _ in 0..PATIENCE {
        if hall.look(&done) {
            return;
        }
        meanwhile();
        pause();
    }
    panic!("it never came: {hall:?}");
}

fn states(roster: &Roster, column: Column) -> String {
    let row = roster.rows().iter().find(|row| row.member == member());
    row.map_or_else(String::new, |row| column.text(row, roster.now_s()))
}

#[test]
fn the_table_is_filled_over_a_router_that_comes_and_goes() {
    let (folder, endpoint) = (tempfile::tempdir().unwrap(), endpoint());
    let network = patient(folder.path(), &endpoint);
    let place = FleetPlace { network: network.clone(), site: None };
    let hall = Arc::<Hall>::default();
    let filled = Arc::clone(&hall);
    let _handle = FleetHandle::spawn(place, move |feed| filled.take(feed), || {}).unwrap();
    until(
        &hall,
        || {},
        |roster| matches!(roster.status(), SourceStatus::Waiting { reason, .. } if reason.contains("no router answers")),
    );
    let listening = router(&endpoint);
    let mut daemon = Daemon::start(&network);
    let is_filled = |roster: &Roster| {
        states(roster, Column::Applied) == "4.50"
            && states(roster, Column::Slips) == "3"
            && states(roster, Column::Model) == "file"
            && states(roster, Column::Firmware) == "1.2.3"
            && states(roster, Column::Here) == "here"
            && *roster.status() == SourceStatus::Live
    };
    until(&hall, || daemon.turn(), is_filled);
    drop(listening);
    let is_gone = |roster: &Roster| {
        states(roster, Column::Here) == "gone"
            && matches!(roster.status(), SourceStatus::Connecting { before, .. } if before.contains("any more"))
    };
    until(&hall, || {}, is_gone);
    assert_eq!(hall.look(|it| states(it, Column::Applied)), "4.50", "what was known stays");
    let _listening = router(&endpoint);
    until(&hall, || daemon.turn(), is_filled);
}

#[test]
fn one_gripper_of_a_network_is_a_source_without_samples() {
    let (folder, endpoint) = (tempfile::tempdir().unwrap(), endpoint());
    let network = patient(folder.path(), &endpoint);
    let _listening = router(&endpoint);
    let spec =
        SourceSpec::Other(Arc::new(GripperAt { network: network.clone(), member: member() }));
    let mut watch = Watch::new(spec);
    let absent = |model: &Model| matches!(model.status(), SourceStatus::Connecting { before, .. } if before.contains("is gone"));
    watch.until(|| {}, absent);
    let mut daemon = Daemon::start(&network);
    let rowless = |model: &Model| model.info().daemon.as_ref().is_some_and(|of| of.every_nth == 0);
    watch.until(|| daemon.turn(), rowless);
    assert_eq!(*watch.model.status(), SourceStatus::Live);
    assert_eq!(watch.model.info().gripper.and_then(|gripper| gripper.force_max_n), Some(33.0));
    assert!(samples(&watch.model, Channel::Applied) > 5, "forces come with states");
    assert_eq!(samples(&watch.model, Channel::Stylus), 0);
    assert_eq!(watch.model.health().latest.as_deref().map(|health| health.slips), Some(3));
    daemon.report("the line was opened again");
    watch.until(
        || daemon.turn(),
        |model| model.events().marks.iter().any(|mark| mark.text == "the line was opened again"),
    );
    assert!(watch.handle.orders.send(slip_core::ClientCommand::Stop).is_ok());
    watch.until(
        || daemon.turn(),
        |model| model.notices().any(|line| line.contains("sends no command")),
    );
    drop(daemon);
    watch.until(|| {}, absent);
    assert!(watch.model.events().marks.iter().any(|mark| mark.kind == EventKind::Link));
}
