//! The failsafe rules R1 to R9 against the virtual microcontroller, in simulated time: what its sensors, its object, its tasks and its
//! restart add to the device of grip-link, whose own tests hold the rest.
//!
//! | rule | here | elsewhere |
//! |---|---|---|
//! | R1 never raise force without a fresh command | `r1_*` | grip-link `force::force_keeps_its_bounds`, `force::older_and_equal_commands_are_ignored`, `noise::stale_sessions_are_dropped_on_both_sides`, `degraded::degraded_host_keeps_the_force_it_sent_before`; fuzz targets `device`, `host`; benches `daemon_faults` (SIGSTOP, noise) |
//! | R2 link loss: hold, at most the hold cap; open only if configured | `r2_*` | grip-link `force::each_loss_action`; benches `daemon_faults` (kill -9) |
//! | R3 ttl 20..=100 ms, then the loss action | `r3_*` | grip-link `force::each_loss_action`, `timing::numbers_of_the_device` |
//! | R4 limits live in the MCU; clamp and report; negative = reject | | grip-link `force::force_keeps_its_bounds`, `force::out_of_range_is_clamped_and_reported`, `force::negative_force_and_unknown_modes_are_rejected`, `session::forces_in_newtons_become_millinewtons` (NaN), `force::travel_end_stops_the_rise` |
//! | R5 passive at start; release is never implicit | `r5_*` | grip-link `force::passive_until_the_first_command`, `force::a_new_host_takes_over_without_dropping`; benches `daemon_faults` (reboot under the daemon) |
//! | R6 faults latch; an unknown fault is major | | grip-link `force::every_fault_code_latches`, `session::estop_is_latched_until_it_is_cleared` |
//! | R7 no usable slip sensor left (stylus dead, frozen or saturated, and no other): hold and report | `r7_*` | slip-core `pipeline::faults` (the reflex stops); grip-eval `grasp::a_stylus_that_dies_during_the_hold_never_opens_the_fingers` |
//! | R8 object lost: torque off, never back by itself | `r8_*` | |
//! | R9 watchdog fed only if control, link and sampling ran | `r9_*` | grip-link `force::watchdog_needs_every_task` |
#![expect(clippy::unwrap_used, reason = "test code")]

use grip_link::frame::MAX_WIRE;
use grip_link::host::{CloseReason, GripCommand, HostConfig, HostEvent, HostLink};
use grip_link::message::{
    Config, DeviceState, FaultCode, ForceClamp, LossAction, Reaction, SampleFormat, Status,
};
use grip_sim::mcu::{Sensor, SensorFault, Task};
use grip_sim::{Scene, VirtualMcu};
use slip_core::units::Micros;

const SESSION: u16 = 0xBEEF;

/// 1 kHz, 10 N at 200 N/s, 8 N held, 50 ms of life, hold after 1 s.
fn config() -> Config {
    Config {
        sample_rate_hz: 1_000,
        batch: 2,
        format: SampleFormat::F32,
        ttl_ms: 50,
        channel_mask: u32::MAX,
        force_max_mn: 10_000,
        slew_mn_s: 200_000,
        hold_cap_mn: 8_000,
        loss_after_ms: 1_000,
        loss_action: LossAction::Hold,
    }
}

/// A light object that stays on its support for a minute: whatever the fingers do, nothing falls.
fn supported() -> Scene {
    scene("mass_kg = 0.02\nlift_at_s = 60.0\n")
}

/// An object that is lifted soon and needs 6.5 N.
fn lifted() -> Scene {
    scene("mass_kg = 0.4\nlift_at_s = 0.2\n")
}

/// The same without a travel sensor: the stylus is all that shows a slip.
fn without_travel() -> Scene {
    scene("mass_kg = 0.4\nlift_at_s = 0.2\n[channels]\ntravel = false\n")
}

fn scene(object: &str) -> Scene {
    let text = format!(
        "name = \"t\"\nfriction = 0.3\nroughness_ra_um = 1.6\nsample_rate_hz = 1000\n{object}"
    );
    Scene::from_toml(&text).unwrap()
}

/// A host, a virtual gripper and a line that a test may disturb, a millisecond a turn.
struct Rig {
    mcu: VirtualMcu,
    host: HostLink,
    now: Micros,
    /// The force that the host's controller asks for every millisecond.
    wanted_n: Option<f32>,
    host_runs: bool,
    status: Option<Status>,
    closed: Option<CloseReason>,
    rebooted: bool,
    /// Force asked of the drive after each turn (N).
    forces: Vec<f64>,
}

impl Rig {
    fn new(scene: &Scene, config: Config) -> Self {
        let mut host = HostLink::new(HostConfig::new(config)).unwrap();
        host.open(0, SESSION).unwrap();
        Self {
            mcu: VirtualMcu::new(scene, 7).unwrap(),
            host,
            now: Micros(0),
            wanted_n: None,
            host_runs: true,
            status: None,
            closed: None,
            rebooted: false,
            forces: Vec::new(),
        }
    }

    /// A host that has been gripping with `force_n` for 300 ms.
    fn gripping(scene: &Scene, config: Config, force_n: f32) -> Self {
        let mut rig = Self::new(scene, config);
        rig.grip(force_n, 300);
        assert_eq!(rig.mcu.link().state(), DeviceState::Active);
        assert!((rig.force_n() - f64::from(force_n)).abs() < 1e-3, "{}", rig.force_n());
        rig
    }

    fn grip(&mut self, force_n: f32, ms: u32) {
        self.wanted_n = Some(force_n);
        self.run(ms);
    }

    fn run(&mut self, ms: u32) {
        self.run_through(ms, |_, _| {});
    }

    /// Runs; `disturb(to_device, to_host)` may change what is on the line in each millisecond.
    fn run_through(&mut self, ms: u32, mut disturb: impl FnMut(&mut Vec<u8>, &mut Vec<u8>)) {
        for _ in 0..ms {
            self.now = self.now.plus(Micros(1000));
            let mut to_device = self.host_writes();
            let mut to_host = Vec::new();
            self.mcu.advance(self.now);
            self.mcu.transmit(self.now, &mut to_host);
            disturb(&mut to_device, &mut to_host);
            self.mcu.receive(self.now, &to_device);
            if self.host_runs {
                self.host_reads(&to_host);
            }
            self.forces.push(self.force_n());
        }
    }

    fn host_writes(&mut self) -> Vec<u8> {
        let (mut wire, mut out) = (Vec::new(), [0; MAX_WIRE]);
        if !self.host_runs {
            return wire;
        }
        if let Some(command) = self.wanted_n.and_then(GripCommand::newtons)
            && let Some(len) = self.host.grip(self.now.0, &command, &mut out)
        {
            wire.extend_from_slice(&out[..len]);
        }
        while let Some(len) = self.host.poll_transmit(self.now.0, &mut out) {
            wire.extend_from_slice(&out[..len]);
        }
        wire
    }

    fn host_reads(&mut self, mut bytes: &[u8]) {
        while let Some(event) = self.host.receive(self.now.0, &mut bytes) {
            match event {
                HostEvent::Status(status) => self.status = Some(status),
                HostEvent::Closed(reason) => self.closed = Some(reason),
                HostEvent::Rebooted { .. } => self.rebooted = true,
                _ => {}
            }
        }
    }

    /// Force asked of the drive (N).
    fn force_n(&self) -> f64 {
        self.mcu.commanded_n()
    }

    fn state(&self) -> DeviceState {
        self.mcu.link().state()
    }
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

/// Unplugged: no byte either way.
#[test]
fn r2_link_loss_holds_at_most_the_hold_cap() {
    let mut rig = Rig::gripping(&lifted(), config(), 9.5);
    rig.run(200);
    assert!(rig.mcu.truth().lifted());
    rig.run_through(60, |to_device, to_host| {
        to_device.clear();
        to_host.clear();
    });
    let from = rig.forces.len();
    rig.host_runs = false;
    rig.run(20_000);
    assert!((rig.force_n() - 8.0).abs() < 1e-9, "the hold cap: {} N", rig.force_n());
    assert!(rig.forces[from..].windows(2).all(|pair| pair[1] <= pair[0]));
    assert!(!rig.mcu.truth().dropped(), "{:?}", rig.mcu.truth());
    let status = rig.mcu.link().status(rig.now.0);
    assert!(status.clamp.has(ForceClamp::HOLD_CAP), "and told: {status:?}");
}

/// Each life of a command against each silence: followed up to the end of its life, held from then on.
#[test]
fn r3_delay_sweep() {
    for ttl_ms in [20_u16, 35, 50, 100] {
        for silence_ms in (5..=150).step_by(5) {
            let mut rig = Rig::gripping(&supported(), Config { ttl_ms, ..config() }, 5.0);
            rig.host_runs = false;
            rig.run(silence_ms);
            let fresh = silence_ms <= u32::from(ttl_ms);
            let expected = if fresh { DeviceState::Active } else { DeviceState::Hold };
            assert_eq!(rig.state(), expected, "ttl {ttl_ms} ms, silent for {silence_ms} ms");
            rig.host_runs = true;
            rig.grip(6.0, 30);
            assert_eq!(rig.state(), DeviceState::Active, "the next command is followed");
            assert!((rig.force_n() - 6.0).abs() < 1e-9);
        }
    }
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
