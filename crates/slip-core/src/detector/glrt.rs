//! The windowed generalised likelihood ratio over the bands that do not overlap.
//!
//! Over the last k blocks (k = 4, 8, 16, 32, 64) a band with n independent readings a block and mean z of energy over floor has
//!
//! ```text
//! l_k = sum over bands of k n/2 (z - 1 - ln z) where z > 1, else 0      slip when max over k of l_k > h
//! ```
//!
//! the likelihood ratio of the best fitting rise against none. T. L. Lai, J. R. Statist. Soc. B 57 (1995).

use super::{
    config::BANDS,
    cusum::octaves,
    test::{Block, SequentialTest},
};

const LONGEST: usize = 64;
const WINDOWS: [usize; 5] = [4, 8, 16, 32, LONGEST];
/// The largest z that one block may contribute.
const CLIP: f32 = 1e4;

/// The test.
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
            core::array::from_fn(|b| (block.energy[b] / block.floor[b]).min(CLIP));
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
