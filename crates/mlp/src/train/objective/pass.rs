//! Pass over one panel of rows: its residuals and the sums of its derivatives.
//!
//! `V` is a vector of rows, `K` the number of vectors that advance together. Everything here is inlined into a
//! function compiled for the machine's vectors, which is why loops stand where iterators with closures would do.

use pulp::Simd;

use super::super::lanes::Real;
use super::super::metrics::softmax;
use super::super::topology::Layer;
use crate::activation::Activation;

/// Values of one neuron for a panel's rows.
pub(super) type Column<T, S, const K: usize> = [<T as Real>::Vector<S>; K];

/// Whole columns of a slice.
#[inline(always)]
pub(super) fn columns<T: Real, S: Simd, const K: usize>(slice: &[T]) -> &[Column<T, S, K>] {
    T::vectors::<S>(slice).as_chunks::<K>().0
}

/// The same to be written to.
#[inline(always)]
pub(super) fn columns_mut<T: Real, S: Simd, const K: usize>(
    slice: &mut [T],
) -> &mut [Column<T, S, K>] {
    T::vectors_mut::<S>(slice).as_chunks_mut::<K>().0
}

/// `to = W from + b` for all rows of a panel, before the activation.
#[inline(always)]
pub(super) fn weighted_sums<T: Real, S: Simd, const K: usize>(
    simd: S,
    layer: &[T],
    from: &[Column<T, S, K>],
    to: &mut [Column<T, S, K>],
) {
    let (matrix, biases) = layer.split_at(from.len() * to.len());
    let (pairs, last) = to.as_chunks_mut::<2>();
    let (bias_pairs, last_bias) = biases.as_chunks::<2>();
    let mut rows = matrix.chunks_exact(from.len());
    for (pair, bias) in pairs.iter_mut().zip(bias_pairs) {
        if let (Some(first), Some(second)) = (rows.next(), rows.next()) {
            let mut a = [T::splat(simd, bias[0]); K];
            let mut b = [T::splat(simd, bias[1]); K];
            for ((column, &v), &w) in from.iter().zip(first).zip(second) {
                let (v, w) = (T::splat(simd, v), T::splat(simd, w));
                for k in 0..K {
                    a[k] = T::mul_add(simd, v, column[k], a[k]);
                    b[k] = T::mul_add(simd, w, column[k], b[k]);
                }
            }
            *pair = [a, b];
        }
    }
    for ((place, bias), row) in last.iter_mut().zip(last_bias).zip(rows) {
        let mut a = [T::splat(simd, *bias); K];
        for (column, &v) in from.iter().zip(row) {
            let v = T::splat(simd, v);
            for k in 0..K {
                a[k] = T::mul_add(simd, v, column[k], a[k]);
            }
        }
        *place = a;
    }
}

/// Applies the function to every sum; `values` is a whole number of vectors.
#[inline(always)]
pub(super) fn activate<T: Real, S: Simd>(simd: S, activation: Activation, values: &mut [T]) {
    match activation {
        Activation::Tanh => T::tanh(simd, values),
        Activation::Linear => {}
        Activation::Logistic => {
            let half = T::splat(simd, T::of(0.5));
            for v in T::vectors_mut::<S>(values) {
                *v = T::product(simd, half, *v);
            }
            T::tanh(simd, values);
            for v in T::vectors_mut::<S>(values) {
                *v = T::mul_add(simd, half, *v, half);
            }
        }
        Activation::Relu => {
            for v in T::vectors_mut::<S>(values) {
                *v = T::ramp(simd, *v);
            }
        }
    }
}

/// Multiplies derivatives by a layer's values with the function's derivative where it has these values.
#[inline(always)]
pub(super) fn through_activation<T: Real, S: Simd>(
    simd: S,
    activation: Activation,
    values: &[T],
    deltas: &mut [T],
) {
    let one = T::splat(simd, T::of(1.0));
    let pairs = T::vectors_mut::<S>(deltas).iter_mut().zip(T::vectors::<S>(values));
    match activation {
        Activation::Linear => {}
        Activation::Tanh => {
            for (delta, &y) in pairs {
                let slope = T::difference(simd, one, T::product(simd, y, y));
                *delta = T::product(simd, *delta, slope);
            }
        }
        Activation::Logistic => {
            for (delta, &y) in pairs {
                let slope = T::product(simd, y, T::difference(simd, one, y));
                *delta = T::product(simd, *delta, slope);
            }
        }
        Activation::Relu => {
            for (delta, &y) in pairs {
                *delta = T::where_positive(simd, y, *delta);
            }
        }
    }
}

/// Writes output minus target to `residuals` and adds their squares to `squares`.
#[inline(always)]
pub(super) fn residuals<T: Real, S: Simd, const K: usize>(
    simd: S,
    [outputs, targets]: [&[Column<T, S, K>]; 2],
    mask: Option<T::Vector<S>>,
    residuals: &mut [Column<T, S, K>],
    squares: &mut T::Vector<S>,
) {
    for ((residual, output), target) in residuals.iter_mut().zip(outputs).zip(targets) {
        let mut e = *residual;
        for k in 0..K {
            e[k] = T::difference(simd, output[k], target[k]);
        }
        if let Some(mask) = mask {
            e[K - 1] = T::product(simd, e[K - 1], mask);
        }
        for e in e {
            *squares = T::mul_add(simd, e, e, *squares);
        }
        *residual = e;
    }
}

/// Writes softmax of the scores minus target to `residuals`, for the first `full` of `lanes` rows, and zeros for the others;
/// returns the sum of the cross-entropies. One row after the other: an exponential a score is little beside the sums before it.
#[inline(never)]
pub(super) fn cross_entropy<T: Real>(
    [scores, targets]: [&[T]; 2],
    residuals: &mut [T],
    lanes: usize,
    full: usize,
) -> f64 {
    let mut entropy = 0.0;
    residuals.fill(T::of(0.0));
    let mut row = vec![0.0; scores.len() / lanes];
    for lane in 0..full {
        let of = |values: &[T], class: usize| values[class * lanes + lane].double();
        row.iter_mut().enumerate().for_each(|(class, score)| *score = of(scores, class));
        let log_sum = softmax(&mut row);
        for (class, probability) in row.iter().enumerate() {
            let target = of(targets, class);
            residuals[class * lanes + lane] = T::of(probability - target);
            entropy += target * (log_sum - of(scores, class));
        }
    }
    entropy
}

/// Adds each weight's sum of delta times value to its accumulator, one vector a weight.
#[inline(always)]
pub(super) fn accumulate<T: Real, S: Simd, const K: usize>(
    simd: S,
    deltas: &[Column<T, S, K>],
    from: &[Column<T, S, K>],
    accumulators: &mut [T::Vector<S>],
) {
    let (matrix, biases) = accumulators.split_at_mut(from.len() * deltas.len());
    let (pairs, last) = deltas.as_chunks::<2>();
    let mut rows = matrix.chunks_exact_mut(from.len());
    for [first, second] in pairs {
        if let (Some(a), Some(b)) = (rows.next(), rows.next()) {
            for ((column, a), b) in from.iter().zip(a).zip(b) {
                let (mut x, mut y) = (*a, *b);
                for k in 0..K {
                    x = T::mul_add(simd, first[k], column[k], x);
                    y = T::mul_add(simd, second[k], column[k], y);
                }
                (*a, *b) = (x, y);
            }
        }
    }
    for (delta, row) in last.iter().zip(rows) {
        for (column, a) in from.iter().zip(row) {
            let mut x = *a;
            for k in 0..K {
                x = T::mul_add(simd, delta[k], column[k], x);
            }
            *a = x;
        }
    }
    for (delta, bias) in deltas.iter().zip(biases) {
        let mut x = *bias;
        for &d in delta {
            x = T::sum(simd, x, d);
        }
        *bias = x;
    }
}

/// Derivatives by the values before a layer: `before = W' deltas`.
#[inline(always)]
pub(super) fn carry_back<T: Real, S: Simd, const K: usize>(
    simd: S,
    layer: Layer,
    weights: &[T],
    deltas: &[Column<T, S, K>],
    before: &mut [Column<T, S, K>],
) {
    let matrix = &weights[layer.start..layer.biases()];
    for (column, place) in before.iter_mut().enumerate() {
        let mut sums = [T::splat(simd, T::of(0.0)); K];
        for (delta, row) in deltas.iter().zip(matrix.chunks_exact(layer.from)) {
            let w = T::splat(simd, row[column]);
            for k in 0..K {
                sums[k] = T::mul_add(simd, w, delta[k], sums[k]);
            }
        }
        *place = sums;
    }
}
