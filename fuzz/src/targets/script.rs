//! Script of a gripper's life, made from bytes: time, bytes of a host that is mostly sane, samples, faults of the firmware.
//!
//! The same life can be played by the device of this project and, as lines of text, by its peers in C and Python:
//! `ready T`, `rx T HEX`, `tx T MOST`, `drive T`, `i16 T values`, `f32 T hex bits`, `fault T HEX`, `estop T`, `travel T UM`,
//! `force T MN`, `alive T`, `log T LEVEL HEX`.

use super::gripper::{CONFIG, SESSION, hello, wire};
use super::input::Input;
use super::words::hex;
use grip_link::frame::{Direction, Header};
use grip_link::message::{
    ClearFault, Config, FaultCode, Grip, Heartbeat, Kind, LossAction, Ping, SampleFormat, Versions,
};

/// Most steps of a life.
const MOST_STEPS: usize = 200;

/// What a byte states that happens; the next bytes show how.
pub const TURNS: [&str; 20] = [
    "micros", "millis", "ready", "noise", "frame", "hello", "config", "start", "grip", "drive",
    "send", "row", "floats", "fault", "clear", "estop", "measured", "alive", "log", "short",
];

/// What happens.
#[derive(Debug, Clone, PartialEq)]
pub enum Action {
    /// Self-tests are over.
    Ready,
    /// Bytes arrive.
    Receive(Vec<u8>),
    /// The port takes up to this many frames.
    Transmit(u8),
    /// The force loop runs.
    Drive,
    /// A row is sampled.
    RowI16(Vec<i16>),
    /// A row is sampled.
    RowF32(Vec<f32>),
    /// The firmware finds a fault.
    Fault(FaultCode),
    /// A stop button.
    Estop,
    /// Finger position (um).
    Travel(i32),
    /// Measured force (mN).
    Force(i32),
    /// The watchdog asks.
    Alive,
    /// A text of this level.
    Log(u8, String),
}

/// Something that happens at a tick.
#[derive(Debug, Clone, PartialEq)]
pub struct Step {
    /// When.
    pub tick: u64,
    /// What.
    pub action: Action,
}

impl Step {
    /// The step in the language of the peers.
    pub fn line(&self) -> String {
        let tick = self.tick;
        let joined = |words: Vec<String>| words.join(" ");
        match &self.action {
            Action::Ready => format!("ready {tick}"),
            Action::Receive(bytes) => format!("rx {tick} {}", hex(bytes)),
            Action::Transmit(most) => format!("tx {tick} {most}"),
            Action::Drive => format!("drive {tick}"),
            Action::RowI16(row) => {
                format!("i16 {tick} {}", joined(row.iter().map(i16::to_string).collect()))
            }
            Action::RowF32(row) => {
                let bits = row.iter().map(|value| format!("{:08x}", value.to_bits()));
                format!("f32 {tick} {}", joined(bits.collect()))
            }
            Action::Fault(fault) => format!("fault {tick} {:04x}", fault.0),
            Action::Estop => format!("estop {tick}"),
            Action::Travel(position_um) => format!("travel {tick} {position_um}"),
            Action::Force(force_mn) => format!("force {tick} {force_mn}"),
            Action::Alive => format!("alive {tick}"),
            Action::Log(level, text) => format!("log {tick} {level} {}", hex(text.as_bytes())),
        }
    }
}

/// The life that `data` describes.
pub fn steps(data: &[u8]) -> Vec<Step> {
    let mut author = Author { input: Input(data), tick: 0, seq: 0, cmd_id: 0, steps: Vec::new() };
    author.tick = author.input.pick(&[0, 5, 1 << 40]);
    while !author.input.is_over() && author.steps.len() < MOST_STEPS {
        author.turn();
    }
    author.steps
}

struct Author<'a> {
    input: Input<'a>,
    tick: u64,
    seq: u16,
    cmd_id: u32,
    steps: Vec<Step>,
}

impl Author<'_> {
    fn happens(&mut self, action: Action) {
        self.steps.push(Step { tick: self.tick, action });
    }

    /// One turn: a byte states what, the next ones how.
    fn turn(&mut self) {
        let what = usize::from(self.input.u8()) % TURNS.len();
        match TURNS[what] {
            "micros" => self.tick += u64::from(self.input.u16()),
            "millis" => self.tick += 1000 * u64::from(self.input.u16()),
            "ready" => self.happens(Action::Ready),
            "noise" => self.noise(),
            "frame" => self.any_frame(),
            "hello" => self.hello(),
            "config" => self.config(),
            "start" => self.request(Kind::START, &[]),
            "grip" => self.grip(),
            "drive" => self.happens(Action::Drive),
            "send" => {
                let most = self.input.u8() % 8;
                self.happens(Action::Transmit(most));
            }
            "row" => self.row(false),
            "floats" => self.row(true),
            "fault" => {
                let fault =
                    FaultCode(self.input.pick(&[0x0101, 0x0104, 0x0201, 0x0105, 0, 1, 0x7777]));
                self.happens(Action::Fault(fault));
            }
            "clear" => self.clear(),
            "estop" => self.happens(Action::Estop),
            "measured" => self.measured(),
            "alive" => self.happens(Action::Alive),
            "log" => self.text(),
            _ => self.short(),
        }
    }

    fn send(&mut self, header: Header, payload: &[u8]) {
        let bytes = wire(&Header { seq: self.seq, ..header }, payload);
        self.seq = self.seq.wrapping_add(1);
        self.happens(Action::Receive(bytes));
    }

    fn request(&mut self, kind: Kind, payload: &[u8]) {
        let header = Header::new(Direction::ToDevice, kind, 0, SESSION);
        self.send(Header { ack_req: true, ..header }, payload);
    }

    fn noise(&mut self) {
        let bytes = self.input.bytes();
        if !bytes.is_empty() {
            self.happens(Action::Receive(bytes.to_vec()));
        }
    }

    /// Any type and payload, in a frame that may come from the past, another session, version or direction.
    fn any_frame(&mut self) {
        let kind = Kind(self.input.u8());
        let oddity = self.input.u8();
        let payload = self.input.bytes();
        let bit = |n: u8| oddity >> n & 1 == 1;
        if bit(0) {
            self.seq = self.seq.wrapping_add(self.input.pick(&[1, 200, 30_000, 65_281, 65_280]));
        }
        let session = if bit(1) { self.input.pick(&[0, 1, 0xFFFF]) } else { SESSION };
        let direction = if bit(2) && bit(3) { Direction::ToHost } else { Direction::ToDevice };
        let version = if bit(4) && bit(5) { oddity >> 6 } else { 1 };
        let header = Header::new(direction, kind, 0, session);
        self.send(Header { version, ack_req: bit(6), ..header }, payload);
    }

    fn hello(&mut self) {
        let versions = self.input.pick(&[
            Versions::OURS,
            Versions::OURS,
            Versions { min: 0, max: 2 },
            Versions { min: 2, max: 9 },
        ]);
        let payload = hello(versions, self.tick);
        self.request(Kind::HELLO, &payload);
    }

    /// The usual one, or any.
    fn config(&mut self) {
        let input = &mut self.input;
        let config = match input.u8() % 4 {
            0 | 1 => CONFIG,
            2 => Config {
                ttl_ms: input.u16(),
                loss_after_ms: input.u16(),
                loss_action: input.pick(&[LossAction::Hold, LossAction::Open, LossAction::Passive]),
                ..CONFIG
            },
            _ => Config {
                sample_rate_hz: input.u32(),
                batch: input.u8(),
                format: input.pick(&[SampleFormat::I16, SampleFormat::F32]),
                channel_mask: input.u32(),
                force_max_mn: input.i32(),
                slew_mn_s: input.u32(),
                hold_cap_mn: input.i32(),
                ..CONFIG
            },
        };
        self.request(Kind::CONFIG, &config.to_bytes());
    }

    fn grip(&mut self) {
        let input = &mut self.input;
        let style = input.u8();
        self.cmd_id = self.cmd_id.wrapping_add(input_step(style));
        let grip = Grip {
            cmd_id: self.cmd_id,
            mode: [1, 1, 1, 1, 2, 3, 0, 200][usize::from(style >> 2 & 7)],
            flags: 0,
            ttl_ms: if style & 32 == 0 { 0 } else { input.u16() },
            force_mn: if style & 64 == 0 { i32::from(input.u16()) } else { input.i32() },
            slew_mn_s: if style & 128 == 0 { 0 } else { input.u32() },
            cause_sample: 9,
        };
        let mut payload = [0; Grip::SIZE];
        grip.write(&mut payload).unwrap();
        self.send(Header::new(Direction::ToDevice, Kind::GRIP, 0, SESSION), &payload);
    }

    fn row(&mut self, floats: bool) {
        let elements = self.input.pick(&[2_u8, 2, 1, 6, 7]);
        let input = &mut self.input;
        let action = if floats {
            let choices = [0x3f80_0000, 0x7fc0_0000, 0xff80_0000, 0x1234_5678, 0x8000_0000];
            Action::RowF32((0..elements).map(|_| f32::from_bits(input.pick(&choices))).collect())
        } else {
            let value = input.u16().cast_signed();
            Action::RowI16((0..elements).map(|k| value.wrapping_add(i16::from(k))).collect())
        };
        self.happens(action);
    }

    fn clear(&mut self) {
        let fault = FaultCode(self.input.pick(&[0x0101, 0x0104, 0x0201, 0x0105, 1, 0x7777, 0]));
        let mut payload = [0; ClearFault::SIZE];
        ClearFault { fault }.write(&mut payload).unwrap();
        self.request(Kind::CLEAR_FAULT, &payload);
    }

    fn measured(&mut self) {
        let value = self.input.i32();
        let action =
            if value & 1 == 0 { Action::Travel(value / 8192) } else { Action::Force(value) };
        self.happens(action);
    }

    fn text(&mut self) {
        let level = self.input.u8() % 5;
        let text: String =
            self.input.bytes().iter().map(|byte| char::from(b' ' + byte % 95)).collect();
        if !text.is_empty() {
            self.happens(Action::Log(level, text));
        }
    }

    fn short(&mut self) {
        let mut payload = [0; Heartbeat::SIZE];
        let (kind, len) = if self.input.u8() & 1 == 0 {
            let t1_us = u64::from(self.input.u32());
            (Kind::PING, Ping { t1_us }.write(&mut payload))
        } else {
            let beat = Heartbeat { turns: self.input.u32(), longest_us: 1, late: 0, flags: 1 };
            (Kind::HEARTBEAT, beat.write(&mut payload))
        };
        let header = Header::new(Direction::ToDevice, kind, 0, SESSION);
        self.send(header, &payload[..len.unwrap()]);
    }
}

/// How far the command number goes on: mostly by one.
fn input_step(style: u8) -> u32 {
    [1, 1, 0, u32::MAX][usize::from(style & 3)]
}
