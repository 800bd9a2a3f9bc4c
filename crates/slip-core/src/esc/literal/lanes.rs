//! Sixteen irregularities side by side: the same arithmetic as one by one, in lanes that a compiler turns into vector
//! instructions.

use crate::esc::{
    cotangent::SERIES_UP_TO,
    double::{Double, two_prod, two_sum},
    real::Real,
};

/// Irregularities a block.
pub(super) const BLOCK: usize = 16;
const LANES: usize = 4;

/// Sums of one block.
#[derive(Clone, Copy, Debug)]
pub(super) struct Block<T> {
    pub(super) quotients: Double<T>,
    pub(super) series: Double<T>,
    pub(super) sensitivity: T,
    pub(super) sensitivity_squared: T,
}

#[derive(Clone, Copy, Debug, Default)]
struct Lanes<T> {
    quotients: [T; LANES],
    quotients_lo: [T; LANES],
    series: [T; LANES],
    series_lo: [T; LANES],
    sensitivity: [T; LANES],
    sensitivity_squared: [T; LANES],
}

impl<T: Real> Block<T> {
    /// The sums of the irregularities (height, spacing); `None` where one of them is not shallow and of ordinary size.
    #[inline]
    pub(super) fn of(lengths: &[(T, T); BLOCK]) -> Option<Self> {
        let mut lanes = Lanes::default();
        for group in lengths.chunks_exact(LANES) {
            let mut delta = [T::ONE; LANES];
            let mut spacing = [T::ONE; LANES];
            for ((delta, spacing), lengths) in delta.iter_mut().zip(&mut spacing).zip(group) {
                (*delta, *spacing) = *lengths;
            }
            if !lanes.push(&delta, &spacing) {
                return None;
            }
        }
        let sum = |hi: [T; LANES], lo: [T; LANES]| {
            let parts = hi.into_iter().zip(lo).map(|(hi, lo)| Double { hi, lo });
            parts.fold(Double::default(), |sum: Double<T>, part| {
                let (hi, rest) = two_sum(sum.hi, part.hi);
                Double { hi, lo: sum.lo + (rest + part.lo) }
            })
        };
        let plain = |terms: [T; LANES]| terms.into_iter().fold(T::ZERO, |sum, term| sum + term);
        Some(Self {
            quotients: sum(lanes.quotients, lanes.quotients_lo),
            series: sum(lanes.series, lanes.series_lo),
            sensitivity: plain(lanes.sensitivity),
            sensitivity_squared: plain(lanes.sensitivity_squared),
        })
    }
}

impl<T: Real> Lanes<T> {
    #[inline]
    fn push(&mut self, delta: &[T; LANES], spacing: &[T; LANES]) -> bool {
        let mut inverse = [T::ONE; LANES];
        let mut r = [T::ONE; LANES];
        let mut fits = true;
        for i in 0..LANES {
            inverse[i] = T::ONE / delta[i];
            r[i] = delta[i] / spacing[i];
            fits &= r[i] <= T::of(SERIES_UP_TO)
                && r[i] > T::ONE / T::HOPELESS
                && spacing[i] > T::ONE / T::ORDINARY
                && spacing[i] < T::ORDINARY;
        }
        for i in 0..LANES {
            let q = spacing[i] * inverse[i];
            let (product, product_lo) = two_prod(q, delta[i]);
            let q_lo = ((spacing[i] - product) - product_lo) * inverse[i];
            let h = r[i].h();
            let (sum, rest) = two_sum(self.quotients[i], q);
            self.quotients[i] = sum;
            self.quotients_lo[i] = self.quotients_lo[i] + (rest + q_lo);
            let (sum, rest) = two_sum(self.series[i], h);
            self.series[i] = sum;
            self.series_lo[i] = self.series_lo[i] + rest;
            let cot = q - h;
            let sensitivity = r[i] * (T::ONE + cot * cot);
            self.sensitivity[i] = self.sensitivity[i] + sensitivity;
            self.sensitivity_squared[i] = self.sensitivity_squared[i] + sensitivity * sensitivity;
        }
        fits
    }
}
