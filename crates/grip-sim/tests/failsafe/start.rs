//! R5: passive at start, nothing moves without a command, nothing is let go without one.

use crate::rig::{Rig, SESSION, config, payload, press, supported, to_device};
use grip_link::host::{HostConfig, HostLink, LinkState};
use grip_link::message::{Config, DeviceState, Kind};

#[test]
fn r5_nothing_moves_without_a_command() {
    let mut rig = Rig::new(&supported(), config());
    rig.run(3_000);
    assert_eq!((rig.host.state(), rig.state()), (LinkState::Stream, DeviceState::Armed));
    assert!(rig.forces.iter().all(|n| *n <= 0.0) && rig.mcu.truth().applied_n <= 0.0);
}

#[test]
fn r5_reboot_mid_grip_is_passive_until_armed_again() {
    let mut rig = Rig::gripping(&supported(), config(), 5.0);
    rig.mcu.reset();
    let from = rig.forces.len();
    let mut armed_at = None;
    for turn in 0..600 {
        rig.run(1);
        let state = rig.state();
        if armed_at.is_none() && state == DeviceState::Active {
            armed_at = Some(turn);
        }
        assert!(armed_at.is_some() || rig.force_n() <= 0.0, "{state:?}: {} N", rig.force_n());
    }
    assert!(armed_at.is_some_and(|turn| turn >= 20), "20 ms of start-up at least: {armed_at:?}");
    assert!(rig.rebooted && rig.host.session() != SESSION, "another boot, another session");
    assert_eq!(rig.host.ident().unwrap().boot_id, 8);
    assert!(rig.forces[from..].windows(2).all(|w| w[1] - w[0] <= 0.2 + 1e-9), "up with the slew");
    assert!((rig.force_n() - 5.0).abs() < 1e-9, "and then the commands are followed again");
}

/// Old commands still in the cable do not move a gripper that has started anew.
#[test]
fn r5_commands_of_the_session_before_the_reboot_move_nothing() {
    let mut rig = Rig::gripping(&supported(), config(), 5.0);
    rig.host_runs = false;
    rig.mcu.reset();
    for k in 0..200 {
        rig.run(1);
        let grip = press(10_000 + u32::from(k), 9_000);
        rig.inject(&to_device(Kind::GRIP, 2_000 + k, SESSION), &payload(&grip));
        assert!(rig.force_n() <= 0.0 && rig.state() <= DeviceState::Idle);
    }
}

/// A new host, a new session: the grip is taken over as it is, and the old session commands nothing any more.
#[test]
fn r5_a_session_change_lets_nothing_go() {
    let mut rig = Rig::gripping(&supported(), config(), 6.0);
    let from = rig.forces.len();
    rig.host = HostLink::new(HostConfig::new(config())).unwrap();
    rig.host.open(rig.now.0, 0x1234).unwrap();
    rig.wanted_n = None;
    rig.run(300);
    assert_eq!((rig.host.state(), rig.state()), (LinkState::Stream, DeviceState::Armed));
    assert!(rig.forces[from..].iter().all(|n| (n - 6.0).abs() < 1e-9), "held through the change");
    let stale = rig.mcu.link().counters().stale;
    rig.inject(&to_device(Kind::GRIP, 60_000, SESSION), &payload(&press(9_999, 1_000)));
    rig.run(50);
    assert_eq!(rig.mcu.link().counters().stale, stale + 1);
    assert!((rig.force_n() - 6.0).abs() < 1e-9);
    rig.grip(7.0, 50);
    assert!((rig.force_n() - 7.0).abs() < 1e-9, "the new host commands");
}

/// CONFIG and STOP in the middle of a grip change limits and sampling, and let nothing go.
#[test]
fn r5_config_and_stop_let_nothing_go() {
    let mut rig = Rig::gripping(&supported(), config(), 6.0);
    let from = rig.forces.len();
    rig.wanted_n = None;
    rig.host.stop(rig.now.0);
    rig.run(1_500);
    rig.host.reconfigure(rig.now.0, Config { batch: 4, ..config() }).unwrap();
    rig.run(300);
    assert_eq!(rig.host.state(), LinkState::Stream);
    assert!(rig.forces[from..].iter().all(|n| (n - 6.0).abs() < 1e-9));
}
