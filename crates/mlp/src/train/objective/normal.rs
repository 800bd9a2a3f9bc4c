//! Products of the Jacobian with itself and with the residuals, from its rows.

use pulp::Simd;

use super::super::aligned::Aligned;
use super::super::lanes::Real;
use super::super::topology::Layer;
use super::panel::VECTORS;
use super::pass::Column;

/// Bytes of the Jacobian that are kept until their products are taken: they stay in the second-level cache.
const BYTES: usize = 192 * 1024;

/// Rows of the Jacobian, transposed: for each weight the derivatives of some residuals, a few vectors long.
#[derive(Debug, Clone)]
pub(super) struct Jacobian<T> {
    derivatives: Aligned<T>,
    residuals: Aligned<T>,
    /// Vectors per weight.
    room: usize,
    /// Vectors in use.
    used: usize,
}

impl<T: Real> Jacobian<T> {
    pub(super) fn new(weights: usize, width: usize) -> Self {
        let vector = weights.max(1) * width * size_of::<T>();
        let room = (BYTES / vector).clamp(VECTORS, 16 * VECTORS);
        Self {
            derivatives: Aligned::zeros(weights * room * width),
            residuals: Aligned::zeros(room * width),
            room,
            used: 0,
        }
    }

    /// Whether so many vectors are free.
    #[inline(always)]
    pub(super) fn has_room(&self, vectors: usize) -> bool {
        self.used + vectors <= self.room
    }

    /// Keeps the derivatives by the weights of a layer.
    #[inline(always)]
    pub(super) fn write<S: Simd, const K: usize>(
        &mut self,
        simd: S,
        layer: Layer,
        deltas: &[Column<T, S, K>],
        from: &[Column<T, S, K>],
    ) {
        let (used, room) = (self.used, self.room);
        let derivatives = T::vectors_mut::<S>(self.derivatives.get_mut());
        let rows = &mut derivatives[layer.start * room..layer.end() * room];
        let mut rows = rows.chunks_exact_mut(room);
        for delta in deltas {
            for (value, row) in from.iter().zip(&mut rows) {
                for k in 0..K {
                    row[used + k] = T::product(simd, delta[k], value[k]);
                }
            }
        }
        for (delta, row) in deltas.iter().zip(&mut rows) {
            row[used..used + K].copy_from_slice(delta);
        }
    }

    /// Keeps the residuals whose derivatives were written.
    #[inline(always)]
    pub(super) fn advance<S: Simd, const K: usize>(&mut self, residuals: &Column<T, S, K>) {
        let kept = T::vectors_mut::<S>(self.residuals.get_mut());
        kept[self.used..self.used + K].copy_from_slice(residuals);
        self.used += K;
    }
}

/// The sums a pass over the Jacobian adds to.
pub(super) struct Sums<'a> {
    /// Lower triangle of a square matrix, row by row.
    pub(super) normal: &'a mut [f64],
    pub(super) projected: &'a mut [f64],
}

/// Adds the products of what the Jacobian holds and empties it.
#[inline(always)]
pub(super) fn add_products<T: Real, S: Simd>(
    simd: S,
    jacobian: &mut Jacobian<T>,
    sums: &mut Sums<'_>,
) {
    let (room, used) = (jacobian.room, jacobian.used);
    let weights = sums.projected.len();
    let all = T::vectors::<S>(jacobian.derivatives.get());
    let residuals = &T::vectors::<S>(jacobian.residuals.get())[..used];
    let row = |weight: usize| &all[weight * room..weight * room + used];
    for first in (0..weights).step_by(2) {
        let second = (first + 1).min(weights - 1);
        let (a, b) = (row(first), row(second));
        let [p, q] = products::<T, S, 1>(simd, [a, b], [residuals])[0];
        sums.projected[first] += p;
        if second > first {
            sums.projected[second] += q;
        }
        for other in (0..=second).step_by(2) {
            let next = (other + 1).min(weights - 1);
            let block = products::<T, S, 2>(simd, [a, b], [row(other), row(next)]);
            for (place, values) in [other, next].into_iter().zip(block) {
                // The block on the diagonal holds one product of the upper triangle.
                if place <= first {
                    sums.normal[first * weights + place] += values[0];
                }
                if second > first && place <= second && place < weights {
                    sums.normal[second * weights + place] += values[1];
                }
                if next == other {
                    break;
                }
            }
        }
    }
    jacobian.used = 0;
}

/// Dot products of two slices with `N` others.
#[inline(always)]
fn products<T: Real, S: Simd, const N: usize>(
    simd: S,
    [a, b]: [&[T::Vector<S>]; 2],
    others: [&[T::Vector<S>]; N],
) -> [[f64; 2]; N] {
    let mut sums = [[T::splat(simd, T::of(0.0)); 2]; N];
    for (at, (&a, &b)) in a.iter().zip(b).enumerate() {
        for n in 0..N {
            let other = others[n][at];
            sums[n][0] = T::mul_add(simd, a, other, sums[n][0]);
            sums[n][1] = T::mul_add(simd, b, other, sums[n][1]);
        }
    }
    let mut totals = [[0.0; 2]; N];
    for n in 0..N {
        totals[n] = [T::total(simd, sums[n][0]).double(), T::total(simd, sums[n][1]).double()];
    }
    totals
}
