//! The cumulative sum of log-likelihood ratios over the bands that do not overlap.
//!
//! A band of width B gives n = 2 B T independent readings in a block of T. With z the energy over the floor, the log-likelihood
//! ratio of a rise by the factor rho is
//!
//! ```text
//! l = n/2 (z (1 - 1/rho) - ln rho)      S <- max(0, S + sum over bands of min(l, clip))      slip when S > h
//! ```
//!
//! E. S. Page, Biometrika 41 (1954); clipping bounds what one outlier can do. Beside the energy it runs while the robot moves; in a still scene
//! the energy of shear and vibration is as fast and forgets a slip sooner.

use super::{
    config::{BANDS, FIRST_OCTAVE},
    test::{Block, SequentialTest},
};

/// The largest log-likelihood ratio that one block of one band may add.
const CLIP: f32 = 12.0;

/// The sum over its threshold stays below this, so that a long slip is forgotten soon after its end.
const MOST: f32 = 1.5;

/// The test.
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
