//! Player of lines of what a gripper lives through: what the device of this project does with them, in the words of the peers.
//!
//! The language is that of `script`; `new T [passive]` is another gripper, whose ESTOP holds the force or takes the torque off.

use super::gripper::ident;
use super::words::{hex, unhex};
use grip_link::device::{DeviceConfig, DeviceEvent, DeviceLink, Drive, RowError};
use grip_link::frame::MAX_WIRE;
use grip_link::message::{Config, FaultCode, Grip, LogLevel, Reaction};

/// A device that follows a script.
#[derive(Debug)]
pub struct Player {
    /// The device.
    pub device: DeviceLink,
}

impl Default for Player {
    /// In state BOOT; its ESTOP holds.
    fn default() -> Self {
        Self::new(Reaction::Hold)
    }
}

impl Player {
    fn new(estop: Reaction) -> Self {
        let config = DeviceConfig { ident: ident(0xB007), estop };
        Self { device: DeviceLink::new(config).unwrap() }
    }

    /// The answers to a script.
    pub fn play(&mut self, lines: &[String]) -> Vec<String> {
        lines.iter().flat_map(|line| self.obey(line)).collect()
    }

    /// The answers to one line.
    pub fn obey(&mut self, line: &str) -> Vec<String> {
        let words: Vec<&str> = line.split(' ').collect();
        let [command, tick, words @ ..] = &words[..] else { panic!("no command and tick: {line}") };
        let tick = tick.parse().unwrap();
        let device = &mut self.device;
        match *command {
            "new" => {
                let passive = words.first() == Some(&"passive");
                *self = Self::new(if passive { Reaction::Passive } else { Reaction::Hold });
            }
            "ready" => device.ready(tick),
            "rx" => return self.receive(tick, &unhex(words[0])),
            "tx" => return self.transmit(tick, words[0].parse().unwrap()),
            "drive" => return vec![self.drive(tick)],
            "i16" => {
                let row: Vec<i16> = words.iter().map(|word| word.parse().unwrap()).collect();
                return vec![row_words(device.push_i16(tick, &row))];
            }
            "f32" => {
                let bits = |word: &&str| f32::from_bits(u32::from_str_radix(word, 16).unwrap());
                let row: Vec<f32> = words.iter().map(bits).collect();
                return vec![row_words(device.push_f32(tick, &row))];
            }
            "fault" => {
                device.raise_fault(tick, FaultCode(u16::from_str_radix(words[0], 16).unwrap()));
            }
            "estop" => device.estop(tick),
            "travel" => device.report_travel(words[0].parse().unwrap()),
            "force" => device.report_force(words[0].parse().unwrap()),
            "motion" => device.report_motion(tick, words[0] == "1"),
            "alive" => return vec![format!("alive {}", u8::from(device.take_alive()))],
            "log" => return vec![self.log(tick, words)],
            other => panic!("no such command: {other}"),
        }
        Vec::new()
    }

    fn receive(&mut self, tick: u64, bytes: &[u8]) -> Vec<String> {
        let mut input = bytes;
        let events = core::iter::from_fn(|| self.device.receive(tick, &mut input));
        events.map(|event| event_words(&event)).collect()
    }

    fn transmit(&mut self, tick: u64, most: usize) -> Vec<String> {
        let mut out = [0; MAX_WIRE];
        let frames = core::iter::from_fn(|| {
            let len = self.device.poll_transmit(tick, &mut out)?;
            Some(format!("frame {}", hex(&out[..len])))
        });
        frames.take(most).collect()
    }

    fn drive(&mut self, tick: u64) -> String {
        let drive = self.device.drive(tick);
        let kind = match drive {
            Drive::Passive => "passive",
            Drive::Force(_) => "force",
            Drive::Open => "open",
        };
        let (state, fault) = (self.device.state().code(), self.device.fault().0);
        format!("drive {kind} {} state {state} fault {fault:04x}", drive.force_mn())
    }

    fn log(&mut self, tick: u64, words: &[&str]) -> String {
        let level = LogLevel::from_code(words[0].parse().unwrap());
        let text = String::from_utf8(unhex(words[1])).unwrap();
        let mut out = [0; MAX_WIRE];
        let len = self.device.log(tick, level, &text, &mut out).unwrap_or(0);
        format!("log {}", hex(&out[..len]))
    }
}

fn row_words(result: Result<(), RowError>) -> String {
    let word = match result {
        Ok(()) => "taken",
        Err(RowError::NotSampling) => "not sampling",
        Err(RowError::Format { .. }) => "format",
        Err(RowError::Elements { .. }) => "elements",
    };
    format!("row {word}")
}

fn event_words(event: &DeviceEvent) -> String {
    match event {
        DeviceEvent::Linked { session } => format!("linked {session:04x}"),
        DeviceEvent::Configured(config) => format!("configured {}", config_words(config)),
        DeviceEvent::Started => "started".to_owned(),
        DeviceEvent::Stopped => "stopped".to_owned(),
        DeviceEvent::Command(grip) => format!("command {}", grip_words(grip)),
        DeviceEvent::Rejected(grip) => format!("rejected {}", grip_words(grip)),
        DeviceEvent::Heartbeat(h) => {
            format!("heartbeat {} {} {} {}", h.turns, h.longest_us, h.late, h.flags)
        }
        DeviceEvent::Estop => "estop".to_owned(),
        DeviceEvent::Cleared(fault) => format!("cleared {:04x}", fault.0),
    }
}

/// The fields of a GRIP in their order on the wire.
fn grip_words(grip: &Grip) -> String {
    let Grip { cmd_id, mode, flags, ttl_ms, force_mn, slew_mn_s, cause_sample } = grip;
    format!("{cmd_id} {mode} {flags} {ttl_ms} {force_mn} {slew_mn_s} {cause_sample}")
}

/// The fields of a CONFIG in their order on the wire.
fn config_words(c: &Config) -> String {
    format!(
        "{} {} {} {} {} {} {} {} {} {}",
        c.sample_rate_hz,
        c.batch,
        c.format.code(),
        c.ttl_ms,
        c.channel_mask,
        c.force_max_mn,
        c.slew_mn_s,
        c.hold_cap_mn,
        c.loss_after_ms,
        c.loss_action.code()
    )
}
