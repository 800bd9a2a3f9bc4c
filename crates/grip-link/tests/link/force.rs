//! The failsafe rules of the device, one by one and as properties.

use crate::targets::gripper::{CONFIG, hello, ident, idle, press, sent, wire, written};
use grip_link::device::{
    DeviceConfig, DeviceConfigError, DeviceEvent, DeviceLink, Drive, RowError,
};
use grip_link::frame::{Direction, Header, MAX_WIRE};
use grip_link::message::{
    Config, DeviceState, Event, EventKind, FaultCode, ForceClamp, Grip, GripMode, Ident, Kind,
    Limits, LossAction, Reaction, StatusFlags, Versions,
};
use proptest::prelude::{ProptestConfig, any, prop, proptest};
use proptest::{prop_assert, prop_assert_eq};

/// A device and a hand-driven host.
struct Rig {
    device: DeviceLink,
    seq: u16,
    tick: u64,
    cmd_id: u32,
}

impl Rig {
    fn new(config: &Config) -> Self {
        let mut rig = Self { device: idle(1), seq: 0, tick: 1000, cmd_id: 0 };
        rig.hello();
        rig.configure(config);
        rig
    }

    fn send(&mut self, kind: Kind, payload: &[u8]) -> Option<DeviceEvent> {
        let bytes = wire(&Header::new(Direction::ToDevice, kind, self.seq, 5), payload);
        self.seq = self.seq.wrapping_add(1);
        self.device.receive(self.tick, &mut &bytes[..])
    }

    fn hello(&mut self) {
        let payload = hello(Versions::OURS, 0);
        assert_eq!(self.send(Kind::HELLO, &payload), Some(DeviceEvent::Linked { session: 5 }));
    }

    fn configure(&mut self, config: &Config) {
        let event = self.send(Kind::CONFIG, &config.to_bytes());
        assert!(matches!(event, Some(DeviceEvent::Configured(_))), "{event:?}");
    }

    fn grip(&mut self, grip: &Grip) -> Option<DeviceEvent> {
        self.send(Kind::GRIP, &written(|p| grip.write(p)))
    }

    fn press(&mut self, force_mn: i32) -> Option<DeviceEvent> {
        self.cmd_id = self.cmd_id.wrapping_add(1);
        self.grip(&press(self.cmd_id, force_mn))
    }

    /// Advances in steps of 1 ms, keeping the command fresh when `force_mn` is given.
    fn run(&mut self, ms: u32, force_mn: Option<i32>) -> Drive {
        for _ in 0..ms {
            self.tick += 1000;
            if let Some(force_mn) = force_mn {
                self.press(force_mn);
            }
            self.device.drive(self.tick);
        }
        self.device.drive(self.tick)
    }
}

#[test]
fn passive_until_the_first_command() {
    let mut rig = Rig::new(&CONFIG);
    assert_eq!(rig.run(500, None), Drive::Passive);
    assert_eq!(rig.device.state(), DeviceState::Armed, "nothing was gripped, nothing is lost");
}

#[test]
fn force_follows_the_slew() {
    let mut rig = Rig::new(&CONFIG);
    rig.device.drive(rig.tick);
    rig.press(5000);
    assert_eq!(rig.run(1, None), Drive::Force(200), "200 N/s is 0.2 N a millisecond");
    assert_eq!(rig.run(9, None), Drive::Force(2000));
    assert_eq!(rig.run(20, Some(5000)), Drive::Force(5000));
    assert_eq!(
        rig.run(5, Some(0)),
        Drive::Force(4200),
        "the millisecond before the command does not count"
    );
}

#[test]
fn small_time_steps_lose_no_slew() {
    let mut rig = Rig::new(&Config { slew_mn_s: 777, ..CONFIG });
    rig.device.drive(rig.tick);
    for _ in 0..1000 {
        rig.press(9000);
        for _ in 0..1000 {
            rig.tick += 1;
            rig.device.drive(rig.tick);
        }
    }
    assert_eq!(rig.device.drive(rig.tick), Drive::Force(777));
}

#[test]
fn a_late_control_task_does_not_jump() {
    let mut rig = Rig::new(&CONFIG);
    rig.press(10_000);
    rig.device.drive(rig.tick);
    rig.tick += 49_000;
    assert_eq!(rig.device.drive(rig.tick), Drive::Force(2000), "10 ms of slew at most");
}

#[test]
fn out_of_range_is_clamped_and_reported() {
    let mut rig = Rig::new(&CONFIG);
    let grip = Grip { slew_mn_s: 999_999, ttl_ms: 500, ..press(1, 12_000) };
    assert!(matches!(rig.grip(&grip), Some(DeviceEvent::Command(_))));
    let status = rig.device.status(rig.tick);
    assert_eq!(status.target_mn, 10_000);
    assert_eq!(
        status.clamp,
        ForceClamp(ForceClamp::FORCE.0 | ForceClamp::SLEW.0 | ForceClamp::TTL.0)
    );
    rig.tick += 101_000;
    rig.device.drive(rig.tick);
    assert_eq!(rig.device.state(), DeviceState::Hold, "ttl was cut to 100 ms");
}

#[test]
fn negative_force_and_unknown_modes_are_rejected() {
    let mut rig = Rig::new(&CONFIG);
    rig.press(3000);
    rig.run(30, None);
    for (force_mn, mode) in [(-1, 1), (i32::MIN, 1), (1000, 0), (1000, 4), (1000, 255)] {
        rig.cmd_id += 1;
        let event = rig.grip(&Grip { mode, ..press(rig.cmd_id, force_mn) });
        assert!(matches!(event, Some(DeviceEvent::Rejected(_))));
        let status = rig.device.status(rig.tick);
        assert!(status.clamp.has(ForceClamp::REJECTED));
        assert_eq!((status.last_cmd_id, status.target_mn), (1, 3000));
    }
    assert_eq!(rig.device.status(rig.tick).rejected, 5);
    let frames = sent(&mut rig.device, rig.tick);
    let events = frames.iter().filter(|(kind, _)| *kind == Kind::EVENT);
    let rejected = |(_, event): &(Kind, Vec<u8>)| {
        Event::parse(event).is_ok_and(|event| event.kind == EventKind::CommandRejected)
    };
    assert_eq!(events.filter(|event| rejected(event)).count(), 5);
    rig.run(25, None);
    assert_eq!(rig.device.state(), DeviceState::Hold, "rejected commands do not refresh the ttl");
}

#[test]
fn older_and_equal_commands_are_ignored() {
    let mut rig = Rig::new(&CONFIG);
    rig.cmd_id = u32::MAX - 1;
    rig.press(3000);
    rig.press(4000);
    assert_eq!(rig.cmd_id, 0, "numbers wrap");
    for cmd_id in [0, u32::MAX, u32::MAX - 1, 0x8000_0000] {
        assert_eq!(rig.grip(&press(cmd_id, 9000)), None);
    }
    assert_eq!(rig.device.status(rig.tick).target_mn, 4000);
    assert!(rig.grip(&press(7, 5000)).is_some());
}

#[test]
fn commands_need_config_first() {
    let mut rig = Rig { device: idle(1), seq: 0, tick: 1000, cmd_id: 0 };
    assert_eq!(rig.press(1000), None, "no session");
    rig.hello();
    assert!(matches!(rig.press(1000), Some(DeviceEvent::Rejected(_))));
    assert_eq!(rig.run(10, Some(1000)), Drive::Passive);
}

#[test]
fn each_loss_action() {
    for (loss_action, expected) in [
        (LossAction::Hold, Drive::Force(6000)),
        (LossAction::Open, Drive::Open),
        (LossAction::Passive, Drive::Passive),
    ] {
        let mut rig = Rig::new(&Config { loss_action, loss_after_ms: 300, ..CONFIG });
        rig.run(100, Some(6000));
        assert_eq!(rig.run(50 + 299, None), Drive::Force(6000));
        assert_eq!(rig.run(3, None), expected);
        assert_eq!(rig.device.state(), DeviceState::LossAction);
        assert!(matches!(rig.press(1000), Some(DeviceEvent::Rejected(_))), "must be armed again");
        rig.configure(&CONFIG);
        assert!(matches!(rig.press(1000), Some(DeviceEvent::Command(_))));
    }
}

#[test]
fn a_new_host_takes_over_without_dropping() {
    let mut rig = Rig::new(&CONFIG);
    rig.run(100, Some(6000));
    rig.hello();
    assert_eq!(rig.device.state(), DeviceState::Linked);
    assert_eq!(rig.run(100, None), Drive::Force(6000));
    rig.configure(&CONFIG);
    rig.send(Kind::STOP, &[]);
    assert_eq!(rig.run(100, None), Drive::Force(6000));
    rig.cmd_id = 0;
    assert_eq!(rig.run(100, Some(7000)), Drive::Force(7000));
}

#[test]
fn a_host_that_only_states_hello_leads_to_the_loss_action() {
    let mut rig = Rig::new(&Config { loss_action: LossAction::Passive, ..CONFIG });
    rig.run(100, Some(6000));
    for _ in 0..11 {
        rig.hello();
        rig.run(100, None);
    }
    assert_eq!((rig.device.state(), rig.run(1, None)), (DeviceState::Linked, Drive::Passive));
}

#[test]
fn explicit_open_and_passive() {
    let mut rig = Rig::new(&CONFIG);
    rig.run(50, Some(5000));
    rig.cmd_id += 1;
    rig.grip(&Grip { mode: GripMode::Open.code(), ..press(rig.cmd_id, 1000) });
    assert_eq!(rig.run(1, None), Drive::Open);
    assert_eq!(
        rig.run(1200, None),
        Drive::Open,
        "nothing is held, so the loss action changes nothing"
    );
    rig.configure(&CONFIG);
    rig.cmd_id += 1;
    rig.grip(&Grip { mode: GripMode::Passive.code(), ..press(rig.cmd_id, 1000) });
    assert_eq!(rig.run(1, None), Drive::Passive);
    rig.press(1000);
    assert_eq!(rig.run(1, None), Drive::Force(200), "rises from zero");
}

#[test]
fn every_fault_code_latches() {
    for code in (1..=0x0300).chain([0x7FFF, 0xFFFF]).filter(|code| *code != 1) {
        let fault = FaultCode(code);
        let mut rig = Rig::new(&CONFIG);
        rig.run(60, Some(9000));
        rig.device.raise_fault(rig.tick, fault);
        assert_eq!((rig.device.state(), rig.device.fault()), (DeviceState::Fault, fault));
        let minor = (0x0101..=0x0104).contains(&code);
        let expected = if minor { Drive::Force(8000) } else { Drive::Passive };
        assert_eq!(rig.run(20, Some(9000)), expected, "{code:04x}");
        rig.hello();
        assert_eq!(rig.device.state(), DeviceState::Fault);
        assert_eq!(rig.send(Kind::CLEAR_FAULT, &[0, 0]), None);
        assert_eq!(
            rig.send(Kind::CLEAR_FAULT, &code.to_le_bytes()),
            Some(DeviceEvent::Cleared(fault))
        );
        assert_eq!(rig.run(20, None), expected, "clearing moves nothing");
        assert_eq!(rig.device.state(), DeviceState::Linked);
    }
}

#[test]
fn the_worse_fault_stays_and_estop_stands_beside_it() {
    let mut rig = Rig::new(&CONFIG);
    rig.run(60, Some(5000));
    rig.device.raise_fault(rig.tick, FaultCode::SENSOR_DEAD);
    rig.device.raise_fault(rig.tick, FaultCode::OVER_CURRENT);
    rig.device.raise_fault(rig.tick, FaultCode::SENSOR_FROZEN);
    assert_eq!(rig.device.fault(), FaultCode::OVER_CURRENT);
    rig.device.estop(rig.tick);
    assert_eq!((rig.device.state(), rig.device.fault()), (DeviceState::Estop, FaultCode::ESTOP));
    rig.send(Kind::CLEAR_FAULT, &FaultCode::ESTOP.0.to_le_bytes());
    assert_eq!(
        (rig.device.state(), rig.device.fault()),
        (DeviceState::Fault, FaultCode::OVER_CURRENT)
    );
    assert_eq!(rig.run(1, None), Drive::Passive);
}

#[test]
fn travel_end_stops_the_rise() {
    let mut rig = Rig::new(&CONFIG);
    rig.run(10, Some(1000));
    rig.device.report_travel(50_001);
    assert_eq!(rig.run(20, Some(9000)), Drive::Force(1000));
    assert!(rig.device.status(rig.tick).clamp.has(ForceClamp::TRAVEL));
    assert_eq!(rig.run(20, Some(500)), Drive::Force(500), "lower is possible");
    rig.device.report_travel(20_000);
    assert_eq!(rig.run(50, Some(9000)), Drive::Force(9000));
}

#[test]
fn motion_is_reported_at_once_and_only_where_the_firmware_reports_it() {
    let mut rig = Rig::new(&CONFIG);
    rig.run(10, Some(1000));
    let motion = StatusFlags::MOTION.with(StatusFlags::MOVING, true);
    let reported = |rig: &Rig| rig.device.status(rig.tick).flags.0 & motion.0;
    assert_eq!(reported(&rig), 0, "nothing is known");
    rig.device.report_motion(rig.tick, false);
    assert_eq!(reported(&rig), StatusFlags::MOTION.0);
    let mut out = [0; MAX_WIRE];
    while rig.device.poll_transmit(rig.tick, &mut out).is_some() {}
    rig.device.report_motion(rig.tick, false);
    assert_eq!(rig.device.poll_transmit(rig.tick, &mut out), None, "nothing new");
    rig.device.report_motion(rig.tick, true);
    assert_eq!(reported(&rig), motion.0);
    assert!(rig.device.poll_transmit(rig.tick, &mut out).is_some(), "a STATUS is due");
}

#[test]
fn watchdog_needs_every_task() {
    let mut rig = Rig::new(&CONFIG);
    rig.device.drive(rig.tick);
    assert!(rig.device.take_alive());
    assert!(!rig.device.take_alive());
    rig.device.drive(rig.tick);
    assert!(!rig.device.take_alive(), "link did not run");
    rig.send(Kind::START, &[]);
    assert!(!rig.device.take_alive(), "no samples");
    rig.device.push_i16(rig.tick, &[1, 2]).unwrap();
    assert!(rig.device.take_alive());
}

#[test]
fn rows_must_fit_the_config() {
    let mut rig = Rig::new(&CONFIG);
    assert_eq!(rig.device.push_i16(rig.tick, &[1, 2]), Err(RowError::NotSampling));
    rig.send(Kind::START, &[]);
    assert_eq!(rig.device.push_i16(rig.tick, &[1]), Err(RowError::Elements { need: 2, got: 1 }));
    let wanted = grip_link::message::SampleFormat::I16;
    assert_eq!(rig.device.push_f32(rig.tick, &[1.0, 2.0]), Err(RowError::Format { wanted }));
}

#[test]
fn rows_of_a_burst_do_not_wait_and_lost_ones_leave_a_gap() {
    let mut rig = Rig::new(&Config { batch: 5, ..CONFIG });
    rig.send(Kind::START, &[]);
    let mut frame = [0; MAX_WIRE];
    let mut frames = |device: &mut DeviceLink, tick| {
        core::iter::from_fn(|| device.poll_transmit(tick, &mut frame)).count()
    };
    frames(&mut rig.device, rig.tick);
    rig.device.flush_rows();
    assert_eq!(frames(&mut rig.device, rig.tick), 0, "there is nothing to send");
    rig.device.push_i16(rig.tick, &[1, 2]).unwrap();
    assert_eq!(frames(&mut rig.device, rig.tick), 0, "the batch has room for four more");
    rig.device.flush_rows();
    assert_eq!(frames(&mut rig.device, rig.tick), 1);
    rig.device.push_i16(rig.tick, &[1, 2]).unwrap();
    rig.device.skip_rows(3);
    rig.device.push_i16(rig.tick, &[1, 2]).unwrap();
    rig.device.flush_rows();
    assert_eq!(frames(&mut rig.device, rig.tick), 2, "numbers do not go on within a batch");
    assert_eq!(rig.device.dropped_rows(), 3);
}

fn with(change: &dyn Fn(&mut Ident)) -> Result<(), DeviceConfigError> {
    let mut bad = ident(1);
    change(&mut bad);
    DeviceLink::new(DeviceConfig { ident: bad, estop: Reaction::Hold }).map(drop)
}

#[test]
fn impossible_grippers_are_refused() {
    assert!(with(&|_| {}).is_ok());
    assert!(matches!(
        with(&|i| i.tick_hz = 999),
        Err(DeviceConfigError::TickRate { tick_hz: 999 })
    ));
    assert!(matches!(
        with(&|i| i.channel_count = 0),
        Err(DeviceConfigError::NoStylus { channels: 0 })
    ));
    assert!(matches!(
        with(&|i| i.limits = Limits { hold_cap_mn: 20_001, ..i.limits }),
        Err(DeviceConfigError::Limits { .. })
    ));
    assert!(matches!(with(&|i| i.limits.slew_max_mn_s = 0), Err(DeviceConfigError::Limits { .. })));
    assert!(matches!(
        with(&|i| i.limits = Limits { force_max_mn: -1, hold_cap_mn: -1, ..i.limits }),
        Err(DeviceConfigError::Limits { .. })
    ));
}

#[test]
fn a_board_without_an_actuator_is_possible_and_says_so() {
    let sensor = |i: &mut Ident| i.limits = Limits { force_max_mn: 0, hold_cap_mn: 0, ..i.limits };
    assert!(with(&sensor).is_ok());
    let mut board = ident(1);
    assert!(board.limits.has_actuator());
    sensor(&mut board);
    assert!(!board.limits.has_actuator());
    // A hold cap needs a force to stay under.
    assert!(with(&|i| i.limits.force_max_mn = 0).is_err());
}

#[test]
fn impossible_channels_are_refused() {
    for count in [0, 65, 200] {
        let result = with(&|i| i.channels[1].count = count);
        assert!(matches!(result, Err(DeviceConfigError::Channel { index: 1, .. })), "{count}");
    }
    for scale in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        let result = with(&|i| i.channels[1].scale = scale);
        assert!(matches!(result, Err(DeviceConfigError::Channel { index: 1, .. })), "{scale}");
    }
    let wide = |i: &mut Ident| i.channels[..2].iter_mut().for_each(|channel| channel.count = 64);
    assert!(matches!(with(&wide), Err(DeviceConfigError::Row { bytes: 512.. })));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    /// R1 and R4: whatever is commanded, force stays within 0..=F_max, keeps the slew, and rises only while fresh.
    #[test]
    fn force_keeps_its_bounds(
        commands in prop::collection::vec((any::<i32>(), any::<u8>(), any::<u16>(), any::<u32>(), 0_u64..80_000), 1..60),
        force_max_mn in 0..20_000_i32, slew_mn_s in 1..400_000_u32, hold_cap_mn in 0..20_000_i32,
    ) {
        let limits = Config { force_max_mn, slew_mn_s, hold_cap_mn, ..CONFIG };
        let mut rig = Rig::new(&limits);
        let mut before = rig.device.drive(rig.tick).force_mn();
        let mut fresh_until = 0;
        for (i, (force_mn, mode, ttl_ms, slew, wait)) in commands.into_iter().enumerate() {
            let mode = if mode < 200 { 1 } else { mode };
            let cmd_id = u32::try_from(i).unwrap() + 1;
            let event = rig.grip(&Grip { cmd_id, mode, flags: 0, ttl_ms, force_mn, slew_mn_s: slew, cause_sample: 0 });
            if matches!(event, Some(DeviceEvent::Command(_))) {
                fresh_until = rig.tick + 100_000;
            }
            let end = rig.tick + wait;
            while rig.tick < end {
                let step = 700.min(end - rig.tick);
                rig.tick += step;
                let drive = rig.device.drive(rig.tick);
                let now = drive.force_mn();
                prop_assert!((0..=force_max_mn).contains(&now));
                let most = i32::try_from(step * u64::from(slew_mn_s) / 1_000_000).unwrap() + 1;
                prop_assert!(now - before <= most, "rise {before} -> {now} in {step} us");
                prop_assert!(now <= before || rig.tick <= fresh_until);
                if matches!(drive, Drive::Force(_)) {
                    prop_assert!(before - now <= most);
                }
                before = now;
            }
        }
    }

    #[test]
    fn any_bytes_leave_the_device_sane(bytes in prop::collection::vec(any::<u8>(), 0..600)) {
        let mut rig = Rig::new(&CONFIG);
        rig.run(40, Some(4000));
        let mut input = &bytes[..];
        while rig.device.receive(rig.tick, &mut input).is_some() {}
        prop_assert_eq!(rig.device.drive(rig.tick), Drive::Force(4000));
    }
}
