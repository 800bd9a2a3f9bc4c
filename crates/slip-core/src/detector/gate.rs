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

use super::{config::BANDS, lanes::LANES};

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

/// The gate and its memory.
#[derive(Clone, Copy, Debug)]
pub(super) struct Gate {
    config: GateConfig,
    /// Gain of each band between energies scaled by their quiet floors.
    gain: [f32; BANDS],
    peak: [f32; BANDS],
    peak_decay: f32,
}

impl Gate {
    /// A gate for blocks of `block_s` (s).
    pub(super) fn new(config: GateConfig, block_s: f32) -> Self {
        Self {
            config,
            gain: [0.0; BANDS],
            peak: [0.0; BANDS],
            peak_decay: libm::expf(-block_s / PEAK_S),
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
    }

    /// Takes the sum of squares of each band of the reference (unit squared) over a block of `1 / per_sample` samples: the floor
    /// of each band over its quiet floor.
    #[inline]
    pub(super) fn block(&mut self, sums: &[f32; LANES], per_sample: f32) -> [f32; BANDS] {
        let mut floor = [1.0; BANDS];
        for b in 0..BANDS {
            self.peak[b] = (sums[b] * per_sample).max(self.peak[b] * self.peak_decay);
            floor[b] += self.gain[b] * self.peak[b];
        }
        floor
    }
}
