//! Host and device on a simulated line: attaching, streaming, losses, reboots and silence.

use crate::gripper::{CONFIG, hello, ident, idle, wire};
use crate::line::{Line, Told, remove};
use crate::words::unhex;
use grip_link::device::{DeviceConfig, DeviceEvent, DeviceLink, Drive};
use grip_link::frame::{Direction, Header, MAX_WIRE};
use grip_link::host::{CloseReason, GripCommand, HostConfig, HostEvent, HostState};
use grip_link::message::{
    Config, DeviceState, FaultCode, GripMode, Heartbeat, Kind, LogLevel, NackReason, Reaction,
    Versions,
};
use proptest::prelude::{ProptestConfig, any, prop, proptest};
use proptest::prop_assert;

/// Rows of all batches, which must follow one another from row 0.
fn contiguous_rows(told: &[Told]) -> u32 {
    let mut next = 0;
    for told in told {
        if let Told::Rows(rows, loss) = told {
            assert!(loss.is_contiguous());
            for (index, tick, raw) in rows {
                assert_eq!(*index, next);
                assert_eq!(tick % 200, 0);
                assert_eq!(u32::try_from(*raw).unwrap(), next % 20_000);
                next += 1;
            }
        }
    }
    next
}

#[test]
fn attaches_and_streams_without_loss() {
    let mut line = Line::new();
    line.open();
    line.run(500_000);
    assert_eq!(line.states(), [HostState::Hello, HostState::Config, HostState::Stream]);
    assert!(line.told.contains(&Told::Identified(false)));
    assert!(line.told.contains(&Told::Configured(0)));
    assert_eq!(line.host.in_force(), Some(&CONFIG));
    assert_eq!(line.device.state(), DeviceState::Armed);
    let next = contiguous_rows(&line.told);
    assert!(next > 2400, "{next} rows in half a second at 5 kHz");
    assert_eq!(line.host.loss().received, u64::from(next));
    assert_eq!(line.host.loss().lost, 0);
    assert_eq!((line.host.counters().bad_blocks(), line.host.counters().gap), (0, 0));
    assert_eq!((line.device.counters().bad_blocks(), line.device.counters().gap), (0, 0));
}

#[test]
fn status_comes_at_least_every_ten_milliseconds() {
    let mut line = Line::new();
    line.open();
    line.run(100_000);
    line.told.clear();
    line.run(1_000_000);
    let count = line.told.iter().filter(|told| matches!(told, Told::Status(_))).count();
    assert!(count >= 100, "{count}");
}

#[test]
fn every_grip_is_answered_by_status() {
    let mut line = Line::new();
    line.open();
    line.run(100_000);
    line.grip_n = Some(2.0);
    line.told.clear();
    line.run(100_000);
    let ids: Vec<u32> = line
        .told
        .iter()
        .filter_map(|t| if let Told::Status(s) = t { Some(s.last_cmd_id) } else { None })
        .collect();
    let newest = line.host.last_grip().unwrap().cmd_id;
    assert!(newest >= 99);
    for id in 1..newest {
        assert!(ids.contains(&id), "no STATUS told command {id}");
    }
    assert_eq!(line.force_now(), 2000);
}

#[test]
fn device_that_boots_for_two_seconds_is_found() {
    let mut late =
        DeviceLink::new(DeviceConfig { ident: ident(9), estop: Reaction::Hold }).unwrap();
    let mut line = Line::with(HostConfig::new(CONFIG), late.clone());
    line.open();
    line.run(2_000_000);
    assert_eq!(line.host.state(), HostState::Hello);
    late.ready(line.tick());
    line.device = late;
    line.run(200_000);
    assert_eq!(line.host.state(), HostState::Stream);
}

#[test]
fn nobody_answers() {
    let mut line = Line::new();
    line.open();
    line.run_through(3_100_000, |to_device, _| to_device.clear());
    let Some(CloseReason::NoAnswer { hellos, bytes, garbage_bytes, echoes, frames }) =
        line.closed()
    else {
        panic!("{:?}", line.closed())
    };
    assert_eq!((hellos, bytes, garbage_bytes, echoes, frames), (30, 0, 0, 0, 0));
    assert_eq!(line.host.state(), HostState::Closed);
}

#[test]
fn another_protocol_answers() {
    let mut line = Line::new();
    line.open();
    let mut steps = 0;
    line.run_through(3_100_000, |to_device, to_host| {
        to_device.clear();
        *to_host = if steps % 100 == 0 { b"temperature 21.5 C\r\n\0".to_vec() } else { Vec::new() };
        steps += 1;
    });
    let Some(CloseReason::NoAnswer { bytes, garbage_bytes, .. }) = line.closed() else {
        panic!("{:?}", line.closed())
    };
    assert_eq!((bytes, garbage_bytes), (300 * 21, 300 * 20));
}

#[test]
fn an_echoing_line_is_told_apart() {
    let mut line = Line::new();
    line.open();
    line.run_through(3_100_000, |to_device, to_host| {
        to_host.clear();
        core::mem::swap(to_device, to_host);
    });
    let Some(CloseReason::NoAnswer { hellos, echoes, .. }) = line.closed() else {
        panic!("{:?}", line.closed())
    };
    assert_eq!(hellos, echoes);
}

#[test]
fn versions_that_do_not_meet_are_named() {
    let mut line = Line::new();
    line.open();
    let session = 0xBEEF;
    line.run_through(10_000, |to_device, to_host| {
        to_device.clear();
        let header =
            Header { version: 3, ..Header::new(Direction::ToHost, Kind::IDENT, 0, session) };
        *to_host = wire(&header, &[2, 3, 7]);
    });
    assert_eq!(line.closed(), Some(CloseReason::VersionMismatch { min: 2, max: 3 }));
}

#[test]
fn device_answers_a_host_of_another_version_and_stays_unlinked() {
    let mut gripper = idle(5);
    let header = Header { version: 4, ..Header::new(Direction::ToDevice, Kind::HELLO, 0, 77) };
    let mut hello = unhex("0304e0010000000000000000000000000000");
    hello.truncate(16);
    let bytes = wire(&header, &hello);
    assert_eq!(gripper.receive(10, &mut &bytes[..]), None);
    assert_eq!(gripper.state(), DeviceState::Idle);
    let mut reply = [0; MAX_WIRE];
    assert!(gripper.poll_transmit(20, &mut reply).is_some());
}

#[test]
fn config_is_clamped_and_said_so() {
    let wanted = Config {
        force_max_mn: 90_000,
        ttl_ms: 500,
        sample_rate_hz: 1_000_000,
        channel_mask: 0xFF,
        ..CONFIG
    };
    let mut line = Line::with(HostConfig::new(wanted), idle(1));
    line.sample_every_us = u64::MAX;
    line.open();
    line.run(2_000);
    assert!(line.told.contains(&Told::Configured(0b0010_1101)), "{:?}", line.told);
    let given = line.host.in_force().unwrap();
    assert_eq!((given.force_max_mn, given.ttl_ms, given.sample_rate_hz), (20_000, 100, 20_000));
    assert_eq!(given.channel_mask, 0b111);
}

#[test]
fn requests_are_tried_three_times() {
    for lost in 0..4 {
        let mut line = Line::new();
        line.open();
        let mut seen = 0;
        line.run_through(1_000_000, |to_device, _| {
            seen += remove(to_device, Kind::CONFIG, lost - seen);
        });
        if lost < 3 {
            assert_eq!(line.host.state(), HostState::Stream, "{lost} lost");
        } else {
            assert_eq!(line.closed(), Some(CloseReason::Unanswered { kind: 3 }));
        }
    }
}

#[test]
fn a_lost_batch_degrades_and_a_good_one_mends() {
    let mut line = Line::new();
    line.open();
    line.run(100_000);
    line.grip_n = Some(3.0);
    line.run(50_000);
    let before = line.host.loss();
    line.told.clear();
    let mut dropped = 0;
    line.run_through(20_000, |_, to_host| {
        dropped += remove(to_host, Kind::SAMPLES, 1 - dropped);
    });
    assert_eq!(dropped, 1);
    assert_eq!(line.states(), [HostState::Degraded, HostState::Stream]);
    assert_eq!(line.host.loss().lost - before.lost, 5);
    assert_eq!(line.host.loss().dropped_by_mcu, 0);
    assert!(line.host.counters().gap > 0);
}

#[test]
fn degraded_host_keeps_the_force_it_sent_before() {
    let mut line = Line::new();
    line.open();
    line.run(100_000);
    line.grip_n = Some(3.0);
    line.run(20_000);
    line.run_through(8_000, |_, to_host| to_host.clear());
    assert_eq!(line.host.state(), HostState::Degraded);
    line.grip_n = Some(9.0);
    let begin = line.tick();
    line.run_through(30_000, |_, to_host| to_host.clear());
    assert_eq!(line.host.last_grip().unwrap().force_mn, 3000);
    assert_eq!(line.most_since(begin), 3000);
    line.grip_n = Some(2.0);
    line.run_through(5_000, |_, to_host| to_host.clear());
    assert_eq!(line.host.last_grip().unwrap().force_mn, 2000, "lower is always possible");
}

#[test]
fn a_degraded_host_that_has_sent_no_force_sends_none() {
    let mut line = Line::new();
    line.open();
    line.run(100_000);
    line.grip_n = Some(6.0);
    line.run(50_000);
    // A new session: the device still presses, the host has sent nothing yet and sees no samples.
    line.grip_n = None;
    line.host.open(line.now_us, 0x1234).unwrap();
    line.run_through(500_000, |_, to_host| {
        remove(to_host, Kind::SAMPLES, usize::MAX);
    });
    assert_eq!((line.host.state(), line.force_now()), (HostState::Degraded, 6000));
    let mut out = [0; MAX_WIRE];
    assert_eq!(line.host.grip(line.now_us, &GripCommand::newtons(0.0).unwrap(), &mut out), None);
    line.grip_n = Some(9.0);
    line.run_through(200_000, |_, to_host| {
        remove(to_host, Kind::SAMPLES, usize::MAX);
    });
    assert_eq!(line.force_now(), 6000, "what is held stays held");
    line.run(20_000);
    assert_eq!(line.force_now(), 9000);
}

#[test]
fn a_degraded_host_still_opens_the_fingers_when_asked() {
    let mut line = Line::new();
    line.open();
    line.run_through(500_000, |_, to_host| {
        remove(to_host, Kind::SAMPLES, usize::MAX);
    });
    assert_eq!(line.host.state(), HostState::Degraded);
    let mut out = [0; MAX_WIRE];
    let open = GripCommand { mode: GripMode::Open, ..GripCommand::newtons(0.0).unwrap() };
    assert!(line.host.grip(line.now_us, &open, &mut out).is_some());
}

#[test]
fn a_late_hello_of_the_same_session_costs_a_new_config_and_no_force() {
    let mut line = Line::new();
    line.open();
    line.run(30_000);
    line.grip_n = Some(3.0);
    line.run(50_000);
    assert_eq!(line.force_now(), 3000);
    line.told.clear();
    let begin = line.tick();
    let header = Header::new(Direction::ToDevice, Kind::HELLO, 2000, line.host.session());
    let mut late = Some(wire(&header, &hello(Versions::OURS, 0)));
    line.run_through(100_000, |to_device, _| to_device.extend(late.take().unwrap_or_default()));
    assert_eq!(line.states(), [HostState::Config, HostState::Stream]);
    assert_eq!(line.device.state(), DeviceState::Active);
    assert!(
        line.drives.iter().filter(|(tick, _)| *tick > begin).all(|(_, d)| d.force_mn() == 3000)
    );
}

#[test]
fn silence_closes_the_link() {
    let mut line = Line::new();
    line.open();
    line.run(100_000);
    line.run_through(1_100_000, |_, to_host| to_host.clear());
    assert!(
        matches!(line.closed(), Some(CloseReason::Lost { silent_us }) if silent_us > 1_000_000)
    );
    assert_eq!(line.states().last(), Some(&HostState::Closed));
    assert_eq!(line.host.reopen_after_us(), 50_000);
    line.told.clear();
    line.open();
    line.run(200_000);
    assert_eq!(line.host.state(), HostState::Stream, "opens again, with the same nonce too");
}

#[test]
fn stalled_host_holds_then_takes_the_loss_action() {
    let mut line = Line::new();
    line.open();
    line.run(100_000);
    line.grip_n = Some(9.5);
    line.run(100_000);
    assert_eq!((line.device.state(), line.force_now()), (DeviceState::Active, 9500));
    line.host_runs = false;
    let begin = line.tick();
    line.run(45_000);
    assert_eq!(line.device.state(), DeviceState::Active);
    line.run(60_000);
    assert_eq!(line.device.state(), DeviceState::Hold);
    assert_eq!(line.force_now(), 8000, "falls to the hold cap");
    assert!(line.most_since(begin) <= 9500);
    line.run(1_000_000);
    assert_eq!(line.device.state(), DeviceState::LossAction);
    assert_eq!(
        line.drives.last().unwrap().1,
        Drive::Force(8000),
        "the configured action is to keep holding"
    );
}

#[test]
fn stalled_host_comes_back_within_the_hold() {
    let mut line = Line::new();
    line.open();
    line.run(100_000);
    line.grip_n = Some(5.0);
    line.run(100_000);
    line.host_runs = false;
    line.run(200_000);
    assert_eq!(line.device.state(), DeviceState::Hold);
    line.host_runs = true;
    line.run(20_000);
    assert_eq!((line.device.state(), line.force_now()), (DeviceState::Active, 5000));
}

#[test]
fn reboot_mid_grip_arms_again_and_drops_the_force() {
    let mut line = Line::new();
    line.open();
    line.run(100_000);
    line.grip_n = Some(4.0);
    line.run(100_000);
    line.told.clear();
    line.reboot(2);
    line.run(100);
    assert_eq!(line.drives.last().unwrap().1, Drive::Passive, "passive at start");
    line.run(400_000);
    assert!(line.told.contains(&Told::Rebooted(1, 2)));
    assert!(line.told.contains(&Told::Identified(true)));
    assert_eq!(line.host.state(), HostState::Stream);
    assert_ne!(line.host.session(), 0xBEEF);
    assert_eq!(line.host.clock().unwrap().boot_id(), 2);
    assert_eq!((line.device.state(), line.force_now()), (DeviceState::Active, 4000));
}

#[test]
fn stale_sessions_are_dropped_on_both_sides() {
    let mut line = Line::new();
    line.open();
    line.run(100_000);
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
    assert_eq!(line.host.state(), HostState::Stream);
}

#[test]
fn echoes_and_modem_commands_do_no_harm() {
    let mut line = Line::new();
    line.open();
    let mut step = 0;
    line.run_through(300_000, |to_device, to_host| {
        let echo = to_device.clone();
        to_host.extend_from_slice(&echo);
        if step < 50 {
            to_device.splice(0..0, *b"AT+GCAP\r");
        }
        step += 1;
    });
    assert_eq!(line.host.state(), HostState::Stream);
    assert!(line.host.counters().echo > 0);
    assert_eq!(line.host.loss().lost, 0);
}

#[test]
fn blocked_transmit_drops_oldest_batches_and_counts_every_row() {
    let mut line = Line::new();
    line.open();
    line.run(100_000);
    line.told.clear();
    line.device_frames_a_step = 0;
    line.run(4_000);
    line.run(16_000);
    line.device_frames_a_step = 8;
    line.run(50_000);
    let loss = line.host.loss();
    assert!(loss.lost >= 70, "{loss:?}");
    assert_eq!(loss.lost, loss.dropped_by_mcu, "nothing was lost on the wire");
    assert_eq!(u64::from(line.device.dropped_rows()), loss.lost);
    let pushed = u64::from(line.samples_pushed);
    assert!(
        pushed - (loss.received + loss.lost) <= 10,
        "every row is received, lost or on its way"
    );
    assert_eq!(line.host.state(), HostState::Stream);
}

#[test]
fn estop_is_latched_until_it_is_cleared() {
    let mut line = Line::new();
    line.open();
    line.run(100_000);
    line.grip_n = Some(6.0);
    line.run(50_000);
    let mut out = [0; MAX_WIRE];
    let len = line.host.estop(&mut out).unwrap();
    let mut first = true;
    line.run_through(50_000, |to_device, _| {
        if first {
            to_device.extend_from_slice(&out[..len]);
            first = false;
        }
    });
    assert!(line.device_events.contains(&DeviceEvent::Estop));
    assert_eq!(line.device.state(), DeviceState::Estop);
    assert_eq!(line.last_status().fault, FaultCode::ESTOP);
    assert_eq!(line.force_now(), 6000, "held, not dropped, not raised");
    line.grip_n = Some(9.0);
    line.run(50_000);
    assert_eq!(line.force_now(), 6000, "commands are rejected");
    line.grip_n = None;
    line.host.clear_fault(line.now_us, FaultCode::OBJECT_LOST);
    line.run(10_000);
    assert_eq!(line.device.state(), DeviceState::Estop, "the wrong code clears nothing");
    line.host.clear_fault(line.now_us, FaultCode::ESTOP);
    line.run(100_000);
    assert_eq!(line.device.state(), DeviceState::Armed);
    assert_eq!(line.host.state(), HostState::Stream);
    line.grip_n = Some(7.0);
    line.run(50_000);
    assert_eq!(line.force_now(), 7000);
}

#[test]
fn latched_fault_refuses_config_but_not_the_session() {
    let mut faulty = idle(1);
    faulty.raise_fault(0, FaultCode::OBJECT_LOST);
    let mut line = Line::with(HostConfig::new(CONFIG), faulty);
    line.open();
    line.run(300_000);
    assert_eq!(line.host.state(), HostState::Config);
    assert_eq!(line.host.ident().unwrap().fault, FaultCode::OBJECT_LOST);
    let refusal = format!("{:?}", NackReason::Latched);
    assert!(
        line.told.iter().any(|told| matches!(told, Told::Other(text) if text.contains(&refusal)))
    );
    line.host.clear_fault(line.now_us, FaultCode::OBJECT_LOST);
    line.run(100_000);
    assert_eq!(line.host.state(), HostState::Stream);
}

#[test]
fn stop_and_start_keep_the_link() {
    let mut line = Line::new();
    line.open();
    line.run(100_000);
    line.host.stop(line.now_us);
    line.run(50_000);
    assert_eq!(line.host.state(), HostState::Config);
    let received = line.host.loss().received;
    line.run(2_000_000);
    assert_eq!(line.host.loss().received, received);
    assert_eq!(line.closed(), None, "STATUS keeps the link alive");
    line.host.start(line.now_us);
    line.run(50_000);
    assert_eq!(line.host.state(), HostState::Stream);
    assert_eq!(line.host.loss().lost, 0);
}

#[test]
fn lost_start_ack_is_made_good_by_the_samples() {
    let mut line = Line::new();
    line.open();
    let mut removed = 0;
    line.run_through(300_000, |_, to_host| removed += remove(to_host, Kind::ACK, 9));
    assert!(removed > 0);
    assert_eq!(line.host.state(), HostState::Stream);
    assert_eq!(line.closed(), None);
}

#[test]
fn a_noisy_line_never_moves_the_force_wrongly() {
    use rand_chacha::ChaCha8Rng;
    use rand_core::{Rng, SeedableRng};
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
    for told in &line.told {
        if let Told::Rows(rows, _) = told {
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

#[test]
fn waits_longer_after_each_failure() {
    let mut line = Line::new();
    let mut waits = Vec::new();
    for _ in 0..8 {
        waits.push(line.host.reopen_after_us() / 1000);
        line.open();
        line.run_through(3_100_000, |to_device, _| to_device.clear());
    }
    assert_eq!(waits, [0, 50, 100, 200, 400, 800, 1600, 2000]);
    line.open();
    line.run(100_000);
    assert_eq!(line.host.reopen_after_us(), 0);
}

#[test]
fn forces_in_newtons_become_millinewtons() {
    let force = |newtons| GripCommand::newtons(newtons).map(|command| command.force_mn);
    assert_eq!(
        (force(2.5), force(0.0), force(0.0004), force(-0.0)),
        (Some(2500), Some(0), Some(0), Some(0))
    );
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -0.001, 3e6] {
        assert_eq!(force(bad), None);
    }
}

#[test]
fn a_stale_link_degrades_at_the_command_itself() {
    let mut line = Line::new();
    line.open();
    line.run(100_000);
    let mut out = [0; MAX_WIRE];
    let command = GripCommand::newtons(2.0).unwrap();
    assert!(line.host.grip(line.now_us, &command, &mut out).is_some());
    let higher = GripCommand { force_mn: 5000, ..command };
    assert!(line.host.grip(line.now_us + 6_000, &higher, &mut out).is_some());
    assert_eq!(
        (line.host.state(), line.host.last_grip().unwrap().force_mn),
        (HostState::Degraded, 2000)
    );
    assert!(
        line.host.grip(line.now_us + 2_000_000, &higher, &mut out).is_none(),
        "the link is lost"
    );
}

#[test]
fn texts_and_heartbeats_pass() {
    let mut line = Line::new();
    line.open();
    line.run(100_000);
    let mut out = [0; MAX_WIRE];
    let len = line.device.log(line.tick(), LogLevel::Warn, "supply low", &mut out).unwrap();
    let text = match line.host.receive(line.now_us, &mut &out[..len]) {
        Some(HostEvent::Log(log)) => log.as_str().to_owned(),
        other => panic!("{other:?}"),
    };
    assert_eq!(text, "supply low");
    let beat = Heartbeat { turns: 1, longest_us: 2, late: 3, flags: 0 };
    let len = line.host.heartbeat(&beat, &mut out).unwrap();
    assert_eq!(
        line.device.receive(line.tick(), &mut &out[..len]),
        Some(DeviceEvent::Heartbeat(beat))
    );
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
