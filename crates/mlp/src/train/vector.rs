//! Inner products and combinations of vectors of weights.
//!
//! Inner products are summed in `f64` whatever the precision of the values: directions in `f32` may hold numbers whose
//! squares it can not represent.

use super::lanes::Real;

/// Sums that advance side by side.
const SUMS: usize = 16;

/// Inner product over the shorter slice.
pub(super) fn dot<T: Real>(left: &[T], right: &[T]) -> f64 {
    let (left, left_rest) = left.as_chunks::<SUMS>();
    let (right, right_rest) = right.as_chunks::<SUMS>();
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

/// Euclidean length.
pub(super) fn norm<T: Real>(vector: &[T]) -> f64 {
    dot(vector, vector).sqrt()
}

/// `out = base + factor direction`.
pub(super) fn combine<T: Real>(out: &mut [T], base: &[T], factor: f64, direction: &[T]) {
    let factor = T::of(factor);
    for ((out, &base), &d) in out.iter_mut().zip(base).zip(direction) {
        *out = base + factor * d;
    }
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
    vector.iter().all(|value| value.double().is_finite())
}
