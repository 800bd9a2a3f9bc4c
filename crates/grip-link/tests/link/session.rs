//! An open link: STATUS, commands, stops, faults, texts and heartbeats.

use crate::line::{Line, Reported};
use crate::targets::gripper::{CONFIG, idle};
use grip_link::device::DeviceEvent;
use grip_link::frame::MAX_WIRE;
use grip_link::host::{GripCommand, HostConfig, HostEvent, LinkState};
use grip_link::message::{DeviceState, FaultCode, Heartbeat, LogLevel, NackReason};

#[test]
fn every_grip_is_answered_by_status() {
    let mut line = Line::streaming();
    line.grip_n = Some(2.0);
    line.reported.clear();
    line.run(100_000);
    let ids: Vec<u32> = line
        .reported
        .iter()
        .filter_map(|t| if let Reported::Status(s) = t { Some(s.last_cmd_id) } else { None })
        .collect();
    let newest = line.host.last_grip().unwrap().cmd_id;
    assert!(newest >= 99);
    for id in 1..newest {
        assert!(ids.contains(&id), "no STATUS told command {id}");
    }
    assert_eq!(line.force_now(), 2000);
}

#[test]
fn estop_is_latched_until_it_is_cleared() {
    let mut line = Line::streaming();
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
    assert_eq!(line.host.state(), LinkState::Stream);
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
    assert_eq!(line.host.state(), LinkState::Config);
    assert_eq!(line.host.ident().unwrap().fault, FaultCode::OBJECT_LOST);
    let refusal = format!("{:?}", NackReason::Latched);
    assert!(
        line.reported
            .iter()
            .any(|reported| matches!(reported, Reported::Other(text) if text.contains(&refusal)))
    );
    line.host.clear_fault(line.now_us, FaultCode::OBJECT_LOST);
    line.run(100_000);
    assert_eq!(line.host.state(), LinkState::Stream);
}

#[test]
fn stop_and_start_keep_the_link() {
    let mut line = Line::streaming();
    line.host.stop(line.now_us);
    line.run(50_000);
    assert_eq!(line.host.state(), LinkState::Config);
    let received = line.host.loss().received;
    line.run(2_000_000);
    assert_eq!(line.host.loss().received, received);
    assert_eq!(line.closed(), None, "STATUS keeps the link alive");
    line.host.start(line.now_us);
    line.run(50_000);
    assert_eq!(line.host.state(), LinkState::Stream);
    assert_eq!(line.host.loss().lost, 0);
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
fn texts_and_heartbeats_pass() {
    let mut line = Line::streaming();
    let mut out = [0; MAX_WIRE];
    let len = line.device.log(line.tick(), LogLevel::Warn, "supply low", &mut out).unwrap();
    assert_eq!(line.host.receive(line.now_us, &mut &out[..len]), Some(HostEvent::Log));
    assert_eq!(line.host.log().unwrap().as_str(), "supply low");
    let beat = Heartbeat { turns: 1, longest_us: 2, late: 3, flags: 0 };
    let len = line.host.heartbeat(&beat, &mut out).unwrap();
    assert_eq!(
        line.device.receive(line.tick(), &mut &out[..len]),
        Some(DeviceEvent::Heartbeat(beat))
    );
}
