//! Eq. 1 as printed, n F v tan(sum cot(delta/s)), streaming in constant memory.
//!
//! | evaluator | format | error of S | for |
//! |---|---|---|---|
//! | [`LiteralSum<f64>`] | split, one digit width | 8 u sum h + tiny | the pipeline |
//! | [`LiteralSum<f32>`] | the same without any double | the same with u = 2^-24 | microcontrollers |
//! | [`PreciseSum<f64>`] | split, two digit widths | 2^-97 relative | references |
//!
//! u is the roundoff of the format, h = 1/r - cot r about r/3.
//!
//! **Reciprocal split.** For small ratios r = delta/s nearly all of cot r is 1/r = s/delta, which one division and its exact
//! remainder give to two digit widths. Only the small rest h(r) is computed in one. So S is known to a few
//! roundoffs of sum h instead of those of sum 1/r, which are larger by 3/r^2, and tan S loses so many digits less.
//!
//! **Bound.** B = 8 u sum h + u^2 (96 sum q + 3 R^2 n) + what irregularities steeper than 0.6 add, where q = s/delta and R is the
//! size from which the sum is reduced mod pi. h of one ratio is off by 3.5 u h (ratio, product, last sum and coefficient),
//! its sum by less than another u h; the quotients of two digit widths by 8 u^2 q; between two reductions the lower part of
//! the sum is at most 2 u R^2 and rounds with every addition. tan and the final products add at most 16 u. The doubles use the
//! tangent of the crate `libm`, which states an error below one last digit.

mod precise;
mod ratio;
mod split;

pub use precise::PreciseSum;
pub use split::LiteralSum;

use super::{
    Esc, Flag, Flags, Reading, Real, Trial,
    double::Double,
    enclosure::{Tangent, scaled},
};

/// What an evaluator knows of the sum when it is asked.
#[derive(Clone, Copy, Debug)]
pub(super) struct TangentSum<T> {
    pub(super) reading: Reading,
    pub(super) n: u32,
    pub(super) degenerate: u32,
    /// S itself, not reduced.
    pub(super) sum: T,
    pub(super) tangent: Tangent<T>,
    pub(super) sigma_s: T,
}

impl<T: Real> TangentSum<T> {
    /// n F v tan S; `None` where a number is not finite.
    pub(super) fn times(self, trial: &Trial<T>) -> Option<Esc<T>> {
        let scale = T::from_count(self.n) * trial.force_n * trial.speed_m_s;
        let t = self.tangent.value;
        let count = Double::from(T::from_count(self.n));
        let exact = t.times(count.times_one(trial.force_n).times_one(trial.speed_m_s));
        // Splitting a number near the largest one overflows; the plain product may still be in range.
        let value =
            if (exact.hi + exact.lo).is_finite() { exact.hi + exact.lo } else { scale * t.hi };
        if !(value.is_finite() && scale.is_finite()) {
            return None;
        }
        let (lo, hi) = scaled(self.tangent.lo, self.tangent.hi, scale);
        let (lo, hi) = (least(lo, value), least(-hi, -value));
        let hi = -hi;
        let flags = Flags::default()
            .with(Flag::PoleInside, self.tangent.pole)
            .with(Flag::SignUnknown, lo <= T::ZERO && hi >= T::ZERO)
            .with(Flag::NoInformation, self.sigma_s > T::ONE || !self.sigma_s.is_finite())
            .with(Flag::Degenerate, self.degenerate > 0);
        Some(Esc {
            reading: self.reading,
            value,
            lo,
            hi,
            n: self.n,
            degenerate: self.degenerate,
            sum: self.sum,
            condition: self.sum.abs() * ((T::ONE + t.hi * t.hi) / t.hi).abs(),
            sigma_s: self.sigma_s,
            flags,
        })
    }
}

fn least<T: Real>(a: T, b: T) -> T {
    if a < b { a } else { b }
}
