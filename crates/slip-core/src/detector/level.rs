//! The test for rates that carry no band above motion: how far the mean log-energy stands above the highest level that went on before.

use super::lanes::samples;

/// Time constant of the mean (s).
const MEAN_S: f32 = 0.4;
/// What is older than this (s) is judged against; a slip that begins does not count yet.
const PAST_S: f32 = 0.8;
/// Energy over the highest level so far that is a slip.
const RATIO: f32 = 3.0;
/// Time in which the highest level falls by e (s).
const FADES_S: f32 = 120.0;
/// Signal that has to be seen before anything is reported (s).
const LEARN_S: f32 = 10.0;
/// Logarithm over the highest level that one block may show: a jerk counts as this.
const LEVEL_MOST: f32 = 4.0;
/// Start of the filters (s).
const SETTLE_S: f32 = 0.25;
/// Least energy over the noise floor that counts: a reading that happens to be zero has no logarithm.
const LEAST: f32 = 1e-6;
/// Blocks in [`PAST_S`], at most: rates above carry a band above motion.
const PAST: usize = 64;

/// The test and its memory.
///
/// ```text
/// g <- g + a (ln energy - g), a = 1 - exp(-block / 0.4 s)       b = highest g up to 0.8 s ago, falling by e in 120 s
/// statistic = (exp(g - b) / 3)^2, the lower one of two blocks
/// ```
///
/// Hands and robots move at up to some 20 Hz. A sensor of 40 Hz sees nothing else, so that no band separates a slip
/// from motion, and a second sensor on another finger moves in a way of its own. What is left is the level: a slip is
/// reported where it lasts for some tenths of a second at three times the energy of all motion so far. The mean of the
/// logarithm knows no unit, and a jerk of a few readings moves it little, however strong it is. Until [`LEARN_S`] of
/// signal have been seen nothing is known of motion, and nothing is reported. A level that stays for as long is motion
/// after all.
///
/// Limits: a slip weaker than the strongest motion of the last minutes is not seen; one that goes on from the first sample on neither.
#[derive(Clone, Copy, Debug)]
pub(super) struct Level {
    share: f32,
    fading: f32,
    past: [f32; PAST],
    past_len: usize,
    learn_len: u32,
    settle_len: u32,
    mean: f32,
    highest: f32,
    /// Blocks since the beginning, up to [`Self::learn_len`], since the filters started, and of the alarm.
    seen: u32,
    settled: u32,
    alarmed: u32,
    place: usize,
    /// Ratio of the block before.
    before: f32,
}

impl Level {
    /// A test for blocks of `block_s` (s).
    pub(super) fn new(block_s: f32) -> Self {
        let blocks_hz = 1.0 / block_s;
        Self {
            share: -libm::expm1f(-block_s / MEAN_S),
            fading: block_s / FADES_S,
            past: [0.0; PAST],
            past_len: (samples(1e3 * PAST_S, blocks_hz) as usize).clamp(1, PAST),
            learn_len: samples(1e3 * LEARN_S, blocks_hz),
            settle_len: samples(1e3 * SETTLE_S, blocks_hz),
            mean: 0.0,
            highest: f32::NEG_INFINITY,
            seen: 0,
            settled: 0,
            alarmed: 0,
            place: 0,
            before: 0.0,
        }
    }

    /// The filters start afresh; what is known of motion stays.
    pub(super) fn start(&mut self) {
        self.settled = 0;
        self.alarmed = 0;
    }

    /// Whether too little was seen to decide.
    pub(super) fn is_learning(&self) -> bool {
        self.seen < self.learn_len
    }

    /// The least energy that is a slip now (unit squared); infinite while it learns.
    pub(super) fn smallest(&self) -> f32 {
        if self.is_learning() {
            f32::INFINITY
        } else {
            RATIO * libm::expf(self.highest + LOG_OF_NOISE)
        }
    }

    /// Takes the energy of a block over the noise floor, and that floor (unit squared). Gives the statistic: 1 and above is a slip.
    pub(super) fn step(&mut self, over_floor: f32, floor: f32) -> f32 {
        if self.settled < self.settle_len {
            self.settled += 1;
            return 0.0;
        }
        let log = libm::logf(over_floor.max(LEAST)) + libm::logf(floor.max(f32::MIN_POSITIVE));
        self.seen = self.seen.saturating_add(1).min(self.learn_len);
        let log =
            if self.highest > f32::NEG_INFINITY { log.min(self.highest + LEVEL_MOST) } else { log };
        let share = self.share.max(1.0 / self.seen as f32);
        self.mean += share * (log - self.mean);
        let mean = self.mean;
        let past = self.past.get_mut(self.place);
        let before = past.map_or(mean, |past| core::mem::replace(past, mean));
        self.place = if self.place + 1 < self.past_len { self.place + 1 } else { 0 };
        if (self.seen as usize) <= self.past_len {
            return 0.0;
        }
        if self.alarmed == 0 {
            self.highest = before.max(self.highest - self.fading);
        }
        if self.is_learning() {
            return 0.0;
        }
        let now = libm::expf((self.mean - self.highest).min(40.0)) / RATIO;
        let ratio = now.min(core::mem::replace(&mut self.before, now));
        self.alarmed = if ratio > 1.0 { self.alarmed + 1 } else { 0 };
        if self.alarmed > self.learn_len {
            (self.highest, self.alarmed) = (self.mean, 0);
        }
        ratio * ratio
    }
}

/// Logarithm of the mean over the geometric mean of the square of one reading of Gaussian noise: ln 2 + Euler's constant.
const LOG_OF_NOISE: f32 = 1.270_362_8;

#[cfg(test)]
mod tests {
    use super::Level;

    /// Squares of noise, uniform over two decades.
    fn noise(state: &mut u32) -> f32 {
        *state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let x = (*state >> 8) as f32 / (1 << 23) as f32 - 1.0;
        x * x
    }

    /// Ten minutes of motion by turns at 40 Hz with jerks; `slip` times the level of motion for 2 s, a second before the end.
    fn alarms(unit: f32, slip: f32) -> (u32, u32) {
        let (mut level, mut state) = (Level::new(0.025), 7);
        let (mut early, mut late, mut above) = (0, 0, false);
        for i in 0..24_000_u32 {
            let motion = if (i / 90) % 3 == 0 { 1.0 } else { 0.01 };
            let jerk = if i % 977 < 3 { 1e4 } else { 1.0 };
            let sliding = (23_880..23_960).contains(&i);
            let energy = noise(&mut state) * if sliding { slip } else { motion * jerk };
            let statistic = level.step(energy / 0.01, 0.01 * unit);
            let now = statistic > 1.0;
            if now && !above {
                if sliding { late += 1 } else { early += 1 }
            }
            above = now;
        }
        (early, late)
    }

    #[test]
    fn motion_by_turns_and_jerks_are_no_slip_and_three_times_its_rms_is() {
        for unit in [1.0, 1e-12, 1e9] {
            assert_eq!(alarms(unit, 9.0), (0, 1), "times {unit}");
            assert_eq!(alarms(unit, 0.1), (0, 0), "weaker than motion: not separable from it");
        }
    }

    #[test]
    fn nothing_is_reported_before_motion_is_known_and_a_new_level_becomes_motion() {
        let (mut level, mut state) = (Level::new(0.025), 3);
        let mut alarmed = 0;
        for i in 0..2000_u32 {
            let energy = noise(&mut state) * if i < 300 { 1.0 } else { 100.0 };
            let alarm = level.step(energy, 1.0) > 1.0;
            assert!(!alarm || i >= 400, "{i}");
            alarmed += u32::from(alarm);
        }
        assert_eq!(alarmed, 0, "the step came while it learned");
        for _ in 0..2000 {
            alarmed += u32::from(level.step(100.0 * 100.0 * noise(&mut state), 1.0) > 1.0);
        }
        assert!((300..500).contains(&alarmed), "10 s, then it is what goes on: {alarmed}");
        assert!(level.smallest() > 1e4 && level.smallest() < 1e5, "{}", level.smallest());
    }
}
