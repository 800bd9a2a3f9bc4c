//! Sums of two numbers of a format, about twice as precise as one.
//!
//! Algorithms and error bounds: M. Joldes, J.-M. Muller, V. Popescu, "Tight and rigorous error bounds for basic
//! building blocks of double-word arithmetic", ACM TOMS 44 (2017); u is the roundoff of the format. Products
//! are split by Veltkamp and Dekker: without a fused multiply-add in the processor, one in software is slower than
//! everything here together.

use super::real::Real;

/// hi + lo with |lo| <= u |hi|.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Double<T> {
    pub(super) hi: T,
    pub(super) lo: T,
}

/// a + b as its rounding and the error of it, exactly.
#[inline]
pub(super) fn two_sum<T: Real>(a: T, b: T) -> (T, T) {
    let s = a + b;
    let b_part = s - a;
    (s, (a - (s - b_part)) + (b - b_part))
}

/// The same for |a| >= |b|.
#[inline]
pub(super) fn quick_two_sum<T: Real>(a: T, b: T) -> (T, T) {
    let s = a + b;
    (s, b - (s - a))
}

/// The upper and the lower half of the digits.
#[inline]
fn halves<T: Real>(a: T) -> (T, T) {
    let t = T::SPLITTER * a;
    let upper = t - (t - a);
    (upper, a - upper)
}

/// a b as its rounding and the error of it, exactly where neither over- nor underflows.
#[inline]
pub(super) fn two_prod<T: Real>(a: T, b: T) -> (T, T) {
    let p = a * b;
    let (a_hi, a_lo) = halves(a);
    let (b_hi, b_lo) = halves(b);
    (p, a_lo * b_lo - (((p - a_hi * b_hi) - a_lo * b_hi) - a_hi * b_lo))
}

impl<T: Real> Double<T> {
    /// One number.
    #[inline]
    pub(super) fn from(hi: T) -> Self {
        Self { hi, lo: T::ZERO }
    }

    /// Adds a non-negative number to a running bound without losing the small ones.
    #[inline]
    pub(super) fn tally(&mut self, value: T) {
        T::tally(&mut self.hi, &mut self.lo, value);
    }

    /// Both parts in one number.
    #[inline]
    pub(super) fn total(self) -> T {
        self.hi + self.lo
    }

    /// The same sum with |lo| <= u |hi|.
    #[inline]
    pub(super) fn normal(self) -> Self {
        let (hi, lo) = two_sum(self.hi, self.lo);
        Self { hi, lo }
    }

    #[inline]
    pub(super) fn neg(self) -> Self {
        Self { hi: -self.hi, lo: -self.lo }
    }

    /// Relative error 2 u^2.
    #[inline]
    pub(super) fn plus_one(self, b: T) -> Self {
        let (s, e) = two_sum(self.hi, b);
        let (hi, lo) = quick_two_sum(s, self.lo + e);
        Self { hi, lo }
    }

    /// Relative error 3 u^2, whatever the signs.
    #[inline]
    pub(super) fn plus(self, b: Self) -> Self {
        let (s, s_lo) = two_sum(self.hi, b.hi);
        let (t, t_lo) = two_sum(self.lo, b.lo);
        let (s, c) = quick_two_sum(s, s_lo + t);
        let (hi, lo) = quick_two_sum(s, t_lo + c);
        Self { hi, lo }
    }

    #[inline]
    pub(super) fn minus(self, b: Self) -> Self {
        self.plus(b.neg())
    }

    /// Relative error 7 u^2.
    #[inline]
    pub(super) fn times(self, b: Self) -> Self {
        let (p, e) = two_prod(self.hi, b.hi);
        let (hi, lo) = quick_two_sum(p, e + (self.hi * b.lo + self.lo * b.hi));
        Self { hi, lo }
    }

    /// Relative error 3 u^2.
    #[inline]
    pub(super) fn times_one(self, b: T) -> Self {
        let (p, e) = two_prod(self.hi, b);
        let (hi, lo) = quick_two_sum(p, e + self.lo * b);
        Self { hi, lo }
    }

    /// Half of it, exactly but for underflow.
    #[inline]
    pub(super) fn half(self) -> Self {
        let half = T::of(0.5);
        Self { hi: self.hi * half, lo: self.lo * half }
    }

    /// Relative error 15 u^2.
    #[inline]
    pub(super) fn over(self, b: Self) -> Self {
        let q = self.hi / b.hi;
        let r = b.times_one(q);
        let rest = (self.hi - r.hi) + (self.lo - r.lo);
        let (hi, lo) = quick_two_sum(q, rest / b.hi);
        Self { hi, lo }
    }

    /// a/b of two single numbers, relative error 4 u^2.
    #[inline]
    pub(super) fn ratio(a: T, b: T) -> Self {
        let q = a / b;
        let (p, e) = two_prod(q, b);
        let (hi, lo) = quick_two_sum(q, ((a - p) - e) / b);
        Self { hi, lo }
    }
}
