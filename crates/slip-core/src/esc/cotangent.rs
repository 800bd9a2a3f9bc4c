//! Cotangent and tangent of angles of two digit widths, by the reciprocal split.
//!
//! cot r = 1/r - h(r) with h(r) = r/3 + r^3/45 + ..., whose terms are all positive: nothing cancels. The relative
//! error of every function here is below 300 u^2 (u: roundoff), as the tests find and the bounds take with a margin.

use super::{
    double::{Double, two_prod, two_sum},
    real::Real,
};

/// Up to here [`Real::SINGLE_TERMS`] and [`Real::DOUBLE_TERMS`] reach their digits.
pub(super) const SERIES_UP_TO: f32 = 0.6;
const QUARTER_PI: f32 = core::f32::consts::FRAC_PI_4;

impl<T: Real> Double<T> {
    /// h of a number from 0 to 0.6. The terms that stay below the last digit of the first part need one part only.
    pub(super) fn h(self) -> Self {
        let z = self.times(self);
        let mut tail = T::ZERO;
        for term in T::H.iter().take(T::DOUBLE_TERMS).skip(T::SINGLE_TERMS).rev() {
            tail = tail * z.hi + term[0];
        }
        let mut p = Self::from(tail);
        for term in T::H.iter().take(T::SINGLE_TERMS).rev() {
            p = p.times(z).plus(Self { hi: term[0], lo: term[1] });
        }
        self.times(p)
    }

    /// tan of a number from -pi/4 to pi/4.
    pub(super) fn tan_first(self) -> Self {
        if self.hi < T::ZERO {
            return self.neg().tan_first().neg();
        }
        if self.hi <= T::of(SERIES_UP_TO) {
            let rest = Self::from(T::ONE).minus(self.times(self.h()));
            return self.over(rest);
        }
        Self::from(T::ONE).over(self.cot_first())
    }

    /// cot of a number from 0 to pi/4, zero excluded.
    fn cot_first(self) -> Self {
        if self.hi <= T::of(SERIES_UP_TO) {
            return Self::from(T::ONE).over(self).minus(self.h());
        }
        let c = self.half().cot_first();
        c.times(c).plus_one(-T::ONE).over(c).half()
    }

    /// cot of a number from -pi/2 to pi/2, zero excluded.
    pub(super) fn cot(self) -> Self {
        if self.hi < T::ZERO {
            return self.neg().cot().neg();
        }
        if self.hi <= T::of(QUARTER_PI) { self.cot_first() } else { self.complement().tan_first() }
    }

    /// tan of a number from -pi/2 to pi/2, the ends excluded.
    pub(super) fn tan(self) -> Self {
        if self.hi < T::ZERO {
            return self.neg().tan().neg();
        }
        if self.hi <= T::of(QUARTER_PI) {
            return self.tan_first();
        }
        let rest = self.complement();
        if rest.hi < T::ZERO { rest.neg().cot_first().neg() } else { rest.cot_first() }
    }

    /// pi/2 - x.
    pub(super) fn complement(self) -> Self {
        let half = T::of(0.5);
        let [first, second, third] = T::PI;
        let (d, e) = two_sum(first * half, -self.hi);
        Self { hi: d, lo: e }
            .plus(Self::from(second * half).plus_one(-self.lo))
            .plus_one(third * half)
    }

    /// x - k pi within -pi/2 and pi/2 (but for the last digit), and k. Error below 4 u^3 |x| beside the rounding
    /// of the result; |x| below [`Real::HOPELESS`].
    pub(super) fn reduced(self) -> (Self, T) {
        let mut rest = self;
        let mut turns = T::ZERO;
        // One step leaves a part u of the number, so three suffice.
        for _ in 0..3 {
            let quotient = rest.hi * T::INV_PI;
            let k = integer(quotient);
            if k == T::ZERO {
                break;
            }
            rest = rest.minus_turns(k);
            turns = turns + k;
        }
        (rest, turns)
    }

    fn minus_turns(self, k: T) -> Self {
        let [first, second, third] = T::PI;
        let (p, p_lo) = two_prod(k, first);
        let (q, q_lo) = two_prod(k, second);
        let (d, e) = two_sum(self.hi, -p);
        let (d, e) = two_sum_of_three(d, e, -p_lo);
        Self { hi: d, lo: e }
            .plus(Self::from(self.lo).plus_one(-q))
            .plus_one(-q_lo)
            .plus_one(-(k * third))
    }
}

/// The nearest integer.
fn integer<T: Real>(x: T) -> T {
    let magnitude = x.abs();
    if magnitude >= T::ROUNDER {
        return x;
    }
    let rounded = (magnitude + T::ROUNDER) - T::ROUNDER;
    if x < T::ZERO { -rounded } else { rounded }
}

/// d + e + p, where d and p may cancel.
fn two_sum_of_three<T: Real>(d: T, e: T, p: T) -> (T, T) {
    let (s, f) = two_sum(d, p);
    two_sum(s, e + f)
}
