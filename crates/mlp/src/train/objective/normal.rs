//! Weights in, the Jacobian's products with itself and with the residuals out.

use pulp::{Simd, WithSimd};

use super::super::aligned::Aligned;
use super::super::real::Real;
use super::kernel::{One, Tape};
use super::panel::{Panels, VECTORS};
use super::pass::{Column, carry_back, columns, columns_mut, through_activation};

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
    width: usize,
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
            width,
        }
    }
}

/// The sums a pass over the Jacobian adds to.
pub(super) struct Sums<'a> {
    /// Lower triangle of a square matrix, row by row.
    pub(super) normal: &'a mut [f64],
    pub(super) projected: &'a mut [f64],
}

/// A pass over all rows and outputs; yields the sum of squared residuals.
pub(super) struct NormalEquations<'a, T> {
    pub(super) panels: &'a Panels<T>,
    pub(super) tape: &'a mut Tape<T>,
    pub(super) jacobian: &'a mut Jacobian<T>,
    pub(super) weights: &'a [T],
    pub(super) sums: Sums<'a>,
}

impl<T: Real> WithSimd for NormalEquations<'_, T> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        let Self { panels, tape, jacobian, weights, mut sums } = self;
        let mut sum = 0.0;
        jacobian.used = 0;
        for panel in &panels.panels {
            let work = One { simd, panels, panel, weights };
            sum += match panel.vectors {
                1 => work.derivatives::<1>(tape, jacobian, &mut sums),
                2 => work.derivatives::<2>(tape, jacobian, &mut sums),
                3 => work.derivatives::<3>(tape, jacobian, &mut sums),
                _ => work.derivatives::<VECTORS>(tape, jacobian, &mut sums),
            };
        }
        add_products::<T, S>(simd, jacobian, &mut sums);
        sum
    }
}

impl<T: Real, S: Simd> One<'_, T, S> {
    /// Adds the derivatives of the panel's residuals to the Jacobian.
    #[inline(always)]
    fn derivatives<const K: usize>(
        &self,
        tape: &mut Tape<T>,
        jacobian: &mut Jacobian<T>,
        sums: &mut Sums<'_>,
    ) -> f64 {
        let simd = self.simd;
        let zero = T::splat(simd, T::of(0.0));
        let one = T::splat(simd, T::of(1.0));
        let mut squares = zero;
        let inputs = self.forward::<K>(tape, &mut squares);
        let last = tape.layers.len() - 1;
        let outputs = tape.layers[last].to;
        let errors = tape.deltas[last].clone();
        for output in 0..outputs {
            if jacobian.used + K > jacobian.room {
                add_products::<T, S>(simd, jacobian, sums);
            }
            let at = jacobian.used;
            let kept = &mut T::vectors_mut::<S>(jacobian.residuals.get_mut())[at..at + K];
            kept.copy_from_slice(&columns::<T, S, K>(errors.get())[output]);
            let mut single = [one; K];
            if let Some(mask) = self.mask() {
                single[K - 1] = mask;
            }
            let deltas = columns_mut::<T, S, K>(tape.deltas[last].get_mut());
            for (place, delta) in deltas[..outputs].iter_mut().enumerate() {
                *delta = if place == output { single } else { [zero; K] };
            }
            self.write_rows::<K>(tape, inputs, jacobian);
            jacobian.used += K;
        }
        T::total(simd, squares).double()
    }

    /// One backward pass kept row by row.
    #[inline(always)]
    fn write_rows<const K: usize>(
        &self,
        tape: &mut Tape<T>,
        inputs: &[Column<T, S, K>],
        jacobian: &mut Jacobian<T>,
    ) {
        let (simd, at_vector, room) = (self.simd, jacobian.used, jacobian.room);
        let derivatives = T::vectors_mut::<S>(jacobian.derivatives.get_mut());
        for (at, &layer) in tape.layers.iter().enumerate().rev() {
            let (before, after) = tape.deltas.split_at_mut(at);
            let used = layer.to * K * jacobian.width;
            let deltas = &mut after[0].get_mut()[..used];
            let values = &tape.values[at].get()[..used];
            through_activation::<T, S>(simd, layer.activation, values, deltas);
            let deltas = columns::<T, S, K>(deltas);
            let from = match at.checked_sub(1) {
                None => inputs,
                Some(previous) => &columns::<T, S, K>(tape.values[previous].get())[..layer.from],
            };
            let rows = &mut derivatives[layer.start * room..layer.end() * room];
            let mut rows = rows.chunks_exact_mut(room);
            for delta in deltas {
                for (value, row) in from.iter().zip(&mut rows) {
                    for k in 0..K {
                        row[at_vector + k] = T::product(simd, delta[k], value[k]);
                    }
                }
            }
            for (delta, row) in deltas.iter().zip(&mut rows) {
                row[at_vector..at_vector + K].copy_from_slice(delta);
            }
            if let Some(place) = before.last_mut() {
                let place = &mut columns_mut::<T, S, K>(place.get_mut())[..layer.from];
                carry_back::<T, S, K>(simd, layer, self.weights, deltas, place);
            }
        }
    }
}

/// Adds the products of what the Jacobian holds and empties it.
#[inline(always)]
fn add_products<T: Real, S: Simd>(simd: S, jacobian: &mut Jacobian<T>, sums: &mut Sums<'_>) {
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
