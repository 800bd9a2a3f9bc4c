//! A seed in, lines of ticks and bytes for a device out: the language of `python -m grip_link.diff device`.

use crate::dice::Dice;
use crate::targets::gripper::{hello, wire};
use crate::targets::words::hex;
use grip_link::frame::{Direction, Header};
use grip_link::message::{
    ClearFault, Config, FaultCode, Grip, Heartbeat, Kind, LossAction, Ping, SampleFormat, Versions,
};

const SESSION: u16 = 7;
const STEPS: [u64; 10] = [0, 1, 137, 200, 1000, 1000, 5000, 20_000, 90_000, 400_000];
const FAULTS: [u16; 7] = [0, 1, 0x0101, 0x0104, 0x0105, 0x0201, 0x7777];
const FLOATS: [u32; 5] = [0x3f80_0000, 0x7fc0_0000, 0xff80_0000, 0x1234_5678, 0x8000_0000];

/// A host that does as it should most of the time.
pub(crate) struct Script {
    dice: Dice,
    lines: Vec<String>,
    tick: u64,
    seq: u16,
    cmd_id: u32,
}

impl Script {
    pub(crate) fn new(seed: u64) -> Self {
        let mut dice = Dice::new(seed);
        let tick = dice.pick(&[0, 5, 1 << 40]);
        let estop = if seed % 3 == 1 { " passive" } else { "" };
        let lines = vec![format!("new {tick}{estop}"), format!("ready {tick}")];
        let mut script = Self { dice, lines, tick, seq: 0, cmd_id: 0 };
        script.hello();
        script.config();
        script.request(Kind::START, &[]);
        script
    }

    pub(crate) fn lines(mut self, count: usize) -> Vec<String> {
        while self.lines.len() < count {
            self.tick += self.dice.pick(&STEPS);
            match self.dice.below(100) {
                0..25 => self.grip(),
                25..40 => self.say("drive", ""),
                40..55 => {
                    let most = self.dice.below(6);
                    self.say("tx", &most.to_string());
                }
                55..72 => self.row(),
                72..79 => self.firmware(),
                79..82 => self.hello(),
                82..86 => self.config(),
                86..89 => self.request(Kind::START, &[]),
                89..90 => self.request(Kind::STOP, &[]),
                90..92 => self.short(),
                92..95 => self.clear(),
                _ => self.oddity(),
            }
        }
        self.lines
    }

    fn say(&mut self, command: &str, rest: &str) {
        self.lines.push(format!("{command} {} {rest}", self.tick).trim_end().to_owned());
    }

    fn send(&mut self, header: &Header, payload: &[u8]) {
        let mut bytes = wire(&Header { seq: self.seq, ..*header }, payload);
        self.seq = self.seq.wrapping_add(1);
        if self.dice.one_in(50) {
            self.dice.damage(&mut bytes);
        }
        self.say("rx", &hex(&bytes));
    }

    fn request(&mut self, kind: Kind, payload: &[u8]) {
        let ack_req = !self.dice.one_in(20);
        let header = Header { ack_req, ..Header::new(Direction::ToDevice, kind, 0, SESSION) };
        self.send(&header, payload);
    }

    fn grip(&mut self) {
        let dice = &mut self.dice;
        self.cmd_id = self.cmd_id.wrapping_add(dice.pick(&[1, 1, 1, 1, 0, u32::MAX, 1 << 31]));
        let grip = Grip {
            cmd_id: self.cmd_id,
            mode: dice.pick(&[1, 1, 1, 1, 1, 2, 3, 0, 9]),
            flags: 0,
            ttl_ms: dice.pick(&[0, 0, 20, 50, 100, 1, u16::MAX]),
            force_mn: dice.pick(&[0, 1000, 5000, 20_000, -1, i32::MAX, i32::MIN]),
            slew_mn_s: dice.pick(&[0, 1, 50_000, u32::MAX]),
            cause_sample: 9,
        };
        let mut payload = [0; Grip::SIZE];
        grip.write(&mut payload).unwrap();
        let len = dice.pick(&[20, 20, 20, 20, 19]);
        self.send(&Header::new(Direction::ToDevice, Kind::GRIP, 0, SESSION), &payload[..len]);
    }

    fn row(&mut self) {
        let elements = self.dice.pick(&[2, 2, 2, 1, 6, 3]);
        let floats = self.dice.one_in(2);
        let word = |dice: &mut Dice| {
            if floats {
                format!("{:08x}", dice.pick(&FLOATS))
            } else {
                dice.pick(&[0, 1, -1, i16::MIN, i16::MAX]).to_string()
            }
        };
        let words: Vec<_> = (0..elements).map(|_| word(&mut self.dice)).collect();
        self.say(if floats { "f32" } else { "i16" }, &words.join(" "));
    }

    fn firmware(&mut self) {
        match self.dice.below(16) {
            0..5 => self.say("alive", ""),
            5..8 => {
                let at = self.dice.pick(&[-1, 0, 50_000, 50_001]);
                self.say("travel", &at.to_string());
            }
            8 => {
                let force = self.dice.pick(&[-5, 0, 30_000]);
                self.say("force", &force.to_string());
            }
            9..11 => {
                let fault = self.dice.pick(&FAULTS);
                self.say("fault", &format!("{fault:04x}"));
            }
            11 => self.say("estop", ""),
            12..14 => {
                let moving = self.dice.below(2);
                self.say("motion", &moving.to_string());
            }
            _ => {
                let len = self.dice.below(40) + 1;
                let text: Vec<u8> =
                    self.dice.bytes(len).iter().map(|byte| byte % 95 + b' ').collect();
                let level = self.dice.below(5);
                self.say("log", &format!("{level} {}", hex(&text)));
            }
        }
    }

    fn hello(&mut self) {
        let fresh = self.lines.len() == 2;
        let dice = &mut self.dice;
        let versions = if fresh {
            Versions::OURS
        } else {
            Versions { min: dice.pick(&[0, 1, 1, 2]), max: dice.pick(&[1, 1, 2, 0]) }
        };
        let payload = hello(versions, self.tick);
        let session = if fresh { SESSION } else { dice.pick(&[SESSION, SESSION, SESSION, 0, 8]) };
        let header = Header::new(Direction::ToDevice, Kind::HELLO, 0, session);
        let version = if fresh { 1 } else { dice.pick(&[1, 1, 2]) };
        self.send(&Header { ack_req: true, version, ..header }, &payload);
    }

    fn config(&mut self) {
        let dice = &mut self.dice;
        let config = Config {
            sample_rate_hz: dice.pick(&[1, 5, 1000, 5000, 1_000_000]),
            batch: dice.pick(&[1, 2, 5, 255]),
            format: dice.pick(&[SampleFormat::I16, SampleFormat::F32]),
            ttl_ms: dice.pick(&[0, 20, 50, 100, 200]),
            channel_mask: dice.pick(&[3, 3, 3, 1, 7, u32::MAX, 8]),
            force_max_mn: dice.pick(&[0, 5000, 10_000, i32::MAX]),
            slew_mn_s: dice.pick(&[1, 100_000, u32::MAX]),
            hold_cap_mn: dice.pick(&[0, 4000, i32::MAX]),
            loss_after_ms: dice.pick(&[0, 100, 300, u16::MAX]),
            loss_action: dice.pick(&[LossAction::Hold, LossAction::Open, LossAction::Passive]),
        };
        let mut payload = config.to_bytes();
        if dice.one_in(10) {
            let at = dice.below(payload.len());
            payload[at] = dice.pick(&[0, 1, 3, 0x80, 0xff]);
        }
        self.request(Kind::CONFIG, &payload);
    }

    fn short(&mut self) {
        let mut payload = [0; Heartbeat::SIZE];
        if self.dice.one_in(3) {
            Heartbeat { turns: 1, longest_us: 2, late: 3, flags: 4 }.write(&mut payload).unwrap();
            self.send(&Header::new(Direction::ToDevice, Kind::HEARTBEAT, 0, SESSION), &payload);
        } else {
            let len = Ping { t1_us: self.dice.any() }.write(&mut payload).unwrap();
            let header = Header::new(Direction::ToDevice, Kind::PING, 0, SESSION);
            self.send(&header, &payload[..len]);
        }
    }

    fn clear(&mut self) {
        let mut payload = [0; ClearFault::SIZE];
        ClearFault { fault: FaultCode(self.dice.pick(&FAULTS)) }.write(&mut payload).unwrap();
        self.request(Kind::CLEAR_FAULT, &payload);
    }

    /// What a host does not do, or seldom: stops, unknown types, echoes, other sessions, jumps of the count, noise.
    fn oddity(&mut self) {
        let dice = &mut self.dice;
        match dice.below(6) {
            0 => {
                let session = dice.pick(&[0, SESSION, 99]);
                let header = Header::new(Direction::ToDevice, Kind::ESTOP, 0, session);
                self.send(&Header { ack_req: true, ..header }, &[]);
            }
            1 => {
                let kind = Kind(dice.pick(&[0x00, 0x07, 0x7e, 0x81, 0xa0]));
                self.request(kind, &[1, 2, 3]);
            }
            2 => self.send(&Header::new(Direction::ToHost, Kind::PONG, 0, SESSION), &[0; 24]),
            3 => self.send(&Header::new(Direction::ToDevice, Kind::STOP, 0, 99), &[]),
            4 => {
                let jump = dice.pick(&[1, 200, 65_400, 65_200, 30_000]);
                self.seq = self.seq.wrapping_add(jump);
            }
            _ => {
                let len = dice.below(30) + 1;
                let noise = dice.bytes(len);
                self.say("rx", &hex(&noise));
            }
        }
    }
}
