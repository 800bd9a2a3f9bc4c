//! Script lines in, what this crate's decoder and device do with them out, in the words of the Python peer.

use crate::script::hex;
use grip_link::crc::crc32c;
use grip_link::decoder::{Decoder, Fault, Role, Verdict};
use grip_link::device::{DeviceConfig, DeviceEvent, DeviceLink, Drive, RowError};
use grip_link::frame::MAX_WIRE;
use grip_link::message::{
    Channel, ChannelKind, DeviceState, FaultCode, Firmware, Grip, Ident, Limits, LogLevel,
    Reaction, ResetReason, Versions,
};

pub(crate) fn unhex(text: &str) -> Vec<u8> {
    (0..text.len()).step_by(2).map(|i| u8::from_str_radix(&text[i..i + 2], 16).unwrap()).collect()
}

const fn name(fault: Fault) -> &'static str {
    match fault {
        Fault::TooLong => "too_long",
        Fault::Cobs => "cobs",
        Fault::Length => "length",
        Fault::Crc => "crc",
        Fault::Echo => "echo",
        Fault::Version(_) => "version",
        Fault::Stale(_) => "stale",
        Fault::Duplicate(_) => "duplicate",
        Fault::UnknownKind(_) => "unknown",
    }
}

/// The answer to `ROLE SESSION[:SEQ]|- HEX`.
pub(crate) fn decode(line: &str) -> String {
    let [role, session, text] = line.split(' ').collect::<Vec<_>>().try_into().unwrap();
    let mut decoder = Decoder::new(if role == "device" { Role::Device } else { Role::Host });
    if session != "-" {
        let (session, seq) = session.split_once(':').map_or((session, None), |(s, q)| (s, Some(q)));
        let last = seq.map(|seq| seq.parse().unwrap());
        decoder.open_session(u16::from_str_radix(session, 16).unwrap(), last);
    }
    let bytes = unhex(text);
    let mut input = &bytes[..];
    let mut words = Vec::new();
    while let Some(verdict) = decoder.next(&mut input) {
        words.push(match verdict {
            Verdict::Frame(frame) => {
                format!("ok:{:02x}:{:08x}", frame.header.kind.0, crc32c(frame.payload))
            }
            Verdict::Bad(fault) => name(fault).to_owned(),
        });
    }
    if words.is_empty() {
        words.push("-".to_owned());
    }
    let counters = decoder.counters();
    format!("{} gap={} garbage={}", words.join(","), counters.gap, counters.garbage_bytes)
}

/// A device that follows a script.
pub(crate) struct Player {
    device: DeviceLink,
    said: Vec<String>,
}

impl Player {
    pub(crate) fn new(estop: Reaction) -> Self {
        let mut ident = Ident {
            versions: Versions::OURS,
            max_rx: 480,
            caps: 0,
            uid: *b"grip-link-test-1",
            boot_id: 0xB007,
            tick_hz: 1_000_000,
            limits: Limits {
                rate_max_hz: 20_000,
                force_max_mn: 20_000,
                slew_max_mn_s: 400_000,
                hold_cap_mn: 15_000,
                travel_min_um: 0,
                travel_max_um: 50_000,
            },
            firmware: Firmware { major: 1, minor: 2, patch: 3 },
            reset: ResetReason::PowerOn,
            state: DeviceState::Boot,
            fault: FaultCode::NONE,
            channels: [Ident::NO_CHANNEL; 16],
            channel_count: 3,
        };
        ident.channels[0] = Channel::single(ChannelKind::Stylus, 1e-8);
        ident.channels[1] = Channel::single(ChannelKind::NormalForce, 1e-3);
        ident.channels[2] =
            Channel { count: 4, ..Channel::single(ChannelKind::PressureArray, 10.0) };
        let device = DeviceLink::new(DeviceConfig { ident, estop }).unwrap();
        Self { device, said: Vec::new() }
    }

    pub(crate) fn play(mut self, lines: &[String]) -> Vec<String> {
        for line in lines {
            let words: Vec<&str> = line.split(' ').collect();
            self.obey(words[0], words[1].parse().unwrap(), &words[2..]);
        }
        self.said
    }

    fn obey(&mut self, command: &str, tick: u64, words: &[&str]) {
        let device = &mut self.device;
        match command {
            "new" => {
                let passive = words.first() == Some(&"passive");
                let estop = if passive { Reaction::Passive } else { Reaction::Hold };
                *device = Self::new(estop).device;
            }
            "ready" => device.ready(tick),
            "rx" => self.receive(tick, &unhex(words[0])),
            "tx" => self.transmit(tick, words[0].parse().unwrap()),
            "drive" => self.drive(tick),
            "i16" => {
                let row: Vec<i16> = words.iter().map(|word| word.parse().unwrap()).collect();
                let result = device.push_i16(tick, &row);
                self.said.push(row_words(result));
            }
            "f32" => {
                let bits = |word: &&str| f32::from_bits(u32::from_str_radix(word, 16).unwrap());
                let row: Vec<f32> = words.iter().map(bits).collect();
                let result = device.push_f32(tick, &row);
                self.said.push(row_words(result));
            }
            "fault" => {
                device.raise_fault(tick, FaultCode(u16::from_str_radix(words[0], 16).unwrap()));
            }
            "estop" => device.estop(tick),
            "travel" => device.report_travel(words[0].parse().unwrap()),
            "force" => device.report_force(words[0].parse().unwrap()),
            "motion" => device.report_motion(tick, words[0] == "1"),
            "alive" => self.said.push(format!("alive {}", u8::from(device.take_alive()))),
            "log" => self.log(tick, words),
            other => panic!("no such command: {other}"),
        }
    }

    fn receive(&mut self, tick: u64, bytes: &[u8]) {
        let mut input = bytes;
        while let Some(event) = self.device.receive(tick, &mut input) {
            self.said.push(event_words(&event));
        }
    }

    fn transmit(&mut self, tick: u64, most: usize) {
        let mut out = [0; MAX_WIRE];
        for _ in 0..most {
            let Some(len) = self.device.poll_transmit(tick, &mut out) else { break };
            self.said.push(format!("frame {}", hex(&out[..len])));
        }
    }

    fn drive(&mut self, tick: u64) {
        let drive = self.device.drive(tick);
        let kind = match drive {
            Drive::Passive => "passive",
            Drive::Force(_) => "force",
            Drive::Open => "open",
        };
        let (state, fault) = (self.device.state().code(), self.device.fault().0);
        let force = drive.force_mn();
        self.said.push(format!("drive {kind} {force} state {state} fault {fault:04x}"));
    }

    fn log(&mut self, tick: u64, words: &[&str]) {
        let level = LogLevel::from_code(words[0].parse().unwrap());
        let text = String::from_utf8(unhex(words[1])).unwrap();
        let mut out = [0; MAX_WIRE];
        let len = self.device.log(tick, level, &text, &mut out).unwrap_or(0);
        self.said.push(format!("log {}", hex(&out[..len])));
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
        DeviceEvent::Configured(c) => format!(
            "configured {} {} {} {} {} {} {} {} {} {}",
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
        ),
        DeviceEvent::Started => "started".to_owned(),
        DeviceEvent::Stopped => "stopped".to_owned(),
        DeviceEvent::Command(grip) => grip_words("command", grip),
        DeviceEvent::Rejected(grip) => grip_words("rejected", grip),
        DeviceEvent::Heartbeat(h) => {
            format!("heartbeat {} {} {} {}", h.turns, h.longest_us, h.late, h.flags)
        }
        DeviceEvent::Estop => "estop".to_owned(),
        DeviceEvent::Cleared(fault) => format!("cleared {:04x}", fault.0),
    }
}

fn grip_words(what: &str, grip: &Grip) -> String {
    let Grip { cmd_id, mode, flags, ttl_ms, force_mn, slew_mn_s, cause_sample } = grip;
    format!("{what} {cmd_id} {mode} {flags} {ttl_ms} {force_mn} {slew_mn_s} {cause_sample}")
}
