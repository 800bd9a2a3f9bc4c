//! A seed in, bytes for the fuzz target `host` out that lead a host through most of what may happen to it.

use crate::dice::Dice;
use crate::targets::gripper::ident;
use grip_link::message::{Ident, Kind};

const KINDS: [Kind; 6] =
    [Kind::IDENT, Kind::CONFIG_ACK, Kind::PONG, Kind::ACK, Kind::NACK, Kind::SAMPLES];

/// Turns of the target by the numbers there.
pub(crate) struct Life {
    dice: Dice,
    turns: Vec<u8>,
}

impl Life {
    pub(crate) fn new(seed: u64) -> Self {
        Self { dice: Dice::new(seed), turns: Vec::new() }
    }

    /// As many parts as the target takes turns of.
    pub(crate) fn bytes(mut self) -> Vec<u8> {
        self.attach();
        self.stream();
        for _ in 0..24 {
            match self.dice.below(18) {
                0..3 => self.stream(),
                3..6 => self.grip(),
                6 | 7 => self.wait(),
                8 => self.gap(),
                9 => self.call(),
                10 => self.forge(),
                11 => self.reopen(),
                12 => self.reboot(),
                13 => self.fault(),
                14 => self.silence(),
                15 => self.unacknowledged(),
                16 => self.unanswered(),
                _ => self.noise(),
            }
        }
        self.turns
    }

    fn put(&mut self, turns: &[u8]) {
        self.turns.extend(turns);
    }

    fn micros(&mut self, us: u16) {
        self.put(&[0]);
        self.put(&us.to_le_bytes());
    }

    fn millis(&mut self, ms: u16) {
        self.put(&[1]);
        self.put(&ms.to_le_bytes());
    }

    fn attach(&mut self) {
        for _ in 0..5 {
            self.micros(200);
            self.put(&[2]);
        }
    }

    fn stream(&mut self) {
        for _ in 0..=self.dice.below(5) {
            let rows = self.dice.pick(&[5, 10, 10, 25]);
            self.put(&[8, rows, 2]);
        }
    }

    /// Around the ends of freshness, retry, life and link.
    fn wait(&mut self) {
        if self.dice.one_in(4) {
            let ms = self.dice.pick(&[49, 50, 51, 100, 999, 1001]);
            self.millis(ms);
        } else {
            let us = self.dice.pick(&[4_900, 5_100, 7_500, 9_900, 10_100, 16_000]);
            self.micros(us);
        }
        if self.dice.one_in(2) {
            self.put(&[4, 0]);
        }
        self.grip();
        self.put(&[2]);
    }

    /// Rows that are lost on the line: DEGRADED until the next ones.
    fn gap(&mut self) {
        self.put(&[8, 10, 2, 8, 10, 3, 11, 1, 8, 10, 2]);
        self.grip();
    }

    fn grip(&mut self) {
        let style = self.dice.pick(&[0, 0, 0, 1, 4, 8, 2, 3]);
        self.put(&[6, style]);
        if style & 8 == 0 {
            let force_mn = self.dice.pick(&[0_u16, 700, 3000, 9000, 30_000]);
            self.put(&force_mn.to_le_bytes());
        } else {
            let force_mn = self.dice.pick(&[-1, i32::MIN, i32::MAX]);
            self.put(&force_mn.to_le_bytes());
        }
        let slew = self.dice.pick(&[0, 1]);
        self.put(&[0, 0, slew, 0]);
    }

    fn call(&mut self) {
        match self.dice.below(6) {
            0 => self.put(&[10, 0, 2, 2]),
            1 => self.put(&[10, 1, 2, 2]),
            2 => {
                let force_max_mn = self.dice.pick(&[2000, 15_000, -1]);
                let rate_hz = self.dice.pick(&[0_u32, 300, 1000, 20_000]);
                let mask = self.dice.pick(&[1, 3, 7, 0]);
                self.put(&[10, 3]);
                self.put(&i32::to_le_bytes(force_max_mn));
                self.put(&rate_hz.to_le_bytes());
                self.put(&[mask, 0, 0, 0, 2, 2, 2]);
            }
            3 => self.put(&[10, 4]),
            4 => self.put(&[10, 5, 2, 2, 2, 10, 2, 2, 2, 2]),
            _ => self.put(&[10, 6]),
        }
    }

    /// A frame that no gripper sent: any payload, or a good IDENT of a gripper that may be another.
    fn forge(&mut self) {
        let at = self.dice.below(12);
        let (oddity, seq) = (self.dice.pick(&[0x40, 0x40, 0x40, 0x41, 0x80]), self.dice.any());
        self.put(&[5, u8::try_from(at).unwrap(), oddity]);
        if oddity & 1 == 1 {
            self.put(&[0]);
        }
        self.put(&seq.to_le_bytes()[..2]);
        let payload =
            if at == 0 || at == 10 { self.ident() } else { self.payload(KINDS[at.min(5)]) };
        self.put(&[u8::try_from(payload.len()).unwrap()]);
        self.put(&payload);
    }

    fn payload(&mut self, kind: Kind) -> Vec<u8> {
        let len = self.dice.pick(&[4, 24, 30, 40, 64]);
        let mut payload = self.dice.bytes(len);
        if kind == Kind::NACK || kind == Kind::ACK {
            // For a request that may be under way.
            payload[0] = self.dice.pick(&[3, 4, 5, 0x12, 0x13]);
            payload[1] = self.dice.pick(&[1, 2, 4, 5]);
            payload[2] = self.dice.pick(&[1, 2, 3, 4, 5, 6, 7, 8]);
            payload[3] = 0;
        }
        payload
    }

    /// The IDENT of the gripper's first boot, of another boot, of another gripper, or one that ends the link.
    fn ident(&mut self) -> Vec<u8> {
        let boot_id = self.dice.pick(&[1, 1, 2]);
        let mut payload = [0; 200];
        let len = ident(boot_id).write(&mut payload).unwrap();
        let mut payload = payload[..len].to_vec();
        match self.dice.below(8) {
            0..3 => payload[8 + self.dice.below(16)] ^= 1,
            3 => (payload[0], payload[1]) = (2, 3),
            4 => payload[Ident::TABLE] = 2,
            5 => payload.truncate(self.dice.below(len)),
            _ => {}
        }
        payload
    }

    /// Another session, in which the first answer may come from another gripper.
    fn reopen(&mut self) {
        let session = self.dice.pick(&[1_u16, 0xBEEF, 0xFFFF, 0xFFFF, 0]);
        self.put(&[10, 7]);
        self.put(&session.to_le_bytes());
        if self.dice.one_in(2) {
            self.put(&[3]);
            self.put(&[5, 0, 0x40, 1, 0]);
            let payload = self.ident();
            self.put(&[u8::try_from(payload.len()).unwrap()]);
            self.put(&payload);
        }
        self.attach();
        if self.dice.one_in(2) {
            self.gap();
        }
    }

    /// The gripper starts anew, now and then at the end of the session numbers.
    fn reboot(&mut self) {
        if self.dice.one_in(2) {
            self.put(&[10, 7, 0xFF, 0xFF]);
            self.attach();
            self.stream();
        }
        self.put(&[9, 3]);
        self.grip();
        self.attach();
        self.attach();
    }

    /// A fault, with a session that begins while it is latched, and its end.
    fn fault(&mut self) {
        let fault = self.dice.pick(&[0x0101_u16, 0x0201]);
        self.put(&[9, 0]);
        self.put(&fault.to_le_bytes());
        if self.dice.one_in(2) {
            self.put(&[10, 7, 7, 0]);
        }
        self.attach();
        self.put(&[10, 2]);
        self.attach();
    }

    /// Nobody answers until the link is given up; then mostly another try.
    fn silence(&mut self) {
        if self.dice.one_in(2) {
            self.put(&[10, 7, 9, 0]);
        }
        for _ in 0..4 {
            self.millis(1001);
            self.put(&[4, 0]);
        }
        self.put(&[11, 0, 11, 1]);
        if !self.dice.one_in(3) {
            self.put(&[10, 7, 8, 0]);
            self.attach();
        }
    }

    /// A session whose START arrives and whose ACK does not: the samples show.
    fn unacknowledged(&mut self) {
        self.put(&[10, 7, 5, 0, 2, 2, 2, 2, 2, 3, 11, 1, 8, 10, 2]);
    }

    /// A session in which nothing arrives any more, from somewhere in the handshake on.
    fn unanswered(&mut self) {
        self.put(&[10, 7, 6, 0]);
        for _ in 0..self.dice.below(5) + 1 {
            self.put(&[2]);
        }
        for _ in 0..4 {
            self.put(&[3, 11, 0, 11, 1]);
            self.millis(50);
        }
        self.put(&[2]);
    }

    fn noise(&mut self) {
        if self.dice.one_in(2) {
            let (which, at) = (self.dice.pick(&[0, 1]), self.dice.pick(&[0, 3, 40, 200]));
            self.put(&[8, 10, 2, 8, 10, 3, 7, which, at, 0, 64, 2]);
        } else {
            let len = self.dice.pick(&[1, 8, 40]);
            let noise = self.dice.bytes(len);
            self.put(&[4, u8::try_from(len).unwrap()]);
            self.put(&noise);
        }
    }
}
