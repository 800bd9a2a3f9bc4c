//! What clients see: samples at their decimation, states at their interval, news, answers to QUERY.

use crate::rig::{Rig, tcp, wanted};
use grip_daemon::Item;
use grip_daemon::clients::{ClientsConfig, Listen};
use grip_link::message::daemon::{Health, Sensor, SensorHealth, Subscribe, Topics};
use grip_session::report::{Condition, Event};
use slip_core::{SlipReport, units::Micros};

#[test]
fn two_clients_see_the_samples_at_their_own_decimation() {
    let mut rig = Rig::new(tcp());
    assert!(!rig.clients.wants_samples());
    let mut all = rig.viewer(1, wanted(Topics::default(), 1));
    let mut some = rig.viewer(2, wanted(Topics::default(), 10));
    assert!(rig.clients.wants_samples());
    for _ in 0..100 {
        rig.samples(50);
        rig.turn();
        all.look();
        some.look();
    }
    rig.until(&mut all, |seen| seen.rows.len() >= 5000);
    rig.until(&mut some, |seen| seen.rows.len() >= 500);
    assert_eq!(all.seen.rows, (0..5000).collect::<Vec<_>>());
    assert_eq!(some.seen.rows, (0..5000).step_by(10).collect::<Vec<_>>());
    assert_eq!(all.client.link().counters().gap, 0);
    drop((all, some));
    for _ in 0..100 {
        rig.turn();
    }
    assert!(!rig.clients.wants_samples() && rig.clients.count() == 0);
}

#[test]
fn states_come_at_the_interval_asked_for() {
    let mut rig = Rig::new(tcp());
    let mut every = rig.viewer(1, wanted(Topics::STATE, 0));
    let slow = Subscribe { state_ms: 20, ..wanted(Topics::STATE, 0) };
    let mut slow = rig.viewer(2, slow);
    let mut none = rig.viewer(3, wanted(Topics::SLIP, 0));
    for _ in 0..200 {
        rig.state();
        rig.turn();
    }
    rig.until(&mut every, |seen| seen.states == 200);
    rig.until(&mut slow, |seen| seen.states >= 10);
    none.look();
    assert_eq!((every.seen.states, slow.seen.states, none.seen.states), (200, 10, 0));
}

#[test]
fn a_query_reports_everything_and_then_answers() {
    let mut rig = Rig::new(tcp());
    rig.state();
    rig.clients.health(&Health::default());
    for _ in 0..20 {
        let line = Event::Slip(SlipReport {
            t: Micros(500_000),
            duration_s: Some(0.01),

            ..SlipReport::UNKNOWN
        });
        rig.clients.take(&Item::Event { host_us: 5, event: &line });
    }
    let mut viewer = rig.viewer(7, wanted(Topics::default(), 0));
    viewer.client.query().unwrap();
    rig.until(&mut viewer, |seen| !seen.acks.is_empty());
    let seen = &viewer.seen;
    assert_eq!((seen.grippers, seen.states, seen.healths), (1, 1, 1));
    assert_eq!(seen.slips, (13..=20).collect::<Vec<_>>());
    assert_eq!(seen.acks, [viewer.client.link().last_request()]);
}

#[test]
fn updates_of_link_sensors_and_commands_come_in_words() {
    let mut rig = Rig::new(tcp());
    let mut viewer = rig.viewer(7, wanted(Topics::NEWS, 0));
    rig.updates();
    let condition = Condition::Sensor(Sensor::Travel, SensorHealth::Backwards);
    let line = Event::Health { t: Micros(1_000_000), condition };
    rig.clients.take(&Item::Event { host_us: 9, event: &line });
    let command = slip_core::ClientCommand::AtLeast(4.0);
    rig.clients.take(&Item::Client { host_us: 9, command });
    rig.until(&mut viewer, |seen| seen.texts.len() == 2);
    assert_eq!(viewer.seen.texts, ["travel backwards", "hold with at least 4.00 N"]);
    assert_eq!(viewer.seen.grippers, 1);
}

#[test]
fn a_socket_file_serves_as_well_and_is_gone_afterwards() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("gripd.sock");
    let mut rig = Rig::new(ClientsConfig { listen: Listen::Unix(path.clone()), ..tcp() });
    let mode = std::os::unix::fs::PermissionsExt::mode(&path.metadata().unwrap().permissions());
    assert_eq!(mode & 0o777, 0o660);
    let mut viewer = rig.viewer(1, wanted(Topics::default(), 1));
    rig.samples(100);
    rig.until(&mut viewer, |seen| seen.rows.len() == 100);
    rig.clients.close(rig.now_us);
    for _ in 0..1_000 {
        viewer.look();
    }
    assert!(viewer.seen.closed && viewer.seen.goodbye.is_some() && !path.exists());
}

#[test]
fn a_client_that_connects_again_goes_on() {
    let mut rig = Rig::new(tcp());
    let mut viewer = rig.viewer(1, wanted(Topics::default(), 1));
    let patience = core::time::Duration::from_secs(10);
    viewer.client.reconnect(2, patience).unwrap();
    rig.until(&mut viewer, |seen| seen.welcomes == 2);
    rig.samples(40);
    rig.until(&mut viewer, |seen| seen.rows.len() == 40);
    assert_eq!(rig.clients.count(), 1);
}
