//! Blocks of band energies in, a statistic over its threshold out: the one trait of all sequential tests, and the tests.

use super::{
    config::{BANDS, FIRST_OCTAVE, STILL_BANDS, VIBRATION},
    lanes::samples,
};

/// What one block of samples (half a millisecond) showed, in units of the sensor noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Block {
    /// Mean energy of each band, own motion taken off.
    pub energy: [f32; BANDS],
    /// What noise and motion may have caused of it.
    pub floor: [f32; BANDS],
    /// The robot moves, so that the two lower octaves and the cumulative sum decide too. In a still scene shear and vibration, which cover
    /// these, are enough.
    pub moving: bool,
}

/// A sequential test for slip.
pub trait SequentialTest {
    /// Takes the next block; gives the statistic over its threshold: 1 and above is a slip.
    fn step(&mut self, block: &Block) -> f32;

    /// Starts afresh, as at rest.
    fn reset(&mut self);
}

/// Mean energy over mean floor of each band against its threshold:
/// `e <- e + a (energy - e)`, `f <- f + a (floor - f)`, a = 1 - exp(-block/tau) with a tau for each band, statistic max e / (f h).
#[derive(Clone, Copy, Debug)]
pub struct EnergyTest {
    weight: [f32; BANDS],
    energy: [f32; BANDS],
    floor: [f32; BANDS],
    per_threshold: [f32; BANDS],
}

impl EnergyTest {
    /// A test with the time constants `tau_s` (s) for blocks of `block_s` (s); bands with a threshold of infinity are left out.
    #[must_use]
    pub fn new(tau_s: [f32; BANDS], block_s: f32, thresholds: [f32; BANDS]) -> Self {
        Self {
            weight: tau_s.map(|tau_s| -libm::expm1f(-block_s / tau_s)),
            energy: [1.0; BANDS],
            floor: [1.0; BANDS],
            per_threshold: thresholds.map(|threshold| 1.0 / threshold),
        }
    }

    /// Which bands are not left out.
    pub(super) fn has_bands(&self) -> [bool; BANDS] {
        self.per_threshold.map(|reciprocal| reciprocal > 0.0)
    }

    /// The same of vibration and the two highest octaves, the most of those that are not left out.
    #[inline]
    pub(super) fn sliding(&self) -> f32 {
        let over = |b: usize| {
            if self.per_threshold[b] > 0.0 { self.energy[b] / self.floor[b] } else { 0.0 }
        };
        over(VIBRATION).max(over(BANDS - 2).max(over(BANDS - 1)))
    }

    /// Mean energy of each band over its floor.
    #[must_use]
    #[inline]
    pub fn over_floor(&self) -> [f32; BANDS] {
        core::array::from_fn(|b| self.energy[b] / self.floor[b])
    }
}

impl SequentialTest for EnergyTest {
    #[inline]
    fn step(&mut self, block: &Block) -> f32 {
        let mut over = [0.0_f32; BANDS];
        for (b, over) in over.iter_mut().enumerate() {
            self.energy[b] += self.weight[b] * (block.energy[b] - self.energy[b]);
            self.floor[b] += self.weight[b] * (block.floor[b] - self.floor[b]);
            *over = self.energy[b] / self.floor[b] * self.per_threshold[b];
        }
        let decides = over.into_iter().zip(STILL_BANDS);
        decides.fold(
            0.0,
            |most, (over, still)| if still || block.moving { over.max(most) } else { most },
        )
    }

    fn reset(&mut self) {
        self.energy = [1.0; BANDS];
        self.floor = [1.0; BANDS];
    }
}

// The cumulative sum of log-likelihood ratios over the bands that do not overlap.

/// The largest log-likelihood ratio that one block of one band may add.
const CLIP: f32 = 12.0;

/// The sum over its threshold stays below this, so that a long slip is forgotten soon after its end.
const MOST: f32 = 1.5;

/// The test.
///
/// A band of width B gives n = 2 B T independent readings in a block of T. With z the energy over the floor, the log-likelihood
/// ratio of a rise by the factor rho is
///
/// ```text
/// l = n/2 (z (1 - 1/rho) - ln rho)      S <- max(0, S + sum over bands of min(l, clip))      slip when S > h
/// ```
///
/// E. S. Page, Biometrika 41 (1954); clipping bounds what one outlier can do. Beside the energy it runs while the robot moves; in a still scene
/// the energy of shear and vibration is as fast and forgets a slip sooner.
#[derive(Clone, Copy, Debug)]
pub struct Cusum {
    slope: [f32; BANDS],
    offset: [f32; BANDS],
    /// Whether it runs in still scenes too.
    still: bool,
    sum: f32,
    most: f32,
    per_threshold: f32,
}

impl Cusum {
    /// A test for a rise by `ratio` with threshold `threshold`; `readings` are the independent readings a block has of each
    /// band, 0 for bands to be left out.
    #[must_use]
    pub fn new(ratio: f32, threshold: f32, readings: [f32; BANDS]) -> Self {
        let log = libm::logf(ratio);
        let half = octaves(readings).map(|n| 0.5 * n);
        Self {
            slope: half.map(|n| n * (1.0 - 1.0 / ratio)),
            offset: half.map(|n| n * log),
            still: false,
            sum: 0.0,
            most: MOST * threshold,
            per_threshold: 1.0 / threshold,
        }
    }
}

impl Cusum {
    /// The same for still scenes too, where no other test decides.
    #[must_use]
    pub fn in_every_scene(self) -> Self {
        Self { still: true, ..self }
    }

    /// The sum over its threshold.
    #[inline]
    pub(super) fn over_threshold(&self) -> f32 {
        self.sum * self.per_threshold
    }

    /// The sum (log-likelihood ratio).
    #[must_use]
    pub fn sum(&self) -> f32 {
        self.sum
    }
}

impl SequentialTest for Cusum {
    #[inline]
    fn step(&mut self, block: &Block) -> f32 {
        if !(block.moving || self.still) {
            self.sum = 0.0;
            return 0.0;
        }
        let mut gain = 0.0;
        for b in FIRST_OCTAVE..BANDS {
            let z = block.energy[b] / block.floor[b];
            gain += (z * self.slope[b] - self.offset[b]).min(CLIP);
        }
        self.sum = (self.sum + gain).max(0.0).min(self.most);
        self.sum * self.per_threshold
    }

    fn reset(&mut self) {
        self.sum = 0.0;
    }
}

/// Readings of the bands that do not overlap; none of the others.
pub(super) fn octaves(readings: [f32; BANDS]) -> [f32; BANDS] {
    core::array::from_fn(|b| if b < FIRST_OCTAVE { 0.0 } else { readings[b] })
}

// The windowed generalised likelihood ratio over the bands that do not overlap.

const LONGEST: usize = 64;
const WINDOWS: [usize; 5] = [4, 8, 16, 32, LONGEST];
/// The largest z that one block may contribute.
const GLRT_CLIP: f32 = 1e4;

/// The test.
///
/// Over the last k blocks (k = 4, 8, 16, 32, 64) a band with n independent readings a block and mean z of energy over floor has
///
/// ```text
/// l_k = sum over bands of k n/2 (z - 1 - ln z) where z > 1, else 0      slip when max over k of l_k > h
/// ```
///
/// the likelihood ratio of the best fitting rise against none. T. L. Lai, J. R. Statist. Soc. B 57 (1995).
#[derive(Clone, Copy, Debug)]
pub struct Glrt {
    half: [f32; BANDS],
    ring: [[f32; BANDS]; LONGEST],
    sums: [[f32; BANDS]; WINDOWS.len()],
    at: usize,
    per_threshold: f32,
}

impl Glrt {
    /// A test with threshold `threshold`; `readings` as for [`super::Cusum::new`].
    #[must_use]
    pub fn new(threshold: f32, readings: [f32; BANDS]) -> Self {
        let mut test = Self {
            half: octaves(readings).map(|n| 0.5 * n),
            ring: [[1.0; BANDS]; LONGEST],
            sums: [[0.0; BANDS]; WINDOWS.len()],
            at: 0,
            per_threshold: 1.0 / threshold,
        };
        test.reset();
        test
    }

    /// Sums of the ring as they should be: running sums drift.
    fn renew(&mut self) {
        for (sum, window) in self.sums.iter_mut().zip(WINDOWS) {
            *sum = [0.0; BANDS];
            for back in 1..=window {
                let z = self.ring[(self.at + LONGEST - back) % LONGEST];
                for b in 0..BANDS {
                    sum[b] += z[b];
                }
            }
        }
    }
}

impl SequentialTest for Glrt {
    #[inline]
    fn step(&mut self, block: &Block) -> f32 {
        let z: [f32; BANDS] =
            core::array::from_fn(|b| (block.energy[b] / block.floor[b]).min(GLRT_CLIP));
        let mut statistic = 0.0_f32;
        for (sum, window) in self.sums.iter_mut().zip(WINDOWS) {
            let oldest = self.ring[(self.at + LONGEST - window) % LONGEST];
            #[expect(clippy::cast_precision_loss, reason = "at most 64")]
            let len = window as f32;
            let mut l = 0.0;
            for b in 0..BANDS {
                sum[b] += z[b] - oldest[b];
                let mean = sum[b] / len;
                if mean > 1.0 {
                    l += len * self.half[b] * (mean - 1.0 - libm::logf(mean));
                }
            }
            statistic = statistic.max(l);
        }
        self.ring[self.at % LONGEST] = z;
        self.at = (self.at + 1) % LONGEST;
        if self.at == 0 {
            self.renew();
        }
        statistic * self.per_threshold
    }

    fn reset(&mut self) {
        self.ring = [[1.0; BANDS]; LONGEST];
        self.at = 0;
        self.renew();
    }
}

// The energy of each block in, how far its mean logarithm stands above the highest level that went on before out: the
// test for rates that carry no band above motion.

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
/// statistic = (exp(g - b) / 3)^2
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
        #[expect(clippy::cast_precision_loss, reason = "at most some thousand blocks")]
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
        let ratio = libm::expf((self.mean - self.highest).min(40.0)) / RATIO;
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
mod level_tests {
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

#[cfg(test)]
mod energy_tests {
    use super::{BANDS, Block, EnergyTest, SequentialTest};

    #[test]
    fn a_band_that_the_rate_does_not_carry_makes_nothing_gross() {
        let all = EnergyTest::new([0.005; BANDS], 5e-4, [10.0; BANDS]);
        let low = EnergyTest::new(
            [0.005; BANDS],
            5e-4,
            core::array::from_fn(|b| if b < BANDS - 2 { 10.0 } else { f32::INFINITY }),
        );
        let mut energy = [1.0; BANDS];
        energy[BANDS - 1] = 1e6;
        let block = Block { energy, floor: [1.0; BANDS], moving: false };
        for (mut test, gross) in [(all, true), (low, false)] {
            test.step(&block);
            assert_eq!(test.sliding() > 25.0, gross);
        }
    }
}
