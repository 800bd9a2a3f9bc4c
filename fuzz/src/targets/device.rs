//! A life of a gripper: the force keeps its limits, rises only while a command is fresh, and stays off after a major fault.
//!
//! Input: see `script`. The memory is bounded because the device allocates nothing: `no_std` without `alloc`.

use super::gripper::{FORCE_MAX_MN, device};
use super::script::{Action, Step, steps};
use grip_link::decoder::{Decoder, Role, Verdict};
use grip_link::device::{DeviceEvent, DeviceLink, Drive};
use grip_link::frame::{Direction, MAX_WIRE};
use grip_link::message::{Config, Grip, GripMode, Reaction};

/// Frames that a device may have ready at one time: 8 replies, 8 events, 5 batches, STATUS twice, STATS.
const MOST_FRAMES: usize = 24;
/// Longest time in which the force moves at once (us).
const LONGEST_STEP_US: u64 = 10_000;

/// A command that was accepted and not yet taken back by anything.
#[derive(Debug, Clone, Copy)]
struct Fresh {
    until: u64,
    most_mn: i32,
    slew_mn_s: u32,
}

struct Watch {
    link: DeviceLink,
    fresh: Option<Fresh>,
    commanded: bool,
    force_mn: i32,
    tick: u64,
    decoder: Decoder,
}

/// The target.
pub fn check(data: &[u8]) {
    let mut watch = Watch {
        link: device(0xB007),
        fresh: None,
        commanded: false,
        force_mn: 0,
        tick: 0,
        decoder: Decoder::new(Role::Tap),
    };
    for step in steps(data) {
        // What time alone allows comes first, under the command before.
        watch.look(step.tick);
        watch.step(&step);
        watch.look(step.tick);
    }
}

impl Watch {
    fn step(&mut self, step: &Step) {
        let tick = step.tick;
        let link = &mut self.link;
        let mut out = [0; MAX_WIRE];
        match &step.action {
            Action::Ready => link.ready(tick),
            Action::Receive(bytes) => self.receive(tick, bytes),
            Action::Transmit(most) => self.transmit(tick, usize::from(*most)),
            Action::Drive => {
                let _drive = link.drive(tick);
            }
            Action::RowI16(row) => {
                let _taken = link.push_i16(tick, row);
            }
            Action::RowF32(row) => {
                let _taken = link.push_f32(tick, row);
            }
            Action::Fault(fault) => {
                link.raise_fault(tick, *fault);
                if fault.0 > 1 {
                    self.fresh = None;
                }
            }
            Action::Estop => {
                link.estop(tick);
                self.fresh = None;
            }
            Action::Travel(position_um) => link.report_travel(*position_um),
            Action::Force(force_mn) => link.report_force(*force_mn),
            Action::Alive => {
                let first = link.take_alive();
                assert!(!(first && link.take_alive()), "fed twice for one turn");
            }
            Action::Log(level, text) => {
                let level = grip_link::message::LogLevel::from_code(*level);
                if let Some(len) = link.log(tick, level, text, &mut out) {
                    self.take(&out[..len]);
                }
            }
        }
    }

    fn receive(&mut self, tick: u64, bytes: &[u8]) {
        let mut input = bytes;
        let mut events = 0;
        loop {
            let config = self.link.in_force().copied();
            let Some(event) = self.link.receive(tick, &mut input) else { break };
            events += 1;
            assert!(events <= bytes.len(), "more events than bytes");
            match event {
                DeviceEvent::Command(grip) => {
                    self.commanded = true;
                    self.fresh = config.and_then(|config| fresh(tick, &grip, &config));
                }
                DeviceEvent::Linked { .. }
                | DeviceEvent::Configured(_)
                | DeviceEvent::Cleared(_)
                | DeviceEvent::Estop => self.fresh = None,
                DeviceEvent::Rejected(_)
                | DeviceEvent::Started
                | DeviceEvent::Stopped
                | DeviceEvent::Heartbeat(_) => {}
            }
        }
        assert!(input.is_empty());
    }

    fn transmit(&mut self, tick: u64, most: usize) {
        let mut out = [0; MAX_WIRE];
        for _ in 0..most {
            let Some(len) = self.link.poll_transmit(tick, &mut out) else { return };
            self.take(&out[..len]);
        }
        let mut copy = self.link.clone();
        let frames = core::iter::from_fn(|| copy.poll_transmit(tick, &mut out)).take(100).count();
        assert!(frames <= MOST_FRAMES, "{frames} frames at one time");
    }

    /// Every frame sent is a good one.
    fn take(&mut self, wire: &[u8]) {
        assert!(wire.len() >= 3 && wire[0] == 0 && wire[wire.len() - 1] == 0);
        let mut input = wire;
        let Some(Verdict::Frame(frame)) = self.decoder.next(&mut input) else {
            panic!("no good frame: {wire:?}")
        };
        assert_eq!(frame.header.direction, Direction::ToHost);
        assert!(frame.header.kind.is_to_host() && input.is_empty());
    }

    /// The force after each step.
    fn look(&mut self, tick: u64) {
        let drive = self.link.drive(tick);
        let (before, now) = (self.force_mn, drive.force_mn());
        assert!((0..=FORCE_MAX_MN).contains(&now), "{now} mN");
        assert!(self.commanded || drive == Drive::Passive, "moved without any command");
        let fault = self.link.fault();
        if fault.is_fault() && fault.reaction() == Reaction::Passive {
            assert_eq!(drive, Drive::Passive, "major fault {fault:?}");
        }
        if now > before {
            let fresh = self.fresh.unwrap_or_else(|| panic!("{before} -> {now} mN unasked"));
            assert!(tick <= fresh.until, "rises after the command ran out");
            assert!(now <= fresh.most_mn, "{now} mN of {fresh:?}");
            let passed_us = (tick - self.tick).min(LONGEST_STEP_US);
            let most = passed_us * u64::from(fresh.slew_mn_s) / 1_000_000 + 1;
            assert!(u64::from(now.abs_diff(before)) <= most, "{before} -> {now} in {passed_us} us");
        }
        (self.force_mn, self.tick) = (now, tick);
    }
}

/// What an accepted command allows; `None` when it asks for no force.
fn fresh(tick: u64, grip: &Grip, config: &Config) -> Option<Fresh> {
    assert!(grip.force_mn >= 0, "a negative force was accepted");
    let mode = GripMode::from_code(grip.mode).expect("an unknown mode was accepted");
    let ttl_ms = match grip.ttl_ms {
        0 => config.ttl_ms,
        ttl_ms => ttl_ms.clamp(20, 100),
    };
    let slew_mn_s = match grip.slew_mn_s {
        0 => config.slew_mn_s,
        slew_mn_s => slew_mn_s.min(config.slew_mn_s),
    };
    let most_mn = grip.force_mn.min(config.force_max_mn);
    let until = tick + 1000 * u64::from(ttl_ms);
    (mode == GripMode::Force).then_some(Fresh { until, most_mn, slew_mn_s })
}
