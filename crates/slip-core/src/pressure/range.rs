//! Residuals of the taxels in; the range that each of them went through in the last seconds, out.
//!
//! ```text
//! m <- m + (1 - exp(-dt / 30 ms)) (r - m)       high <- max(high', m), low <- min(low', m)
//! range = mean over the taxels of min(high - low, 6 known)                slip when range > known
//! ```
//!
//! high' and low' have come nearer to their middle by exp(-dt / 4 s). The mean m leaves what is below some 5 Hz: noise,
//! and the tremor of a hand (8 to 12 Hz), swing about a place and make no way. A slip carries the pattern on: residuals
//! go up at one taxel and down at the next as ridges and the edge of the contact pass, and the range grows with the way
//! where the residuals themselves, which the shape follows, do not. An object held still shows noise and creep, which
//! slows down: its range stands after some seconds, at a level that only a record of rest can give.

use super::shape::count;
use crate::units::Micros;

/// Time constant of the means (ms): slower than tremor, faster than a slip.
const SMOOTH_MS: f32 = 30.0;
/// Time constant with which a range is forgotten (ms).
const RANGE_MS: f32 = 4000.0;
/// A range of a shorter stretch than half of that is none: it has only begun to grow.
const SHORTEST: Micros = Micros(2_000_000);
/// Most that one taxel counts, in ranges at rest.
pub(super) const CLIP: f32 = 6.0;

/// The ranges of at most `N` taxels.
#[derive(Clone, Copy, Debug)]
pub(super) struct Range<const N: usize> {
    mean: [f32; N],
    high: [f32; N],
    low: [f32; N],
    begun: bool,
}

impl<const N: usize> Range<N> {
    pub(super) const fn new() -> Self {
        Self { mean: [0.0; N], high: [0.0; N], low: [0.0; N], begun: false }
    }

    /// Takes the residuals of the next frame, `dt_ms` (ms) after the one before.
    pub(super) fn step(&mut self, residual: &[f32], dt_ms: f32) {
        if !self.begun {
            self.begun = true;
            for ends in [&mut self.mean, &mut self.high, &mut self.low] {
                ends.iter_mut().zip(residual).for_each(|(end, r)| *end = *r);
            }
            return;
        }
        let follow = 1.0 - libm::expf(-dt_ms / SMOOTH_MS);
        let shrink = 0.5 * (1.0 - libm::expf(-dt_ms / RANGE_MS));
        let ends = self.high.iter_mut().zip(&mut self.low);
        for ((r, mean), (high, low)) in residual.iter().zip(&mut self.mean).zip(ends) {
            *mean += follow * (r - *mean);
            let nearer = shrink * (*high - *low);
            *high = (*high - nearer).max(*mean);
            *low = (*low + nearer).min(*mean);
        }
    }

    /// Mean range of the first `n` taxels, each limited to `most` (unit of the taxels).
    pub(super) fn mean(&self, n: usize, most: f32) -> f32 {
        let ends = self.high.iter().zip(&self.low).take(n);
        let ranges = ends.map(|(high, low)| (high - low).min(most));
        ranges.sum::<f32>() / count(n)
    }
}

/// The largest range of stretches of rest.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Widest {
    /// Largest range of this stretch, and of all stretches that are long enough for one.
    widest: f32,
    largest: f32,
    since: Option<Micros>,
    /// Length of the stretches before that were long enough, and of this one.
    before: Micros,
    now: Micros,
}

impl Widest {
    /// Begins another stretch of rest.
    pub(super) fn start(&mut self) {
        self.before = self.rest();
        (self.widest, self.since, self.now) = (0.0, None, Micros(0));
    }

    /// Takes the range at `t`.
    pub(super) fn push(&mut self, t: Micros, range: f32) {
        self.now = t.since(*self.since.get_or_insert(t));
        self.widest = self.widest.max(range);
        if self.now >= SHORTEST {
            self.largest = self.largest.max(self.widest);
        }
    }

    /// Length of the stretches that were long enough.
    pub(super) fn rest(&self) -> Micros {
        if self.now >= SHORTEST { self.before.plus(self.now) } else { self.before }
    }

    /// The largest range; `None` where no stretch was long enough, or nothing changed.
    pub(super) fn largest(&self) -> Option<f32> {
        Some(self.largest).filter(|range| *range > 0.0)
    }
}
