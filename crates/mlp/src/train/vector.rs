//! Vectors of weights in, their inner products and combinations out, on the machine's vectors.
//!
//! Inner products are summed in `f64` whatever the precision of the values: directions in `f32` may hold numbers whose
//! squares it can not represent.

use pulp::{Simd, WithSimd};

use super::lanes::Isa;
use super::real::Real;

/// Sums that advance side by side.
const SUMS: usize = 16;

struct Dot<'a, T>(&'a [T], &'a [T]);

impl<T: Real> WithSimd for Dot<'_, T> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> f64 {
        let (left, left_rest) = self.0.as_chunks::<SUMS>();
        let (right, right_rest) = self.1.as_chunks::<SUMS>();
        let mut sums = [0.0; SUMS];
        for (a, b) in left.iter().zip(right) {
            for lane in 0..SUMS {
                sums[lane] += a[lane].double() * b[lane].double();
            }
        }
        let mut half = SUMS / 2;
        while half > 0 {
            for lane in 0..half {
                sums[lane] += sums[lane + half];
            }
            half /= 2;
        }
        for (a, b) in left_rest.iter().zip(right_rest) {
            sums[0] += a.double() * b.double();
        }
        sums[0]
    }
}

/// Inner product over the shorter slice.
pub(super) fn dot<T: Real>(isa: Isa, left: &[T], right: &[T]) -> f64 {
    isa.dispatch(Dot(left, right))
}

/// Euclidean length.
pub(super) fn norm<T: Real>(isa: Isa, vector: &[T]) -> f64 {
    dot(isa, vector, vector).sqrt()
}

struct Combine<'a, T> {
    out: &'a mut [T],
    base: &'a [T],
    factor: T,
    direction: &'a [T],
}

impl<T: Real> WithSimd for Combine<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        for ((out, &base), &d) in self.out.iter_mut().zip(self.base).zip(self.direction) {
            *out = base + self.factor * d;
        }
    }
}

/// `out = base + factor direction`.
pub(super) fn combine<T: Real>(isa: Isa, out: &mut [T], base: &[T], factor: f64, direction: &[T]) {
    isa.dispatch(Combine { out, base, factor: T::of(factor), direction });
}

/// `vector += factor direction`.
pub(super) fn add<T: Real>(vector: &mut [T], factor: f64, direction: &[T]) {
    let factor = T::of(factor);
    for (v, &d) in vector.iter_mut().zip(direction) {
        *v += factor * d;
    }
}

/// Whether all values are neither NaN nor infinite.
pub(super) fn finite<T: Real>(vector: &[T]) -> bool {
    vector.iter().all(|value| value.is_finite())
}
