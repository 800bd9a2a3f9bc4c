//! Samples that do not come: what is counted, and what a degraded host may still ask for.

use crate::line::{Line, remove};
use grip_link::frame::MAX_WIRE;
use grip_link::host::{GripCommand, LinkState};
use grip_link::message::{GripMode, Kind};

#[test]
fn a_lost_batch_degrades_and_a_good_one_mends() {
    let mut line = Line::streaming();
    line.grip_n = Some(3.0);
    line.run(50_000);
    let before = line.host.loss();
    line.reported.clear();
    let mut dropped = 0;
    line.run_through(20_000, |_, to_host| {
        dropped += remove(to_host, Kind::SAMPLES, 1 - dropped);
    });
    assert_eq!(dropped, 1);
    assert_eq!(line.states(), [LinkState::Degraded, LinkState::Stream]);
    assert_eq!(line.host.loss().lost - before.lost, 5);
    assert_eq!(line.host.loss().dropped_by_mcu, 0);
    assert!(line.host.counters().gap > 0);
}

#[test]
fn degraded_host_keeps_the_force_it_sent_before() {
    let mut line = Line::streaming();
    line.grip_n = Some(3.0);
    line.run(20_000);
    line.run_through(8_000, |_, to_host| to_host.clear());
    assert_eq!(line.host.state(), LinkState::Degraded);
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
    let mut line = Line::streaming();
    line.grip_n = Some(6.0);
    line.run(50_000);
    // A new session: the device still presses, the host has sent nothing yet and sees no samples.
    line.grip_n = None;
    line.host.open(line.now_us, 0x1234).unwrap();
    line.run_through(500_000, |_, to_host| {
        remove(to_host, Kind::SAMPLES, usize::MAX);
    });
    assert_eq!((line.host.state(), line.force_now()), (LinkState::Degraded, 6000));
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
    assert_eq!(line.host.state(), LinkState::Degraded);
    let mut out = [0; MAX_WIRE];
    let open = GripCommand { mode: GripMode::Open, ..GripCommand::newtons(0.0).unwrap() };
    assert!(line.host.grip(line.now_us, &open, &mut out).is_some());
}

#[test]
fn a_stale_link_degrades_at_the_command_itself() {
    let mut line = Line::streaming();
    let mut out = [0; MAX_WIRE];
    let command = GripCommand::newtons(2.0).unwrap();
    assert!(line.host.grip(line.now_us, &command, &mut out).is_some());
    let higher = GripCommand { force_mn: 5000, ..command };
    assert!(line.host.grip(line.now_us + 6_000, &higher, &mut out).is_some());
    assert_eq!(
        (line.host.state(), line.host.last_grip().unwrap().force_mn),
        (LinkState::Degraded, 2000)
    );
    assert!(
        line.host.grip(line.now_us + 2_000_000, &higher, &mut out).is_none(),
        "the link is lost"
    );
}

#[test]
fn blocked_transmit_drops_oldest_batches_and_counts_every_row() {
    let mut line = Line::streaming();
    line.reported.clear();
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
    assert_eq!(line.host.state(), LinkState::Stream);
}
