//! The sequential test of the detector: one Shiryaev-Roberts sum, whose value is a time and whose threshold is the wanted
//! time between false alarms.
//!
//! A band of width B has n = 2 B T independent readings in a block of T seconds. With z its energy over its floor, the
//! log-likelihood ratio of a rise to rho times the slack kappa against "at most kappa times the floor" is
//!
//! ```text
//! l_b = min(5, n_b/2 (z_b / kappa_b (1 - 1/rho) - ln rho))                                  rho = 6
//! l_J = min(12, sum over the octaves of min(6, n_b/4 (z_b / kappa_J (1 - 1/rho) - ln rho)))  while the robot moves
//! M_i <- min(e^2 A, exp(l_i) (M_i + T))      M = mean of the M_i      a slip while M >= A, over when M < A / 400 for the release time
//! ```
//!
//! For Gaussian noise of energy at most kappa times the floor, E[exp(l) | past] <= 1, so E[M] grows by at most T with
//! each block, and a stop at M >= A comes after A seconds on average or later (optional stopping). The mean over components
//! keeps that however they depend on each other. A. N. Shiryaev, Theory Probab. Appl. 8 (1963); S. W. Roberts,
//! Technometrics 8 (1966); M. Pollak, Ann. Statist. 13 (1985).
//!
//! Limits. The promise is for Gaussian noise. Heavier tails are bounded by the clip (three blocks are needed at least), the slack,
//! the guard against isolated samples and a calibration; how often each law of noise alarms is in docs/results/detection.md.
//! Tests: `agrees_with_the_formula`, `gaussian_noise_keeps_the_interval`.

use super::config::{BANDS, DetectorConfig, FIRST_OCTAVE};

/// Components of the sum: each band, and the octaves together.
pub const COMPONENTS: usize = BANDS + 1;
/// Place of the octaves together.
const JOINT: usize = BANDS;
/// Lanes of the arithmetic: a whole number of vectors. The last is empty.
const LANES: usize = 8;

/// Components that decide while the robot stands: shear, vibration, and the two highest octaves, which a hum of the mains
/// leaves free. In motion all decide.
const STILL: [bool; COMPONENTS] = [true, true, false, false, true, true, false];
const AT_REST: [usize; 4] = [0, 1, 4, 5];

/// Rise over the slack that the sum looks for.
const RATIO: f32 = 6.0;
const LOG_RATIO: f32 = 1.791_759_5;
/// Most log-likelihood (nats) that a block adds to a component, of one octave to the joint one, and of that in all.
const CLIP: f32 = 5.0;
const OCTAVE_CLIP: f32 = 6.0;
const JOINT_CLIP: f32 = 12.0;
/// Share of the likelihood of the octaves together: they and neighbouring blocks are not independent.
const TEMPER: f32 = 0.5;
/// What is remembered of a component is at most this times the interval, so that a long slip is soon forgotten: e^2.
const MOST: f32 = 7.389_056;
/// Share of the interval below which the evidence of a slip is gone: e^-6.
pub(super) const GONE: f32 = 0.002_478_752;
/// Log-likelihood with which a component forgets all (nats).
const FORGETS: f32 = 80.0;
/// Share of the log-evidence for a slip that motion may reach.
const NEAR: f32 = 0.6;

/// What one block of samples (half a millisecond) showed, in units of the sensor noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Block {
    /// Mean energy of each band.
    pub energy: [f32; BANDS],
    /// What noise and motion may have caused of it; 1 while the robot stands.
    pub floor: [f32; BANDS],
    /// Whether the robot moves.
    pub moving: bool,
}

/// Coefficients of a scene: l = slope z - offset of each component, and its share of the mean.
#[derive(Clone, Copy, Debug)]
struct Law {
    slope: [f32; LANES],
    offset: [f32; LANES],
    share: [f32; LANES],
    /// The same of each octave within the joint component.
    joint_slope: [f32; BANDS],
    joint_offset: [f32; BANDS],
}

impl Law {
    fn new(
        slack: &[f32; COMPONENTS],
        readings: &[f32; BANDS],
        decides: &[bool; COMPONENTS],
    ) -> Self {
        let slope = |n: f32, slack: f32| 0.5 * n * (1.0 - 1.0 / RATIO) / slack;
        let of_octave = |b: usize| if b < FIRST_OCTAVE { 0.0 } else { readings[b] };
        let mut law = Self {
            slope: [0.0; LANES],
            offset: [0.0; LANES],
            share: [0.0; LANES],
            joint_slope: core::array::from_fn(|b| slope(TEMPER * of_octave(b), slack[JOINT])),
            joint_offset: core::array::from_fn(|b| 0.5 * TEMPER * of_octave(b) * LOG_RATIO),
        };
        for (b, readings) in readings.iter().enumerate() {
            law.slope[b] = slope(*readings, slack[b]);
            law.offset[b] = 0.5 * readings * LOG_RATIO;
            law.share[b] = f32::from(decides[b] && *readings > 0.0);
        }
        law.offset[JOINT] = law.joint_offset.iter().sum();
        law.share[JOINT] = f32::from(decides[JOINT] && law.offset[JOINT] > 0.0);
        for i in 0..LANES {
            if law.share[i] == 0.0 {
                // What does not decide remembers nothing.
                (law.slope[i], law.offset[i]) = (0.0, FORGETS);
            }
        }
        let count: f32 = law.share.iter().sum();
        law.share = law.share.map(|share| share / count.max(1.0));
        law
    }
}

/// The sum and its memory.
#[derive(Clone, Copy, Debug)]
pub struct AlarmSum {
    still: Law,
    moving: Law,
    interval_s: f32,
    block_s: f32,
    /// Evidence of each component (s).
    evidence_s: [f32; LANES],
    /// Sum of the log-likelihood ratios of each since it was last at 0, and blocks in it; of motion only.
    gained: [f32; LANES],
    blocks: [f32; LANES],
    log_near: f32,
}

impl AlarmSum {
    /// A sum over blocks of `block_s` (s) with `readings` independent readings of each band, 0 for bands that the rate does not carry.
    #[must_use]
    pub fn new(config: &DetectorConfig, readings: &[f32; BANDS], block_s: f32) -> Self {
        Self {
            still: Law::new(&config.slack_still, readings, &STILL),
            moving: Law::new(&config.slack_moving, readings, &[true; COMPONENTS]),
            interval_s: config.interval_s,
            block_s,
            evidence_s: [0.0; LANES],
            gained: [0.0; LANES],
            blocks: [0.0; LANES],
            log_near: NEAR * libm::logf(config.interval_s / block_s).max(1.0),
        }
    }

    /// Starts afresh, as at rest.
    pub fn reset(&mut self) {
        self.evidence_s = [0.0; LANES];
        (self.gained, self.blocks) = ([0.0; LANES], [0.0; LANES]);
    }

    /// Evidence of each component (s).
    #[must_use]
    pub fn evidence_s(&self) -> [f32; COMPONENTS] {
        core::array::from_fn(|i| self.evidence_s[i])
    }

    /// Which components have a part in the scene.
    #[must_use]
    pub fn decides(&self, moving: bool) -> [bool; COMPONENTS] {
        let law = if moving { &self.moving } else { &self.still };
        core::array::from_fn(|i| law.share[i] > 0.0)
    }

    /// Takes the next block; gives the evidence of all (s) over the interval: 1 and above is a slip.
    #[inline]
    pub fn step(&mut self, block: &Block) -> f32 {
        if block.moving { self.step_moving(block) } else { self.step_still(block) }
    }

    #[inline]
    fn step_still(&mut self, block: &Block) -> f32 {
        let law = &self.still;
        let grown = AT_REST.map(|i| {
            let gain = (law.slope[i] * block.energy[i] - law.offset[i]).min(CLIP);
            exp(gain) * (self.evidence_s[i] + self.block_s)
        });
        let most_s = MOST * self.interval_s;
        self.evidence_s = [0.0; LANES];
        let mut sum_s = 0.0;
        for (i, evidence_s) in AT_REST.into_iter().zip(grown) {
            sum_s += law.share[i] * evidence_s;
            self.evidence_s[i] = evidence_s.min(most_s);
        }
        sum_s / self.interval_s
    }

    #[inline(never)]
    fn step_moving(&mut self, block: &Block) -> f32 {
        let law = &self.moving;
        let (mut gains, mut joint) = ([0.0; LANES], 0.0);
        for (b, (energy, floor)) in block.energy.iter().zip(&block.floor).enumerate() {
            let z = energy / floor;
            gains[b] = (law.slope[b] * z - law.offset[b]).min(CLIP);
            joint += (law.joint_slope[b] * z - law.joint_offset[b]).min(OCTAVE_CLIP);
        }
        gains[JOINT] = joint.min(JOINT_CLIP);
        for ((gained, blocks), gain) in self.gained.iter_mut().zip(&mut self.blocks).zip(&gains) {
            *gained = (*gained + gain).max(0.0);
            *blocks = if *gained > 0.0 { *blocks + 1.0 } else { 0.0 };
        }
        let share = law.share;
        self.grow(&gains, &share)
    }

    /// Takes the log-likelihood ratios of a block; gives the mean evidence over the interval.
    #[inline]
    fn grow(&mut self, gains: &[f32; LANES], share: &[f32; LANES]) -> f32 {
        let most_s = MOST * self.interval_s;
        let mut sum_s = 0.0;
        for ((evidence_s, gain), share) in self.evidence_s.iter_mut().zip(gains).zip(share) {
            let now_s = exp(*gain) * (*evidence_s + self.block_s);
            sum_s += share * now_s;
            *evidence_s = now_s.min(most_s);
        }
        sum_s / self.interval_s
    }

    /// Whether a component has passed that share of the log-evidence: else all of [`Self::unexplained`] is 1.
    #[inline]
    pub(super) fn is_near(&self) -> bool {
        self.gained.iter().any(|gained| *gained > self.log_near)
    }

    /// Times the floor of motion would have to be higher for each component to stay below [`NEAR`] of the log-evidence for a slip; 1 where
    /// it does. With S the sum of the N log-likelihood ratios since it was last at 0, c the offset and S* that share: (S + N c) / (S* + N c), as l + c is
    /// proportional to the energy over the floor.
    #[must_use]
    pub(super) fn unexplained(&self) -> [f32; COMPONENTS] {
        core::array::from_fn(|i| {
            let noise = self.blocks[i] * self.moving.offset[i];
            let factor = (self.gained[i] + noise) / (self.log_near + noise);
            if self.moving.share[i] > 0.0 { factor.max(1.0) } else { 1.0 }
        })
    }

    /// Energies over the floors of motion (`over_floor`) over those that are evidence neither for a slip nor against it, the highest.
    #[must_use]
    pub(super) fn strength(&self, over_floor: &[f32; BANDS]) -> f32 {
        let law = &self.moving;
        (0..BANDS)
            .filter(|b| law.share[*b] > 0.0)
            .fold(0.0, |most, b| f32::max(most, over_floor[b] * law.slope[b] / law.offset[b]))
    }

    /// Energy of each band over its floor that, if it lasts, is a slip within `within_s` (s); infinite for bands that have no part in
    /// the scene.
    #[must_use]
    pub fn smallest(&self, moving: bool, within_s: f32) -> [f32; BANDS] {
        let law = if moving { &self.moving } else { &self.still };
        let blocks = libm::floorf(within_s / self.block_s).max(3.0);
        core::array::from_fn(|b| {
            let log = libm::logf(self.interval_s / (self.block_s * law.share[b]));
            if law.share[b] > 0.0 {
                (law.offset[b] + log / blocks) / law.slope[b]
            } else {
                f32::INFINITY
            }
        })
    }
}

/// e^x for x up to 80, within 4e-7 down to -80 and 0 below: the series of the rest after the nearest power of two. The C detector has the same.
#[inline]
fn exp(x: f32) -> f32 {
    /// Adding and taking off 1.5 times 2^23 rounds to the nearest whole number.
    const ROUND: f32 = 12_582_912.0;
    let x = x.max(-80.0);
    let shifted = x * core::f32::consts::LOG2_E + ROUND;
    let y = x - (shifted - ROUND) * core::f32::consts::LN_2;
    let series = 1.0
        + y * (1.0
            + y * (0.5
                + y * (1.0 / 6.0 + y * (1.0 / 24.0 + y * (1.0 / 120.0 + y * (1.0 / 720.0))))));
    let power = shifted.to_bits().wrapping_sub(ROUND.to_bits()).wrapping_add(127) << 23;
    series * f32::from_bits(power)
}

#[cfg(test)]
mod tests;
