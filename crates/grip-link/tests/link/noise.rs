//! Bytes that nobody meant: old sessions, late frames, echoes, noise and frames in any order.

use crate::line::{Line, Reported};
use crate::targets::gripper::{hello, wire};
use crate::targets::words::unhex;
use grip_link::frame::{Direction, Header, MAX_WIRE};
use grip_link::host::LinkState;
use grip_link::message::{DeviceState, Kind, Versions};
use proptest::prelude::{ProptestConfig, any, prop, proptest};
use proptest::prop_assert;
use rand_chacha::ChaCha8Rng;
use rand_core::{Rng, SeedableRng};

#[test]
fn a_late_hello_of_the_same_session_costs_a_new_config_and_no_force() {
    let mut line = Line::new();
    line.open();
    line.run(30_000);
    line.grip_n = Some(3.0);
    line.run(50_000);
    assert_eq!(line.force_now(), 3000);
    line.reported.clear();
    let begin = line.tick();
    let header = Header::new(Direction::ToDevice, Kind::HELLO, 2000, line.host.session());
    let mut late = Some(wire(&header, &hello(Versions::OURS, 0)));
    line.run_through(100_000, |to_device, _| to_device.extend(late.take().unwrap_or_default()));
    assert_eq!(line.states(), [LinkState::Config, LinkState::Stream]);
    assert_eq!(line.device.state(), DeviceState::Active);
    assert!(
        line.drives.iter().filter(|(tick, _)| *tick > begin).all(|(_, d)| d.force_mn() == 3000)
    );
}

#[test]
fn stale_sessions_are_dropped_on_both_sides() {
    let mut line = Line::streaming();
    line.grip_n = Some(1.0);
    line.run(10_000);
    let old_grip = unhex("01ffffff0100320010270000400d030000000000");
    let old_grip = wire(&Header::new(Direction::ToDevice, Kind::GRIP, 3, 0x1234), &old_grip);
    let mut first = true;
    line.run_through(20_000, |to_device, to_host| {
        if first {
            to_device.extend_from_slice(&old_grip);
            let header = Header::new(Direction::ToHost, Kind::STATUS, 3, 0x1234);
            to_host.extend(wire(&header, &[9; 24]));
            first = false;
        }
    });
    assert_eq!(line.device.counters().stale, 1);
    assert_eq!(line.host.counters().stale, 1);
    assert_eq!(line.force_now(), 1000);
    assert_eq!(line.host.state(), LinkState::Stream);
}

#[test]
fn a_noisy_line_never_moves_the_force_wrongly() {
    let mut random = ChaCha8Rng::seed_from_u64(7);
    let mut line = Line::new();
    line.open();
    line.grip_n = Some(4.0);
    line.run_through(5_000_000, |to_device, to_host| {
        for bytes in [to_device, to_host] {
            for byte in bytes.iter_mut() {
                if random.next_u32().is_multiple_of(2000) {
                    *byte ^= 1 << (random.next_u32() % 8);
                }
            }
        }
    });
    assert!(line.drives.iter().all(|(_, drive)| (0..=4000).contains(&drive.force_mn())));
    assert!(line.host.counters().bad_blocks() > 100);
    let loss = line.host.loss();
    assert!(loss.lost > 0 && loss.received > 15_000, "{loss:?}");
    let mut next = None;
    for reported in &line.reported {
        if let Reported::Rows(rows, _) = reported {
            for (index, _, raw) in rows {
                assert!(next.is_none_or(|next| *index >= next));
                assert_eq!(
                    u32::try_from(*raw).unwrap(),
                    index % 20_000,
                    "a wrong value was accepted"
                );
                next = Some(index + 1);
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    /// Good frames of any type with any payload, in any order: nothing breaks, force keeps its bounds.
    #[test]
    fn any_good_frames_leave_both_ends_sane(
        frames in prop::collection::vec(
            (any::<u8>(), prop::collection::vec(any::<u8>(), 0..100), any::<bool>(), 0_u64..200_000), 1..40,
        ),
    ) {
        let mut line = Line::new();
        line.open();
        line.run(50_000);
        for (seq, (kind, payload, ack_req, wait_us)) in frames.into_iter().enumerate() {
            let seq = u16::try_from(seq).unwrap() * 500 + 2000;
            let kinds = [0x01, 0x03, 0x04, 0x05, 0x06, 0x10, 0x11, 0x12, 0x13, 0x81, 0x83, 0x86, 0x8E, 0x8F, 0x90, 0x91, 0x92, 0x93, 0x94];
            let kind = Kind(kinds[usize::from(kind) % kinds.len()]);
            for direction in [Direction::ToDevice, Direction::ToHost] {
                let header = Header { ack_req, ..Header::new(direction, kind, seq, line.host.session()) };
                let bytes = wire(&header, &payload);
                let mut out = [0; MAX_WIRE];
                let tick = line.tick();
                let mut input = &bytes[..];
                while line.device.receive(tick, &mut input).is_some() {}
                let mut input = &bytes[..];
                while line.host.receive(line.now_us, &mut input).is_some() {}
                while line.device.poll_transmit(tick, &mut out).is_some() {}
                while line.host.poll_transmit(line.now_us, &mut out).is_some() {}
                prop_assert!((0..=20_000).contains(&line.device.drive(tick).force_mn()));
            }
            line.now_us += wait_us;
        }
    }
}
