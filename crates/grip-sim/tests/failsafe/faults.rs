//! R6 to R9: faults of sensors, object and firmware.

use crate::rig::{Rig, config, lifted, supported, without_travel};
use grip_link::message::{Config, DeviceState, EventKind, FaultCode, Reaction};
use grip_sim::mcu::{Sensor, SensorFault, Task};

/// Every listed code, and some that no version knows: an unknown one is major.
const CODES: [u16; 16] = [
    0x0101, 0x0102, 0x0103, 0x0104, 0x0201, 0x0202, 0x0203, 0x0204, 0x0205, 0x0206, 0x0002, 0x0100,
    0x0105, 0x0207, 0x7FFF, 0xFFFF,
];

#[test]
fn r6_every_fault_latches_until_it_is_cleared_by_name() {
    for code in CODES {
        let fault = FaultCode(code);
        let minor = (0x0101..=0x0104).contains(&code);
        let mut rig = Rig::gripping(&supported(), config(), 9.0);
        rig.mcu.raise_fault(fault);
        let from = rig.forces.len();
        rig.grip(10.0, 500);
        let expected = if minor { 8.0 } else { 0.0 };
        assert!((rig.force_n() - expected).abs() < 1e-9, "{code:04x}: {} N", rig.force_n());
        assert!(rig.forces[from..].iter().all(|n| *n <= 9.0), "{code:04x} raised the force");
        assert_eq!((rig.state(), rig.status.unwrap().fault), (DeviceState::Fault, fault));
        assert!(rig.reported(EventKind::Fault) && rig.reported(EventKind::CommandRejected));
        rig.host.clear_fault(rig.now.0, FaultCode(code ^ 0x0010));
        rig.run(100);
        assert_eq!(rig.state(), DeviceState::Fault, "{code:04x}: another name clears nothing");
        rig.wanted_n = None;
        rig.host.clear_fault(rig.now.0, fault);
        rig.run(200);
        assert_eq!(rig.state(), DeviceState::Armed, "{code:04x}");
        assert!((rig.force_n() - expected).abs() < 1e-9, "{code:04x}: clearing moves nothing");
        rig.grip(5.0, 100);
        assert!((rig.force_n() - 5.0).abs() < 1e-9, "{code:04x}: commands are followed again");
    }
}

#[test]
fn r6_an_estop_of_the_host_latches_in_any_session() {
    let mut rig = Rig::gripping(&supported(), config(), 6.0);
    let mut out = [0; grip_link::frame::MAX_WIRE];
    let len = rig.host.estop(&mut out).unwrap();
    rig.mcu.receive(rig.now, &out[..len]);
    rig.grip(9.0, 300);
    assert_eq!((rig.state(), rig.status.unwrap().fault), (DeviceState::Estop, FaultCode::ESTOP));
    assert!((rig.force_n() - 6.0).abs() < 1e-9, "held, not raised, not dropped");
}

const STYLUS_FAULTS: [(SensorFault, FaultCode); 4] = [
    (SensorFault::Dead, FaultCode::SENSOR_DEAD),
    (SensorFault::Infinite, FaultCode::SENSOR_DEAD),
    (SensorFault::Stuck, FaultCode::SENSOR_FROZEN),
    (SensorFault::Saturated, FaultCode::SENSOR_SATURATED),
];

#[test]
fn r7_without_a_usable_slip_sensor_it_holds_and_reports() {
    for (broken, fault) in STYLUS_FAULTS {
        assert_eq!(fault.reaction(), Reaction::Hold);
        let mut rig = Rig::gripping(&without_travel(), config(), 7.5);
        rig.mcu.break_stylus(Some(broken));
        rig.run(50);
        assert_eq!((rig.state(), rig.status.unwrap().fault), (DeviceState::Fault, fault));
        let from = rig.forces.len();
        rig.grip(10.0, 2_000);
        assert!(rig.forces[from..].iter().all(|n| (n - 7.5).abs() < 1e-9), "{broken:?}");
        assert!(!rig.mcu.truth().dropped(), "{broken:?}");
    }
}

#[test]
fn r7_a_stylus_is_no_fault_while_the_travel_is_measured() {
    for (broken, fault) in STYLUS_FAULTS {
        let mut rig = Rig::gripping(&lifted(), config(), 7.5);
        rig.mcu.break_stylus(Some(broken));
        rig.grip(8.0, 500);
        assert_eq!(
            (rig.state(), rig.status.unwrap().fault),
            (DeviceState::Active, FaultCode::NONE)
        );
        assert!((rig.force_n() - 8.0).abs() < 1e-9, "{broken:?}: commands are followed");
        // A travel that repeats itself is at rest; one that is not finite is none.
        rig.mcu.break_sensor(Sensor::Travel, Some(SensorFault::Stuck));
        rig.run(100);
        assert_eq!(rig.state(), DeviceState::Active, "{broken:?}");
        rig.mcu.break_sensor(Sensor::Travel, Some(SensorFault::Dead));
        rig.grip(9.0, 100);
        assert_eq!((rig.state(), rig.status.unwrap().fault), (DeviceState::Fault, fault));
        assert!(rig.force_n() < 8.7, "{broken:?}: held from then on");
    }
}

#[test]
fn r7_a_travel_that_the_host_did_not_ask_for_does_not_count() {
    let mask = Config { channel_mask: 0b11, ..config() };
    let mut rig = Rig::gripping(&lifted(), mask, 7.5);
    rig.mcu.break_stylus(Some(SensorFault::Dead));
    rig.run(50);
    assert_eq!(rig.status.unwrap().fault, FaultCode::SENSOR_DEAD);
}

#[test]
fn r8_a_lost_object_takes_the_torque_off_for_good() {
    let mut rig = Rig::new(&lifted(), config());
    rig.grip(1.0, 1_000);
    assert!(rig.mcu.truth().dropped(), "1 N holds nothing");
    assert_eq!(rig.status.unwrap().fault, FaultCode::OBJECT_LOST);
    let from = rig.forces.len();
    rig.grip(9.0, 3_000);
    assert!(rig.forces[from..].iter().all(|n| *n <= 0.0), "never back by itself");
    rig.wanted_n = None;
    rig.run(3_000);
    assert!(rig.forces[from..].iter().all(|n| *n <= 0.0), "nor when the host is silent");
}

#[test]
fn r8_an_undefined_position_takes_the_torque_off() {
    let mut rig = Rig::gripping(&supported(), config(), 6.0);
    rig.mcu.raise_fault(FaultCode::POSITION_UNDEFINED);
    rig.grip(6.0, 1_000);
    assert!(rig.force_n() <= 0.0 && rig.state() == DeviceState::Fault);
}

/// Whichever task hangs, the watchdog starves; the device comes back passive, in another boot.
#[test]
fn r9_a_hung_task_starves_the_watchdog() {
    for task in [Task::Control, Task::Link, Task::Sampling] {
        let mut rig = Rig::gripping(&supported(), config(), 6.0);
        rig.mcu.hang(task);
        rig.run(90);
        assert_eq!(rig.mcu.boot_id(), 7, "{task:?}: not yet");
        assert!(rig.force_n() <= 6.0, "{task:?}");
        rig.host_runs = false;
        rig.run(30);
        assert_eq!(rig.mcu.boot_id(), 8, "{task:?}: restarted");
        assert!(rig.force_n() <= 0.0, "{task:?}: passive");
    }
}
