//! Alarms and jumps of the reference in, whether the alarms come a little before the jumps out.
//!
//! A knock reaches stylus and reference within half a millisecond of each other. Where the reference is late by 1 to 4 ms
//! the stylus alarms first. An alarm of a slip does that by chance only, since the reference jumps about once a second.
//! The envelopes of motion show less: at a sound reference they lead or lag by 1 ms too ([`correlation`](super::correlation)).

use super::lanes::samples;

/// Time by which an alarm may be before the jump that explains it (ms).
const BEFORE_MS: f32 = 3.5;
/// Such alarms that show a late reference, and jumps with which one is forgotten.
const MANY: u8 = 3;
const FORGOTTEN: u8 = 128;
/// What the stylus waits then (ms).
const WAIT_MS: f32 = 4.0;

/// What was seen of alarms and jumps.
#[derive(Clone, Copy, Debug)]
pub(super) struct Knocks {
    before_len: u32,
    wait_len: i16,
    /// Blocks of the alarm.
    alarmed: u32,
    rang: bool,
    jumps: u8,
    seen: u8,
}

impl Knocks {
    /// Nothing was seen; blocks have `block_s` (s).
    pub(super) fn new(block_s: f32) -> Self {
        Self {
            before_len: samples(BEFORE_MS, 1.0 / block_s),
            wait_len: i16::try_from(samples(WAIT_MS, 1.0 / block_s)).unwrap_or(i16::MAX),
            alarmed: 0,
            rang: false,
            jumps: 0,
            seen: 0,
        }
    }

    /// How long the stylus waits for a reference that shows knocks later (blocks). It stays so: what waits alarms no more.
    #[inline]
    pub(super) fn wait(&self) -> i16 {
        if self.seen >= MANY { self.wait_len } else { 0 }
    }

    /// Takes a block: whether there is an alarm, and whether the reference jumped not long ago.
    #[inline]
    pub(super) fn step(&mut self, alarmed: bool, rings: bool) {
        if rings && !self.rang {
            self.jump(alarmed && self.alarmed <= self.before_len);
        }
        self.rang = rings;
        self.alarmed = if alarmed { self.alarmed.saturating_add(1) } else { 0 };
    }

    #[cold]
    fn jump(&mut self, is_late: bool) {
        if self.seen >= MANY {
            return;
        }
        self.seen += u8::from(is_late);
        self.jumps += 1;
        if self.jumps >= FORGOTTEN {
            (self.jumps, self.seen) = (0, self.seen.saturating_sub(1));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Knocks;

    /// `times` jumps of 40 ms, one a second in blocks of 0.5 ms; an alarm begins so many blocks before each `every`th.
    fn late(times: u32, every: u32, before: u32) -> bool {
        let mut knocks = Knocks::new(5e-4);
        for i in 0..2000 * times {
            let (jump, at) = (i / 2000, i % 2000);
            let alarmed = jump % every == 0 && at + before >= 1000 && at < 1100;
            knocks.step(alarmed, (1000..1080).contains(&at));
        }
        knocks.wait() == 8
    }

    #[test]
    fn three_alarms_just_before_a_jump_show_a_late_reference() {
        assert!(late(3, 1, 0) && late(3, 1, 7) && !late(2, 1, 3));
        assert!(!late(300, 1, 8), "a slip in which the robot begins to move");
        assert!(late(100, 40, 3) && !late(2000, 200, 3), "by chance");
    }
}
