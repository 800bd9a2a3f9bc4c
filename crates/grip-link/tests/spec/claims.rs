//! Sentences of the pages of the protocol that no table holds and no other test of the crate asks.

use crate::rig::{device, hello, report};
use crate::targets::gripper::{self, CONFIG, SESSION, sent, wire, written};
use grip_link::device::{DeviceLink, Drive};
use grip_link::frame::{Direction, Header};
use grip_link::message::{
    ClearFault, Config, DeviceState, Event, EventKind, FaultCode, Grip, Kind, Nack, NackReason,
    SamplesHeader, Stats, Status,
};

fn armed(config: &Config) -> DeviceLink {
    let mut device = device();
    report(&mut device, 1, Kind::HELLO, 0, &hello());
    report(&mut device, 2, Kind::CONFIG, 1, &config.to_bytes());
    let _answers = sent(&mut device, 3);
    device
}

fn press(cmd_id: u32, force_mn: i32) -> Vec<u8> {
    written(|p| Grip { ttl_ms: 100, ..gripper::press(cmd_id, force_mn) }.write(p))
}

/// Presses until the force is there; the tick then.
fn pressing(device: &mut DeviceLink, force_mn: i32) -> u64 {
    report(device, 1000, Kind::GRIP, 2, &press(1, force_mn));
    let end = (1000..101_000).step_by(1000).find(|tick| device.drive(*tick).force_mn() == force_mn);
    end.unwrap()
}

#[test]
fn estop_of_session_0_adds_one_to_gap() {
    let mut device = armed(&CONFIG);
    let header = Header { ack_req: true, ..Header::new(Direction::ToDevice, Kind::ESTOP, 2, 0) };
    assert!(device.receive(4, &mut &wire(&header, &[])[..]).is_some());
    assert_eq!((device.state(), device.counters().gap), (DeviceState::Estop, 0));
    report(&mut device, 5, Kind::STOP, 3, &[]);
    assert_eq!(device.counters().gap, 1);
}

#[test]
fn estop_without_a_session_is_answered() {
    let mut device = device();
    let header = Header { ack_req: true, ..Header::new(Direction::ToDevice, Kind::ESTOP, 0, 0) };
    assert!(device.receive(4, &mut &wire(&header, &[])[..]).is_some());
    assert_eq!(sent(&mut device, 5).iter().map(|(kind, _)| *kind).collect::<Vec<_>>(), [Kind::ACK]);
}

#[test]
fn the_bytes_of_an_attach_that_come_again_do_nothing() {
    let mut device = armed(&CONFIG);
    let tick = pressing(&mut device, 6_000);
    report(&mut device, tick, Kind::GRIP, 3, &press(2, 1_000));
    report(&mut device, tick, Kind::HELLO, 0, &hello());
    report(&mut device, tick, Kind::CONFIG, 1, &CONFIG.to_bytes());
    report(&mut device, tick, Kind::GRIP, 2, &press(1, 6_000));
    assert_eq!((device.state(), device.counters().duplicate), (DeviceState::Active, 3));
    assert_eq!(device.status(tick).target_mn, 1_000);
}

#[test]
fn a_newer_hello_of_the_open_session_is_obeyed_and_counts_in_the_sequence() {
    let mut device = armed(&CONFIG);
    report(&mut device, 5, Kind::HELLO, 9, &hello());
    assert_eq!((device.state(), device.counters().gap), (DeviceState::Linked, 7));
    report(&mut device, 6, Kind::STOP, 8, &[]);
    assert_eq!(device.counters().duplicate, 1);
}

#[test]
fn rejects_without_an_answer_are_counted_too() {
    let mut device = armed(&CONFIG);
    let tick = pressing(&mut device, 6_000);
    report(&mut device, tick, Kind::GRIP, 3, &press(1, 7_000));
    let silent = |kind, seq| Header::new(Direction::ToDevice, kind, seq, SESSION);
    let clear = written(|p| ClearFault { fault: FaultCode::DRIVE }.write(p));
    assert!(device.receive(tick, &mut &wire(&silent(Kind::CLEAR_FAULT, 4), &clear)[..]).is_none());
    for seq in 5..15 {
        report(&mut device, tick, Kind::STOP, seq, &[]);
    }
    let frames = sent(&mut device, tick + 2_000_000);
    let stats = &frames.iter().find(|(kind, _)| *kind == Kind::STATS).unwrap().1;
    let stats = Stats::parse(stats).unwrap();
    assert_eq!((stats.old, stats.refused, stats.unanswered), (1, 1, 2));
}

#[test]
fn config_holds_with_its_own_cap() {
    let mut device = armed(&Config { hold_cap_mn: 8_000, ..CONFIG });
    let tick = pressing(&mut device, 6_000);
    let lower = Config { hold_cap_mn: 1_000, ..CONFIG };
    report(&mut device, tick, Kind::CONFIG, 3, &lower.to_bytes());
    assert_eq!(device.status(tick).target_mn, 1_000);
    for ms in 1..500 {
        device.drive(tick + ms * 1000);
    }
    assert_eq!(device.drive(tick + 500_000), Drive::Force(1_000));
}

#[test]
fn batches_wait_over_a_stop() {
    let mut device = armed(&Config { batch: 1, ..CONFIG });
    report(&mut device, 4, Kind::START, 2, &[]);
    device.push_i16(5, &[1, 2]).unwrap();
    report(&mut device, 6, Kind::STOP, 3, &[]);
    let is_samples = |(kind, _): &&(Kind, Vec<u8>)| *kind == Kind::SAMPLES;
    assert_eq!(sent(&mut device, 7).iter().find(is_samples), None);
    report(&mut device, 8, Kind::START, 4, &[]);
    let frames = sent(&mut device, 9);
    let header = SamplesHeader::parse(&frames.iter().find(is_samples).unwrap().1).unwrap();
    assert_eq!((header.t0_tick, header.first_index), (5, 0));
}

#[test]
fn no_channel_left_is_counted_as_refused_not_as_malformed() {
    let mut device = armed(&CONFIG);
    let none = Config { channel_mask: 0x80, ..CONFIG };
    report(&mut device, 4, Kind::CONFIG, 2, &none.to_bytes());
    let frames = sent(&mut device, 2_000_000);
    let nack = &frames.iter().find(|(kind, _)| *kind == Kind::NACK).unwrap().1;
    assert_eq!(Nack::parse(nack).unwrap().reason, NackReason::Malformed);
    let stats = &frames.iter().find(|(kind, _)| *kind == Kind::STATS).unwrap().1;
    assert_eq!(stats[60..], [0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0]);
    assert_eq!(device.in_force(), Some(&CONFIG));
}

#[test]
fn a_request_without_ack_req_is_carried_out_silently() {
    let mut device = armed(&CONFIG);
    let header = Header::new(Direction::ToDevice, Kind::START, 2, SESSION);
    assert!(device.receive(4, &mut &wire(&header, &[])[..]).is_some());
    assert!(device.push_i16(5, &[1, 2]).is_ok());
    assert!(sent(&mut device, 5).iter().all(|(kind, _)| *kind != Kind::ACK));
}

#[test]
fn a_fault_beneath_an_estop_is_reported_and_shows_when_the_stop_is_cleared() {
    let mut device = armed(&CONFIG);
    device.estop(10);
    let _stop = sent(&mut device, 11);
    device.raise_fault(20, FaultCode::DRIVE);
    let events: Vec<Event> = sent(&mut device, 21)
        .iter()
        .filter(|(kind, _)| *kind == Kind::EVENT)
        .map(|(_, payload)| Event::parse(payload).unwrap())
        .collect();
    assert_eq!(events.len(), 1);
    assert_eq!((events[0].kind, events[0].fault), (EventKind::Fault, FaultCode::ESTOP));
    assert_eq!(events[0].value, i32::from(FaultCode::DRIVE.0));
    let clear = ClearFault { fault: FaultCode::ESTOP };
    report(&mut device, 30, Kind::CLEAR_FAULT, 2, &written(|p| clear.write(p)));
    assert_eq!((device.state(), device.fault()), (DeviceState::Fault, FaultCode::DRIVE));
}

#[test]
fn a_lower_target_is_still_reached_in_hold() {
    let mut device = armed(&CONFIG);
    let tick = pressing(&mut device, 6_000);
    let slow = Grip { ttl_ms: 20, slew_mn_s: 10_000, ..gripper::press(2, 1_000) };
    report(&mut device, tick, Kind::GRIP, 3, &written(|p| slow.write(p)));
    for ms in 1..600 {
        device.drive(tick + ms * 1000);
    }
    assert_eq!(device.state(), DeviceState::Hold);
    assert_eq!(device.drive(tick + 600_000), Drive::Force(1_000));
}

#[test]
fn status_without_a_command_states_so() {
    let device = armed(&CONFIG);
    let Status { last_cmd_id, age_us, flags, .. } = device.status(99);
    assert_eq!((last_cmd_id, age_us, flags.0), (0, 4_294_967_295, 4 | 16));
}
