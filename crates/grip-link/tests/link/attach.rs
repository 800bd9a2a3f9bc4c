//! Finding a gripper: attaching, versions, requests and who else may answer.

use crate::line::{Line, Reported, remove};
use crate::targets::gripper::{CONFIG, device, idle, wire};
use crate::targets::words::unhex;
use grip_link::frame::{Direction, Header, MAX_WIRE};
use grip_link::host::{CloseReason, HostConfig, LinkState};
use grip_link::message::{Config, DeviceState, Kind};

/// Rows of all batches, which must follow one another from row 0.
fn contiguous_rows(reported: &[Reported]) -> u32 {
    let mut next = 0;
    for reported in reported {
        if let Reported::Rows(rows, loss) = reported {
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
    assert_eq!(line.states(), [LinkState::Hello, LinkState::Config, LinkState::Stream]);
    assert!(line.reported.contains(&Reported::Identified(false)));
    assert!(line.reported.contains(&Reported::Configured(0)));
    assert_eq!(line.host.in_force(), Some(&CONFIG));
    assert_eq!(line.device.state(), DeviceState::Armed);
    let next = contiguous_rows(&line.reported);
    assert!(next > 2400, "{next} rows in half a second at 5 kHz");
    assert_eq!(line.host.loss().received, u64::from(next));
    assert_eq!(line.host.loss().lost, 0);
    assert_eq!((line.host.counters().bad_blocks(), line.host.counters().gap), (0, 0));
    assert_eq!((line.device.counters().bad_blocks(), line.device.counters().gap), (0, 0));
}

#[test]
fn device_that_boots_for_two_seconds_is_found() {
    let mut late = device(9);
    let mut line = Line::with(HostConfig::new(CONFIG), late.clone());
    line.open();
    line.run(2_000_000);
    assert_eq!(line.host.state(), LinkState::Hello);
    late.ready(line.tick());
    line.device = late;
    line.run(200_000);
    assert_eq!(line.host.state(), LinkState::Stream);
}

#[test]
fn nobody_answers() {
    let mut line = Line::new();
    line.open();
    line.run_through(3_100_000, |to_device, _| to_device.clear());
    let Some(CloseReason::NoAnswer { hellos, bytes, garbage_bytes, echoes, frames, last }) =
        line.closed()
    else {
        panic!("{:?}", line.closed())
    };
    assert_eq!((hellos, bytes, garbage_bytes, echoes, frames), (30, 0, 0, 0, 0));
    assert_eq!(last, [0; _]);
    assert_eq!(line.host.state(), LinkState::Closed);
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
    let Some(CloseReason::NoAnswer { bytes, garbage_bytes, last, .. }) = line.closed() else {
        panic!("{:?}", line.closed())
    };
    assert_eq!((bytes, garbage_bytes), (300 * 21, 300 * 20));
    assert!(last.ends_with(b"21.5 C\r\n\0temperature 21.5 C\r\n\0"), "{last:?}");
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
fn config_is_clamped_and_stated_so() {
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
    assert!(line.reported.contains(&Reported::Configured(0b0010_1101)), "{:?}", line.reported);
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
            assert_eq!(line.host.state(), LinkState::Stream, "{lost} lost");
        } else {
            assert_eq!(line.closed(), Some(CloseReason::Unanswered { kind: 3 }));
        }
    }
}

#[test]
fn lost_start_ack_is_made_good_by_the_samples() {
    let mut line = Line::new();
    line.open();
    let mut removed = 0;
    line.run_through(300_000, |_, to_host| removed += remove(to_host, Kind::ACK, 9));
    assert!(removed > 0);
    assert_eq!(line.host.state(), LinkState::Stream);
    assert_eq!(line.closed(), None);
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
