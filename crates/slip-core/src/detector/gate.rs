//! Band energies of the motion reference in; what the robot's own motion may add to the floor of each band out.
//!
//! ```text
//! floor_b = 1 + gain_b r_b       r_b <- max(energy of the reference in the block, r_b exp(-block / 3 ms))
//! ```
//!
//! in units of the quiet floors. `gain` is the energy that motion leaves in a band of the stylus over the energy it leaves in
//! the same band of the reference, times what it takes to keep the alarm threshold above all of it: with a
//! threshold h on energy over floor, motion may show h gain times as strongly at the stylus as at the reference. The peak holds
//! over the time between the peaks of two filters, so that the front of a tap does not slip through.
//!
//! A knock reaches stylus and reference by ways of its own, so that the gain of the robot's motion says nothing of it. It shows as a jump of the
//! reference: for some time after a peak of [`KNOCK`] times its mean, and after motion has begun, the gain is [`KNOCK_GAIN`] times as high.

use super::{
    config::{BANDS, FIRST_OCTAVE},
    lanes::{LANES, samples},
};

/// How the motion of the robot is told from slip.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct GateConfig {
    /// What motion adds to the floor of shear, vibration and the four other bands, over the energy of the reference (stylus
    /// unit squared over reference unit squared). The defaults fit a reference that shows motion about as the stylus does,
    /// within a factor of 1.5 in amplitude; another needs calibration.
    pub gain: [f32; BANDS],
    /// Reference over its noise (rms) that is motion.
    pub motion_sigmas: f32,
    /// How long motion is taken to last after the reference has shown it (ms).
    pub hold_ms: f32,
    /// Times the quiet floor is raised in commanded motion without a reference.
    pub blind_margin: f32,
}

impl Default for GateConfig {
    fn default() -> Self {
        Self {
            gain: [0.5, 0.5, 0.5, 0.5, 0.5, 0.7],
            motion_sigmas: 6.0,
            hold_ms: 300.0,
            blind_margin: 16.0,
        }
    }
}

/// Memory of the highest block of the reference (s).
const PEAK_S: f32 = 3e-3;

/// Peak of a band of the reference over its mean that is a knock.
const KNOCK: f32 = 5.0;
/// What a knock may show more at the stylus than motion does (energy).
const KNOCK_GAIN: f32 = 8.0;
/// How long a knock rings (s).
const RINGS_S: f32 = 0.04;
/// Memory of the mean peak (s).
const MEAN_S: f32 = 0.01;
/// So long after it (s) less than this share of its height is left of a knock; what has more is motion.
const FADED_S: f32 = 0.015;
const LEFT: f32 = 0.3;

/// The gate and its memory.
#[derive(Clone, Copy, Debug)]
pub(super) struct Gate {
    config: GateConfig,
    /// Gain of each band between energies scaled by their quiet floors.
    gain: [f32; BANDS],
    peak: [f32; BANDS],
    peak_decay: f32,
    /// Mean of the peak, its share of a block, and blocks until the last knock no longer rings.
    mean: [f32; BANDS],
    mean_share: f32,
    rings: u32,
    rings_len: u32,
    faded_len: u32,
    /// The highest peak since the knock, in the bands that it shows in.
    struck: f32,
}

impl Gate {
    /// A gate for blocks of `block_s` (s).
    pub(super) fn new(config: GateConfig, block_s: f32) -> Self {
        Self {
            config,
            gain: [0.0; BANDS],
            peak: [0.0; BANDS],
            peak_decay: libm::expf(-block_s / PEAK_S),
            mean: [0.0; BANDS],
            mean_share: -libm::expm1f(-block_s / MEAN_S),
            rings: 0,
            rings_len: samples(1e3 * RINGS_S, 1.0 / block_s),
            faded_len: samples(1e3 * (RINGS_S - FADED_S), 1.0 / block_s),
            struck: 0.0,
        }
    }

    /// Takes new quiet floors (unit squared).
    pub(super) fn rescale(&mut self, stylus: &[f32; BANDS]) {
        self.gain = core::array::from_fn(|b| (self.config.gain[b] / stylus[b]).min(1e30));
        self.start();
    }

    /// Begins another stretch of motion.
    pub(super) fn start(&mut self) {
        self.peak = [0.0; BANDS];
        self.mean = [0.0; BANDS];
        (self.rings, self.struck) = (self.rings_len, 0.0);
    }

    /// Whether a knock rings, or motion has just begun.
    #[inline]
    pub(super) fn rings(&self) -> bool {
        self.rings > 0
    }

    /// The floor of each band that a block alone gives, without knock and peak: what is held longer would show the
    /// reference late.
    #[inline]
    pub(super) fn instant(
        &self,
        sums: &[f32; LANES],
        per_sample: f32,
        learned: &[f32; BANDS],
    ) -> [f32; BANDS] {
        core::array::from_fn(|b| 1.0 + learned[b] * self.gain[b] * sums[b] * per_sample)
    }

    /// Takes the sum of squares of each band of the reference (unit squared) over a block of `1 / per_sample` samples: the floor
    /// of each band over its quiet floor.
    #[inline]
    pub(super) fn block(
        &mut self,
        sums: &[f32; LANES],
        per_sample: f32,
        learned: &[f32; BANDS],
    ) -> [f32; BANDS] {
        let (mut knocks, mut level) = (false, 0.0);
        for (b, sum) in sums.iter().enumerate().take(BANDS) {
            let energy = sum * per_sample;
            self.peak[b] = energy.max(self.peak[b] * self.peak_decay);
            if b >= FIRST_OCTAVE + 2 {
                knocks |= self.peak[b] > KNOCK * self.mean[b];
                level += self.peak[b];
            }
            self.mean[b] += self.mean_share * (self.peak[b] - self.mean[b]);
        }
        self.struck = if self.rings > 0 { self.struck.max(level) } else { level };
        self.rings = if knocks { self.rings_len } else { self.rings.saturating_sub(1) };
        if self.rings == self.faded_len && level > LEFT * self.struck {
            self.rings = 0;
        }
        let over = if self.rings > 0 { KNOCK_GAIN } else { 1.0 };
        core::array::from_fn(|b| 1.0 + over * learned[b] * self.gain[b] * self.peak[b])
    }
}
