//! A seed in, a script of what a gripper may live through and the lines this crate's device gives for it out.

use crate::targets::gripper::{hello, wire};
use crate::targets::player::Player;
use crate::targets::words::hex;
use core::fmt::Write as _;
use grip_link::frame::{Direction, Header};
use grip_link::message::{
    Config, DeviceState, Grip, Heartbeat, Kind, LossAction, Ping, SampleFormat, Versions,
};
use rand_chacha::ChaCha8Rng;
use rand_core::{Rng as _, SeedableRng as _};

struct Author {
    random: ChaCha8Rng,
    tick: u64,
    seq: u16,
    session: u16,
    cmd_id: u32,
    player: Player,
    script: String,
    lines: Vec<String>,
}

/// A script of `length` commands, and what the device did.
pub(crate) fn play(seed: u64, length: usize) -> (String, Vec<String>) {
    let mut author = Author {
        random: ChaCha8Rng::seed_from_u64(seed),
        tick: 0,
        seq: 0,
        session: 0xBEEF,
        cmd_id: 0,
        player: Player::default(),
        script: String::new(),
        lines: Vec::new(),
    };
    author.write(if seed % 3 == 1 { "new 0 passive" } else { "new 0" });
    author.write("drive 0");
    author.write("rx 0 0001");
    author.write("ready 5");
    for _ in 0..length {
        author.turn();
    }
    (author.script, author.lines)
}

impl Author {
    fn below(&mut self, end: u32) -> u32 {
        self.random.next_u32() % end
    }

    fn odds(&mut self, one_in: u32) -> bool {
        self.below(one_in) == 0
    }

    fn pick<T: Copy, const N: usize>(&mut self, from: [T; N]) -> T {
        from[self.random.next_u32() as usize % N]
    }

    fn write(&mut self, line: &str) {
        writeln!(self.script, "{line}").unwrap();
        self.lines.extend(self.player.obey(line));
    }

    fn turn(&mut self) {
        self.tick += u64::from(self.pick([0_u32, 1, 100, 200, 1000, 1000, 5000, 9000, 30_000]));
        if self.odds(60) {
            self.tick += u64::from(self.pick([60_000_u32, 400_000, 1_200_000]));
        }
        let tick = self.tick;
        match self.below(20) {
            0..=5 => self.frame(),
            6..=9 => self.row(),
            10..=12 => self.write(&format!("drive {tick}")),
            13..=16 => {
                let most = self.pick([0, 1, 3, 20]);
                self.write(&format!("tx {tick} {most}"));
            }
            17 => self.write(&format!("alive {tick}")),
            18 => self.sensor(),
            _ => self.noise(),
        }
    }

    fn sensor(&mut self) {
        let tick = self.tick;
        match self.below(30) {
            0 => {
                let code = self.pick([0_u16, 1, 0x0101, 0x0104, 0x0105, 0x0201, 0xFFFF]);
                self.write(&format!("fault {tick} {code:04x}"));
            }
            1 => self.write(&format!("estop {tick}")),
            2..=9 => {
                let um = self.pick([-1, 0, 25_000, 50_000, 50_001]);
                self.write(&format!("travel {tick} {um}"));
            }
            10..=15 => {
                let mn = self.pick([0, 700, 20_500, -3]);
                self.write(&format!("force {tick} {mn}"));
            }
            16..=21 => {
                let moving = self.below(2);
                self.write(&format!("motion {tick} {moving}"));
            }
            _ => {
                let text = self.pick(["", "68656c6420c2b5", "61"]);
                let text =
                    if self.odds(5) { "62".repeat(self.below(258) as usize) } else { text.into() };
                self.write(&format!("log {tick} 2 {text}"));
            }
        }
    }

    fn row(&mut self) {
        let format =
            self.player.device.in_force().map_or(SampleFormat::I16, |config| config.format);
        let mask = self.player.device.in_force().map_or(3, |config| config.channel_mask);
        let right = (mask & 1) + (mask >> 1 & 1) + 4 * (mask >> 2 & 1);
        let count = if self.odds(30) { self.below(9) } else { right };
        let floats = (format == SampleFormat::F32) ^ self.odds(40);
        for _ in 0..=self.below(12) {
            let mut line = format!("{} {}", if floats { "f32" } else { "i16" }, self.tick);
            for _ in 0..count {
                let value = self.random.next_u32();
                if floats {
                    write!(line, " {:08x}", value & 0x7F7F_FFFF).unwrap();
                } else {
                    let [low, high, ..] = value.to_le_bytes();
                    write!(line, " {}", i16::from_le_bytes([low, high])).unwrap();
                }
            }
            self.write(&line);
            self.tick += u64::from(self.pick([50_u32, 100, 200]));
        }
    }

    fn noise(&mut self) {
        let bytes: Vec<u8> =
            (0..self.below(40)).map(|_| self.random.next_u32().to_le_bytes()[0]).collect();
        let text = hex(&bytes);
        self.write(&format!("rx {} {text}", self.tick));
    }

    fn frame(&mut self) {
        let linked = self.player.device.state() >= DeviceState::Linked;
        let armed = self.player.device.in_force().is_some();
        let kind = match self.below(40) {
            _ if !linked && !self.odds(4) => Kind::HELLO,
            _ if linked && !armed && !self.odds(3) => Kind::CONFIG,
            0 => Kind::HELLO,
            1 => Kind::CONFIG,
            2 => Kind::STOP,
            3 if self.odds(4) => Kind::ESTOP,
            4..=6 => Kind::CLEAR_FAULT,
            7..=11 => Kind::START,
            12..=14 => Kind::PING,
            15 | 16 => Kind::HEARTBEAT,
            17 => Kind(self.random.next_u32().to_le_bytes()[0]),
            _ => Kind::GRIP,
        };
        if kind == Kind::HELLO {
            self.session = self.pick([0xBEEF, 7, 0xFFFF]);
        }
        let mut payload = self.payload(kind);
        if self.odds(40) {
            payload.truncate(self.below(30) as usize);
        }
        if self.odds(20) {
            payload.extend([1, 0, 2]);
        }
        self.send(kind, &payload);
    }

    fn send(&mut self, kind: Kind, payload: &[u8]) {
        let ack_req = self.odds(2);
        let session = match self.below(30) {
            0 => 0,
            1 => 0x1234,
            _ if kind == Kind::ESTOP => 0,
            _ => self.session,
        };
        let direction = if self.odds(60) { Direction::ToHost } else { Direction::ToDevice };
        let version = if self.odds(60) { 2 } else { 1 };
        let header = Header { version, ack_req, ..Header::new(direction, kind, self.seq, session) };
        self.seq = self.seq.wrapping_add(self.pick([1, 1, 1, 1, 1, 1, 1, 0, 3, 65_530]));
        let mut bytes = wire(&header, payload);
        if self.odds(25) {
            let at = self.below(u32::try_from(bytes.len()).unwrap()) as usize;
            bytes[at] ^= 0x10;
        }
        let text = hex(&bytes);
        if self.odds(10) {
            let (a, b) = text.split_at(text.len() / 4 * 2);
            let tick = self.tick;
            self.write(&format!("rx {tick} {a}"));
            self.write(&format!("rx {tick} {b}"));
        } else {
            self.write(&format!("rx {} {text}", self.tick));
        }
    }

    fn payload(&mut self, kind: Kind) -> Vec<u8> {
        let mut out = vec![0; 64];
        let len = match kind {
            Kind::HELLO => {
                let (min, max) = self.pick([(1, 1), (1, 1), (1, 1), (0, 15), (2, 3), (0, 0)]);
                return hello(Versions { min, max }, self.tick).to_vec();
            }
            Kind::CONFIG => self.config().write(&mut out),
            Kind::PING => Ping { t1_us: self.tick.wrapping_mul(977) }.write(&mut out),
            Kind::HEARTBEAT => {
                Heartbeat { turns: self.seq.into(), longest_us: 5, late: 1, flags: 0 }
                    .write(&mut out)
            }
            Kind::CLEAR_FAULT => {
                let code = self.player.device.fault().0;
                let code = if self.odds(4) { 0x0201 } else { code };
                out[..2].copy_from_slice(&code.to_le_bytes());
                Ok(2)
            }
            Kind::GRIP => self.grip().write(&mut out),
            _ => Ok(0),
        };
        out.truncate(len.unwrap());
        out
    }

    fn config(&mut self) -> Config {
        Config {
            sample_rate_hz: self.pick([5000, 5000, 1000, 20_000, 1, 1_000_000]),
            batch: self.pick([1, 5, 10, 255]),
            format: self.pick([SampleFormat::I16, SampleFormat::F32]),
            ttl_ms: self.pick([50, 20, 100, 0, 9999]),
            channel_mask: self.pick([3, 3, 7, 1, 0xFFFF_FFFF, 0x80]),
            force_max_mn: self.pick([10_000, 10_000, 20_000, i32::MAX, 0, 3000]),
            slew_mn_s: self.pick([200_000, 200_000, 777, u32::MAX, 50_000]),
            hold_cap_mn: self.pick([8000, 8000, 100, i32::MAX, 0]),
            loss_after_ms: self.pick([1000, 300, 0, 65_535]),
            loss_action: self.pick([LossAction::Hold, LossAction::Open, LossAction::Passive]),
        }
    }

    fn grip(&mut self) -> Grip {
        self.cmd_id = self.cmd_id.wrapping_add(self.pick([1, 1, 1, 1, 1, 0, u32::MAX, 1 << 31]));
        Grip {
            cmd_id: self.cmd_id,
            mode: self.pick([1, 1, 1, 1, 1, 1, 2, 3, 0, 4]),
            flags: self.pick([0, 1]),
            ttl_ms: self.pick([0, 0, 50, 20, 5, 60_000]),
            force_mn: self.pick([0, 1500, 5000, 9000, 9000, 30_000, i32::MAX, -1, i32::MIN]),
            slew_mn_s: self.pick([0, 0, 100_000, u32::MAX, 1]),
            cause_sample: self.seq.into(),
        }
    }
}
