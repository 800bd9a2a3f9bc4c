//! R1 and R4: what commands may do, whoever writes them.

use crate::rig::{Rig, SESSION, config, frames_of, payload, press, supported, to_device, wire};
use grip_link::host::GripCommand;
use grip_link::message::{Config, DeviceState, EventKind, ForceClamp, Grip, Kind};
use proptest::prelude::{ProptestConfig, any, prop, proptest};
use proptest::prop_assert;

/// The force stays where it was when the command ran out, however far it still had to go.
#[test]
fn r1_a_stalled_host_raises_nothing() {
    let slow = Config { slew_mn_s: 10_000, ..config() };
    let mut rig = Rig::gripping(&supported(), slow, 2.0);
    rig.grip(9.0, 100);
    let before = rig.force_n();
    assert!((2.9..3.1).contains(&before), "on its way up: {before} N");
    rig.host_runs = false;
    rig.run(60);
    let stayed = rig.force_n();
    assert!(stayed <= before + 0.51, "50 ms of life are 0.5 N: {before} -> {stayed} N");
    rig.run(5_000);
    assert!(rig.forces[rig.forces.len() - 5_000..].iter().all(|n| n.to_bits() == stayed.to_bits()));
}

/// Frames that were good once, sent again: at once, later, and after others.
#[test]
fn r1_replayed_commands_raise_nothing() {
    let mut rig = Rig::gripping(&supported(), config(), 9.0);
    let mut old = Vec::new();
    rig.run_through(20, |to_device, _| old.extend(frames_of(Kind::GRIP, to_device)));
    assert!(old.len() >= 20);
    rig.grip(4.0, 100);
    let from = rig.forces.len();
    let mut next = 0;
    rig.run_through(1_000, |to_device, _| {
        to_device.extend_from_slice(&old[next % old.len()]);
        next += 1;
    });
    assert!(rig.forces[from..].iter().all(|n| *n <= 4.0), "{:?}", rig.forces.last());
    let duplicates = rig.mcu.link().counters().duplicate;
    assert!(duplicates > 100, "{duplicates} of 1000: the others come from before the window");
    let id = rig.host.last_grip().unwrap().cmd_id;
    assert!(rig.status.unwrap().last_cmd_id + 2 >= id, "and the host is heard all the while");
}

/// A stale frame whose sequence number passes is still an older command, or of another session.
#[test]
fn r1_stale_commands_raise_nothing() {
    let mut rig = Rig::gripping(&supported(), config(), 4.0);
    rig.host_runs = false;
    let newest = rig.host.last_grip().unwrap().cmd_id;
    for (round, cmd_id) in
        [newest, newest - 1, 1, 0, newest.wrapping_add(1 << 31)].into_iter().enumerate()
    {
        let seq = 20_000 + 300 * u16::try_from(round).unwrap();
        rig.inject(&to_device(Kind::GRIP, seq, SESSION), &payload(&press(cmd_id, 9_000)));
        rig.run(1);
    }
    let counters = *rig.mcu.link().counters();
    rig.inject(&to_device(Kind::GRIP, 30_000, 0x1234), &payload(&press(newest + 5, 9_000)));
    rig.inject(&to_device(Kind::GRIP, 30_001, 0), &payload(&press(newest + 6, 9_000)));
    rig.run(100);
    assert_eq!(rig.mcu.link().counters().stale, counters.stale + 2);
    assert!(rig.forces[300..].iter().all(|n| *n <= 4.0));
    assert_eq!(rig.state(), DeviceState::Hold, "none of them counts as fresh");
}

/// Both counters go round while the grip holds.
#[test]
fn r1_the_sequence_wraps_unnoticed() {
    let mut rig = Rig::gripping(&supported(), config(), 4.0);
    let from = rig.forces.len();
    rig.run(70_000);
    assert!(rig.host.last_grip().unwrap().cmd_id > 65_536);
    assert!(rig.forces[from..].iter().all(|n| (n - 4.0).abs() < 1e-9));
    let (device, host) = (rig.mcu.link().counters(), rig.host.counters());
    assert_eq!((device.gap, device.duplicate, device.stale), (0, 0, 0));
    assert_eq!((host.gap, host.duplicate, host.stale, rig.host.loss().lost), (0, 0, 0, 0));
    assert_eq!(rig.state(), DeviceState::Active);
}

/// A terminal that echoes, and a modem manager that asks what this is.
#[test]
fn r1_echo_and_modem_commands_move_nothing() {
    let mut rig = Rig::gripping(&supported(), config(), 4.0);
    let from = rig.forces.len();
    let mut turn = 0;
    rig.run_through(2_000, |to_device, to_host| {
        to_host.extend(to_device.clone());
        let back = to_host.clone();
        if turn % 10 == 0 {
            to_device.extend_from_slice(b"AT+GCAP\r\nATE1\r");
            to_device.extend(back);
        }
        turn += 1;
    });
    assert!(rig.forces[from..].iter().all(|n| (n - 4.0).abs() < 1e-9));
    assert_eq!((rig.state(), rig.closed), (DeviceState::Active, None));
    assert!(rig.mcu.link().counters().echo > 100 && rig.host.counters().echo > 1000);
    assert!(rig.mcu.link().counters().bad_blocks() >= 200, "the AT commands");
    assert_eq!(rig.host.loss().lost, 0);
}

/// On the wire a force is a whole number: what would be NaN, infinite or minus zero as a float is some integer.
#[test]
fn r4_every_odd_force_is_clamped_or_rejected() {
    let bits = |force: f32| force.to_bits().cast_signed();
    for (force_mn, accepted) in [
        (i32::MIN, false),
        (-1, false),
        (bits(-1.0), false),
        (bits(-0.0), false),
        (bits(f32::NEG_INFINITY), false),
        (bits(-f32::NAN), false),
        (bits(f32::NAN), true),
        (bits(f32::INFINITY), true),
        (i32::MAX, true),
        (10_001, true),
    ] {
        let mut rig = Rig::gripping(&supported(), config(), 4.0);
        rig.host_runs = false;
        let cmd_id = rig.host.last_grip().unwrap().cmd_id + 1;
        rig.inject_grip(&press(cmd_id, force_mn));
        rig.host_runs = true;
        rig.wanted_n = None;
        rig.run(45);
        let clamp = rig.status.unwrap().clamp;
        if accepted {
            assert!((rig.force_n() - 10.0).abs() < 1e-9, "{force_mn}: F_max, not more");
            assert!(clamp.has(ForceClamp::FORCE), "{force_mn}: {clamp:?}");
        } else {
            assert!((rig.force_n() - 4.0).abs() < 1e-9, "{force_mn}: {}", rig.force_n());
            assert!(clamp.has(ForceClamp::REJECTED), "{force_mn}: {clamp:?}");
            assert!(rig.reported(EventKind::CommandRejected), "{force_mn}");
        }
    }
}

/// The host's side refuses before anything is written.
#[test]
fn r4_the_host_writes_no_nan_and_no_negative_force() {
    for force_n in [f32::NAN, -f32::NAN, -1.0, f32::NEG_INFINITY, f32::INFINITY] {
        assert_eq!(GripCommand::newtons(force_n), None, "{force_n}");
        let mut rig = Rig::gripping(&supported(), config(), 4.0);
        let id = rig.host.last_grip().unwrap().cmd_id;
        rig.grip(force_n, 200);
        assert_eq!(rig.host.last_grip().unwrap().cmd_id, id, "{force_n}: no command was sent");
        assert!((rig.force_n() - 4.0).abs() < 1e-9);
        let negative = GripCommand { force_mn: -1, ..GripCommand::newtons(1.0).unwrap() };
        let now_us = rig.now.0;
        assert_eq!(rig.host.grip(now_us, &negative, &mut [0; grip_link::frame::MAX_WIRE]), None);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// Whatever is commanded at whatever time: 0..=F_max, within the slew, and no rise without a fresh command.
    #[test]
    fn r4_limits_hold_for_all_commands(
        commands in prop::collection::vec((any::<i32>(), any::<u8>(), any::<u16>(), any::<u32>(), 1_u32..150), 1..20),
    ) {
        let mut rig = Rig::gripping(&supported(), config(), 4.0);
        rig.host_runs = false;
        let (mut before, mut fresh_ms) = (rig.force_n(), 50);
        let first = rig.host.last_grip().unwrap().cmd_id + 1;
        for (k, (force_mn, mode, ttl_ms, slew_mn_s, wait_ms)) in (0..).zip(commands) {
            let mode = if mode < 220 { 1 } else { mode % 5 };
            let grip = Grip { cmd_id: first + k, mode, ttl_ms, slew_mn_s, ..press(0, force_mn) };
            let accepted = force_mn >= 0 && (1..=3).contains(&mode);
            rig.mcu.receive(rig.now, &wire(&to_device(Kind::GRIP, 20_000 + u16::try_from(k).unwrap() * 300, SESSION), &payload(&grip)));
            if accepted {
                // The call of the force loop at the age of exactly the ttl still moves; it shows one sample later.
                fresh_ms = 1 + if ttl_ms == 0 { 50 } else { u32::from(ttl_ms.clamp(20, 100)) };
            }
            for _ in 0..wait_ms {
                rig.run(1);
                let now = rig.force_n();
                prop_assert!((0.0..=10.0).contains(&now), "{} N", now);
                prop_assert!(now - before <= 0.2 + 2e-3, "{} -> {} N in a millisecond", before, now);
                prop_assert!(now <= before || fresh_ms > 0, "{} -> {} N without a fresh command", before, now);
                fresh_ms = fresh_ms.saturating_sub(1);
                before = now;
            }
        }
    }
}
