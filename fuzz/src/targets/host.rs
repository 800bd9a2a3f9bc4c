//! A host that talks to a gripper over a line that does what the input states: its commands keep every limit.
//!
//! The gripper is the real device, so that the input reaches every state; frames can be forged, damaged, lost and late.

use super::gripper::{CONFIG, SESSION, device, wire};
use super::input::Input;
use grip_link::decoder::{Decoder, Role, Verdict};
use grip_link::device::DeviceLink;
use grip_link::frame::{Direction, Header, MAX_WIRE};
use grip_link::host::{GripCommand, HostConfig, HostEvent, HostLink, LinkState};
use grip_link::message::{Config, FaultCode, Grip, GripMode, Heartbeat, Kind, StatusFlags};

const MOST_TURNS: usize = 200;
/// Frames that a host may have ready at one time: preamble, HELLO, a request, PING.
const MOST_FRAMES: usize = 4;

/// What a byte states that happens; the next bytes show how.
pub const TURNS: [&str; 12] = [
    "micros", "millis", "exchange", "write", "hear", "forge", "grip", "damage", "rows", "trouble",
    "call", "lose",
];

struct Line {
    host: HostLink,
    device: DeviceLink,
    now_us: u64,
    boot_us: u64,
    boot_id: u32,
    to_device: Vec<u8>,
    to_host: Vec<u8>,
    decoder: Decoder,
    /// Number of the GRIP sent last.
    cmd_id: u32,
    /// Session and force of the GRIP sent last; `None` after the link was opened anew.
    sent: Option<(u16, i32)>,
    received: u64,
}

/// The target.
pub fn check(data: &[u8]) {
    let mut line = Line {
        host: HostLink::new(HostConfig::new(CONFIG)).unwrap(),
        device: device(1),
        now_us: 1_000_000,
        boot_us: 1_000_000,
        boot_id: 1,
        to_device: Vec::new(),
        to_host: Vec::new(),
        decoder: Decoder::new(Role::Device),
        cmd_id: 0,
        sent: None,
        received: 0,
    };
    line.device.ready(0);
    line.host.open(line.now_us, SESSION).unwrap();
    let mut input = Input(data);
    for _ in 0..MOST_TURNS {
        if input.is_over() {
            break;
        }
        line.turn(&mut input);
        line.look();
    }
}

impl Line {
    fn turn(&mut self, input: &mut Input<'_>) {
        match TURNS[usize::from(input.u8()) % TURNS.len()] {
            "micros" => self.now_us += u64::from(input.u16()),
            "millis" => self.now_us += 1000 * u64::from(input.u16()),
            "exchange" => self.exchange(),
            "write" => self.write(),
            "hear" => self.receive(input.bytes()),
            "forge" => self.forge(input),
            "grip" => self.grip(input),
            "damage" => self.damage(input),
            "rows" => self.rows(input),
            "trouble" => self.gripper_trouble(input),
            "call" => self.call(input),
            _ => {
                let lost = [&mut self.to_device, &mut self.to_host];
                lost[usize::from(input.u8() & 1)].clear();
            }
        }
    }

    fn tick(&self) -> u64 {
        self.now_us - self.boot_us
    }

    /// Both write what is due, and everything arrives.
    fn exchange(&mut self) {
        self.write();
        let tick = self.tick();
        let arrived = core::mem::take(&mut self.to_device);
        let mut input = arrived.as_slice();
        while self.device.receive(tick, &mut input).is_some() {}
        let arrived = core::mem::take(&mut self.to_host);
        self.receive(&arrived);
    }

    /// Both write what is due; it stays on the line, where it may be damaged, lost or late.
    fn write(&mut self) {
        let mut out = [0; MAX_WIRE];
        let mut frames = 0;
        while let Some(len) = self.host.poll_transmit(self.now_us, &mut out) {
            frames += 1;
            assert!(frames <= MOST_FRAMES, "{frames} frames at one time");
            self.look_at(&out[..len]);
            self.to_device.extend_from_slice(&out[..len]);
        }
        let tick = self.tick();
        while let Some(len) = self.device.poll_transmit(tick, &mut out) {
            self.to_host.extend_from_slice(&out[..len]);
        }
    }

    /// The host takes bytes and time.
    fn receive(&mut self, bytes: &[u8]) {
        let mut input = bytes;
        let mut events = 0;
        while let Some(event) = self.host.receive(self.now_us, &mut input) {
            events += 1;
            assert!(events <= 2 * bytes.len() + 8, "events without end");
            if let HostEvent::Samples { header, .. } = event {
                let samples = self.host.samples(header).unwrap();
                assert_eq!(samples.rows().count(), samples.len());
            }
        }
        assert!(input.is_empty());
    }

    /// Every frame written is a good one of the session in use.
    fn look_at(&mut self, wire: &[u8]) {
        if wire == [0; 8] {
            return;
        }
        let session = self.host.session();
        self.decoder.open_session(session, None);
        let mut input = wire;
        let Some(Verdict::Frame(frame)) = self.decoder.next(&mut input) else {
            panic!("no good frame: {wire:?}")
        };
        assert!(input.is_empty() && frame.header.kind.is_to_device());
        assert!(frame.header.session == session || frame.header.kind == Kind::ESTOP);
    }

    /// A good frame of any type that no gripper sent, or that it sent long ago.
    fn forge(&mut self, input: &mut Input<'_>) {
        let kinds = [0x81, 0x83, 0x86, 0x8E, 0x8F, 0x90, 0x91, 0x92, 0x93, 0x94, 0x81, 0xA0];
        let kind = Kind(input.pick(&kinds));
        let oddity = input.u8();
        let session = if oddity & 1 == 0 { self.host.session() } else { input.pick(&[0, 1]) };
        let header = Header::new(Direction::ToHost, kind, input.u16(), session);
        let bytes = wire(&Header { version: oddity >> 6, ..header }, input.bytes());
        self.receive(&bytes);
    }

    /// R1 and R4 of the host: never negative, never over F_max, never higher while the samples are stale, and no first
    /// force of a session then.
    fn grip(&mut self, input: &mut Input<'_>) {
        let style = input.u8();
        let command = GripCommand {
            mode: [GripMode::Force, GripMode::Force, GripMode::Open, GripMode::Passive]
                [usize::from(style & 3)],
            answers_slip: style & 4 != 0,
            force_mn: if style & 8 == 0 { i32::from(input.u16()) } else { input.i32() },
            ttl_ms: u16::from(style),
            slew_mn_s: input.u32(),
            cause_sample: 1,
        };
        let mut out = [0; MAX_WIRE];
        let written = self.host.grip(self.now_us, &command, &mut out);
        let state = self.host.state();
        let session = self.host.session();
        let before_mn = self.sent.and_then(|(of, force_mn)| (of == session).then_some(force_mn));
        let Some(len) = written else {
            let first = before_mn.is_none() && command.mode == GripMode::Force;
            let may = state == LinkState::Stream || (state == LinkState::Degraded && !first);
            assert!(!may || command.force_mn < 0, "refused in {state:?}");
            return;
        };
        assert!(matches!(state, LinkState::Stream | LinkState::Degraded) && command.force_mn >= 0);
        self.look_at(&out[..len]);
        let Grip { cmd_id, force_mn, .. } = *self.host.last_grip().unwrap();
        let limit = self.host.in_force().unwrap().force_max_mn;
        assert!((0..=limit.min(command.force_mn)).contains(&force_mn));
        assert_eq!(cmd_id, self.cmd_id.wrapping_add(1));
        if state == LinkState::Degraded && command.mode == GripMode::Force {
            assert!(
                before_mn.is_some_and(|before_mn| force_mn <= before_mn),
                "raised while degraded"
            );
        }
        self.cmd_id = cmd_id;
        self.sent = Some((session, if command.mode == GripMode::Force { force_mn } else { 0 }));
        self.to_device.extend_from_slice(&out[..len]);
    }

    fn damage(&mut self, input: &mut Input<'_>) {
        let (which, at, change) = (input.u8(), usize::from(input.u16()), input.u8());
        let bytes = if which & 1 == 0 { &mut self.to_device } else { &mut self.to_host };
        if !bytes.is_empty() {
            let at = at % bytes.len();
            bytes[at] ^= change;
        }
    }

    fn rows(&mut self, input: &mut Input<'_>) {
        for _ in 0..input.u8() % 32 {
            self.now_us += 200;
            let tick = self.tick();
            if self.device.status(tick).flags.has(StatusFlags::SAMPLING) {
                // The mask may have been changed: then the row does not fit, and is refused.
                let _taken = self.device.push_i16(tick, &[1, 2]);
            }
        }
    }

    fn gripper_trouble(&mut self, input: &mut Input<'_>) {
        let tick = self.tick();
        match input.u8() % 4 {
            0 => self.device.raise_fault(tick, FaultCode(input.u16())),
            1 => self.device.estop(tick),
            2 => {
                let _drive = self.device.drive(tick);
            }
            _ => {
                self.boot_id += 1;
                self.boot_us = self.now_us;
                self.device = device(self.boot_id);
                self.device.ready(0);
            }
        }
    }

    fn call(&mut self, input: &mut Input<'_>) {
        let now_us = self.now_us;
        let mut out = [0; MAX_WIRE];
        match input.u8() % 8 {
            0 => self.host.stop(now_us),
            1 => self.host.start(now_us),
            2 => {
                let fault = self.device.fault();
                self.host.clear_fault(now_us, fault);
            }
            3 => {
                let config = Config {
                    force_max_mn: input.i32(),
                    sample_rate_hz: input.u32(),
                    channel_mask: input.u32(),
                    ..CONFIG
                };
                let refused = self.host.reconfigure(now_us, config).is_err();
                assert_eq!(refused, config.force_max_mn < 0 || config.sample_rate_hz == 0);
            }
            4 => {
                let beat = Heartbeat { turns: 1, longest_us: 2, late: 3, flags: 0 };
                if let Some(len) = self.host.heartbeat(&beat, &mut out) {
                    self.look_at(&out[..len]);
                }
            }
            5 => {
                let len = self.host.estop(&mut out).unwrap();
                self.to_device.extend_from_slice(&out[..len]);
            }
            6 => self.host.close(),
            _ => {
                let session = input.u16();
                assert_eq!(self.host.open(now_us, session).is_err(), session == 0);
                if session != 0 {
                    (self.sent, self.received) = (None, 0);
                }
            }
        }
    }

    /// What always holds.
    fn look(&mut self) {
        let loss = self.host.loss();
        assert!(loss.received >= self.received, "received rows vanish");
        self.received = loss.received;
        assert!(loss.dropped_by_mcu <= loss.lost);
        if matches!(self.host.state(), LinkState::Stream | LinkState::Degraded) {
            assert!(self.host.in_force().is_some() && self.host.ident().is_some());
        }
        if self.host.state() != LinkState::Closed {
            assert_ne!(self.host.session(), 0);
        }
        let force_mn = self.device.drive(self.tick()).force_mn();
        assert!((0..=20_000).contains(&force_mn));
    }
}
