//! Inputs of 16 bits in, outputs of 32 bits out: the forward pass in integers, for processors without floating point.
//!
//! A Q15 number `q` stands for `q / 2^15`. Inputs and hidden values are Q15 in 16 bits, range [-1, 1); outputs are Q15
//! in 32 bits, range [-65536, 65536). Each layer has an exponent `e` with `|w|, |b| <= 2^e`: its weights are kept as
//! `w 2^(15-e)` in 16 bits, its biases as `b 2^(30-e)` in 32 bits; products are summed in 64 bits and never overflow.
//! Tanh is a table of 513 values with linear interpolation, at most 2.3 / 2^15 off
//! (`tanh_is_within_its_bound_everywhere`).

use crate::activation::Activation;
use crate::network::{MAX_LAYERS, MAX_WIDTH, Network, ShapeError, check_sizes};
use crate::tanh::{DENOMINATOR, NUMERATOR};

/// Largest exponent of a layer: weights up to 2^15.
pub const MAX_EXPONENT: u8 = 15;

/// One in Q15.
const ONE: f64 = 32_768.0;

/// Largest error of the integer tanh (1 / 2^15).
const TANH_ERROR: f64 = 2.3;

/// Steps of the tanh table from 0 to [`TABLE_END`].
const STEPS: usize = 512;

/// Argument of the table's last value, in Q15.
const TABLE_END: i64 = 8 << 15;

/// Bits of an argument in Q15 below a step of the table.
const STEP_BITS: u32 = 9;

/// `tanh(k / 64)` in Q15.
static TABLE: [i16; STEPS + 1] = table();

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_precision_loss,
    reason = "steps are small and values lie below 1; const code has no checked conversions"
)]
const fn table() -> [i16; STEPS + 1] {
    let mut values = [0; STEPS + 1];
    let mut step = 0;
    while step <= STEPS {
        let x = step as f64 / 64.0;
        let square = x * x;
        let [p0, p1, p2] = NUMERATOR;
        let [q0, q1, q2, q3] = DENOMINATOR;
        let n = x * ((p2 as f64 * square + p1 as f64) * square + p0 as f64);
        let q = ((q3 as f64 * square + q2 as f64) * square + q1 as f64) * square + q0 as f64;
        let value = 2.0 * n * q / (n * n + q * q) * ONE + 0.5;
        values[step] = if value >= 32_767.0 { i16::MAX } else { value as i16 };
        step += 1;
    }
    values
}

/// Why a network can not be turned into integers.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum Q15Error {
    /// Sizes and slices do not fit together.
    #[error(transparent)]
    Shape(#[from] ShapeError),
    /// A hidden layer whose values may leave [-1, 1).
    #[error("hidden layer {layer} is {activation}: only tanh and logistic stay within 16 bits")]
    Unbounded {
        /// 0 for the first hidden layer.
        layer: usize,
        /// Its function.
        activation: Activation,
    },
    /// A weight or bias beyond 2^15.
    #[error("layer {layer} has a weight of {largest}: at most 32768 fits")]
    TooLarge {
        /// 0 for the first layer of weights.
        layer: usize,
        /// Size of its largest weight or bias.
        largest: f32,
    },
    /// An exponent above [`MAX_EXPONENT`], or not one per layer.
    #[error("there must be one exponent of 0 to {MAX_EXPONENT} for each layer of weights")]
    Exponents,
}

/// A network in 16-bit integers; weights and biases may lie in flash.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Q15<'a> {
    sizes: [usize; MAX_LAYERS + 1],
    activations: [Activation; MAX_LAYERS],
    exponents: [u8; MAX_LAYERS],
    layers: usize,
    weights: &'a [i16],
    biases: &'a [i32],
}

impl<'a> Q15<'a> {
    /// Joins parts made by [`quantize`](Self::quantize) elsewhere: `weights` of all layers row by row without biases,
    /// one exponent per layer.
    ///
    /// # Errors
    /// [`Q15Error::Shape`], [`Q15Error::Unbounded`] or [`Q15Error::Exponents`].
    pub fn new(
        sizes: &[usize],
        activations: &[Activation],
        exponents: &[u8],
        weights: &'a [i16],
        biases: &'a [i32],
    ) -> Result<Self, Q15Error> {
        check_sizes(sizes, activations, MAX_WIDTH)?;
        check_bounded(activations)?;
        if exponents.len() != activations.len() || exponents.iter().any(|&e| e > MAX_EXPONENT) {
            return Err(Q15Error::Exponents);
        }
        let (needed, given) = (room(sizes), (weights.len(), biases.len()));
        if needed != given {
            let (needed, given) = (needed.0 + needed.1, given.0.saturating_add(given.1));
            return Err(ShapeError::WeightCount { needed, given }.into());
        }
        let mut network = Self {
            sizes: [0; MAX_LAYERS + 1],
            activations: [Activation::Linear; MAX_LAYERS],
            exponents: [0; MAX_LAYERS],
            layers: activations.len(),
            weights,
            biases,
        };
        fill(&mut network.sizes, sizes);
        fill(&mut network.activations, activations);
        fill(&mut network.exponents, exponents);
        Ok(network)
    }

    /// Rounds a network's weights to integers, written to the slices, which must have the lengths [`room`] gives.
    ///
    /// # Errors
    /// [`Q15Error::Shape`] for slices of other lengths, [`Q15Error::Unbounded`], [`Q15Error::TooLarge`].
    pub fn quantize<W: AsRef<[f32]>>(
        network: &Network<W>,
        weights: &'a mut [i16],
        biases: &'a mut [i32],
    ) -> Result<Self, Q15Error> {
        check_bounded(network.activations())?;
        let (needed, given) = (room(network.sizes()), (weights.len(), biases.len()));
        if needed != given {
            let (needed, given) = (needed.0 + needed.1, given.0.saturating_add(given.1));
            return Err(ShapeError::WeightCount { needed, given }.into());
        }
        let mut exponents = [0; MAX_LAYERS];
        let mut places = (weights.iter_mut(), biases.iter_mut());
        let layers = layers(network.sizes(), network.weights());
        for (layer, ((matrix, offsets), exponent)) in layers.zip(&mut exponents).enumerate() {
            *exponent = fitting_exponent(layer, matrix, offsets)?;
            let unit = f64::from(1_u32 << (15 - u32::from(*exponent)));
            for (weight, place) in matrix.iter().zip(&mut places.0) {
                *place = rounded(f64::from(*weight) * unit, i16::MIN.into(), i16::MAX.into());
            }
            for (bias, place) in offsets.iter().zip(&mut places.1) {
                *place = rounded(f64::from(*bias) * unit * ONE, i32::MIN.into(), i32::MAX.into());
            }
        }
        let exponents = exponents.get(..network.activations().len()).unwrap_or(&[]);
        Self::new(network.sizes(), network.activations(), exponents, weights, biases)
    }

    /// Layer sizes: inputs, hidden layers, outputs.
    #[must_use]
    pub fn sizes(&self) -> &[usize] {
        self.sizes.get(..=self.layers).unwrap_or(&self.sizes)
    }

    /// One exponent per layer of weights.
    #[must_use]
    pub fn exponents(&self) -> &[u8] {
        self.exponents.get(..self.layers).unwrap_or(&self.exponents)
    }

    /// Integer weights of all layers, row by row, without biases.
    #[must_use]
    pub fn weights(&self) -> &'a [i16] {
        self.weights
    }

    /// Integer biases of all layers.
    #[must_use]
    pub fn biases(&self) -> &'a [i32] {
        self.biases
    }

    /// Largest difference, in scaled units, between an output for inputs within [-1, 1) and that of the network with
    /// unrounded weights in exact arithmetic: rounding of inputs, weights, sums and tanh, added up as if all were worst.
    #[must_use]
    pub fn error_bound(&self) -> f64 {
        let mut error = 1.0 / ONE;
        for (at, (matrix, to, exponent)) in self.matrices().enumerate() {
            let unit = f64::from(1_u32 << (15 - u32::from(exponent)));
            let from = matrix.len() / to.max(1);
            let heaviest = matrix
                .chunks_exact(from.max(1))
                .map(|row| row.iter().map(|w| f64::from(w.unsigned_abs())).sum::<f64>() / unit)
                .fold(0.0, f64::max);
            // A weight of 2^e itself becomes 32767 and is off by a whole unit.
            let rounding = (fit(from) + 1.0) / unit;
            let sum = heaviest * error + rounding + 1.0 / ONE;
            error = match self.activations.get(at) {
                Some(Activation::Tanh) => sum + TANH_ERROR / ONE,
                Some(Activation::Logistic) => 0.25 * sum + TANH_ERROR / ONE,
                _ => sum,
            };
        }
        error
    }

    /// Weight matrix, number of neurons and exponent of each layer.
    fn matrices(&self) -> impl Iterator<Item = (&'a [i16], usize, u8)> + '_ {
        let mut rest = self.weights;
        self.sizes().windows(2).zip(self.exponents()).map(move |(pair, &exponent)| {
            let (from, to) = match pair {
                &[from, to] => (from, to),
                _ => (0, 0),
            };
            let (matrix, left) = rest.split_at_checked(from * to).unwrap_or((&[], &[]));
            rest = left;
            (matrix, to, exponent)
        })
    }

    /// Computes the outputs (Q15 in 32 bits) for `input` (Q15). Integers only, no division, no allocation, no panic;
    /// outputs beyond the range of 32 bits stick to its end.
    ///
    /// # Errors
    /// [`ShapeError::Inputs`] or [`ShapeError::Outputs`] for a slice of the wrong length.
    pub fn forward(&self, input: &[i16], output: &mut [i32]) -> Result<(), ShapeError> {
        let (inputs, outputs) = (self.sizes[0], self.sizes().last().copied().unwrap_or(0));
        if input.len() != inputs {
            return Err(ShapeError::Inputs { needed: inputs, given: input.len() });
        }
        if output.len() != outputs {
            return Err(ShapeError::Outputs { needed: outputs, given: output.len() });
        }
        let mut values = [0_i16; MAX_WIDTH];
        fill(&mut values, input);
        let mut biases = self.biases.iter();
        let mut from = inputs;
        for (at, (matrix, to, exponent)) in self.matrices().enumerate() {
            let activation = self.activations.get(at).copied().unwrap_or(Activation::Linear);
            let shift = u32::from(MAX_EXPONENT - exponent.min(MAX_EXPONENT));
            let mut sums = [0_i64; MAX_WIDTH];
            let rows = matrix.chunks_exact(from.max(1)).zip(&mut biases);
            for (sum, (row, bias)) in sums.iter_mut().zip(rows) {
                *sum =
                    activated(activation, rounded_shift(weighted_sum(row, &values, *bias), shift));
            }
            for (place, sum) in values.iter_mut().zip(sums) {
                *place = clamped(sum, i16::MIN.into(), i16::MAX.into());
            }
            if at + 1 == self.layers {
                for (place, sum) in output.iter_mut().zip(sums) {
                    *place = clamped(sum, i32::MIN.into(), i32::MAX.into());
                }
            }
            from = to;
        }
        Ok(())
    }
}

/// Number of weights and of biases of a network with these layer sizes (inputs first).
#[must_use]
pub fn room(sizes: &[usize]) -> (usize, usize) {
    let weights = sizes.windows(2).map(|pair| pair.iter().product::<usize>()).sum();
    (weights, sizes.iter().skip(1).sum())
}

fn fill<T: Copy>(places: &mut [T], values: &[T]) {
    for (place, value) in places.iter_mut().zip(values) {
        *place = *value;
    }
}

fn check_bounded(activations: &[Activation]) -> Result<(), Q15Error> {
    let hidden = activations.iter().take(activations.len().saturating_sub(1));
    for (layer, &activation) in hidden.enumerate() {
        if !matches!(activation, Activation::Tanh | Activation::Logistic) {
            return Err(Q15Error::Unbounded { layer, activation });
        }
    }
    Ok(())
}

/// Matrix and biases of each layer.
fn layers<'w>(
    sizes: &'w [usize],
    weights: &'w [f32],
) -> impl Iterator<Item = (&'w [f32], &'w [f32])> {
    let mut rest = weights;
    sizes.windows(2).map(move |pair| {
        let (from, to) = match pair {
            &[from, to] => (from, to),
            _ => (0, 0),
        };
        let (matrix, left) = rest.split_at_checked(from * to).unwrap_or((&[], &[]));
        let (biases, left) = left.split_at_checked(to).unwrap_or((&[], &[]));
        rest = left;
        (matrix, biases)
    })
}

/// The least exponent under which all weights of a layer fit.
fn fitting_exponent(layer: usize, matrix: &[f32], biases: &[f32]) -> Result<u8, Q15Error> {
    let largest = matrix.iter().chain(biases).fold(0.0_f32, |largest, w| largest.max(w.abs()));
    let mut limit = 1.0_f32;
    for exponent in 0..=MAX_EXPONENT {
        if largest <= limit {
            return Ok(exponent);
        }
        limit *= 2.0;
    }
    Err(Q15Error::TooLarge { layer, largest })
}

/// Nearest integer within the limits of `T`.
fn rounded<T: TryFrom<i64> + From<i16>>(value: f64, low: i64, high: i64) -> T {
    let half = if value < 0.0 { -0.5 } else { 0.5 };
    #[expect(clippy::cast_possible_truncation, reason = "the cast saturates")]
    let nearest = (value + half) as i64;
    clamped(nearest, low, high)
}

fn clamped<T: TryFrom<i64> + From<i16>>(value: i64, low: i64, high: i64) -> T {
    // The limits are those of `T`: the conversion can not fail.
    T::try_from(value.clamp(low.min(high), high.max(low))).unwrap_or(T::from(0))
}

/// Widths are at most [`MAX_WIDTH`].
fn fit(width: usize) -> f64 {
    u32::try_from(width).map_or(f64::INFINITY, f64::from)
}

/// Sum of a neuron in units of `2^(e-30)`: at most 64 products below 2^30 and a bias.
#[inline]
fn weighted_sum(row: &[i16], values: &[i16], bias: i32) -> i64 {
    let products = row.iter().zip(values).map(|(w, x)| i64::from(i32::from(*w) * i32::from(*x)));
    products.fold(i64::from(bias), |sum, product| sum + product)
}

/// `sum / 2^shift`, rounded.
#[inline]
const fn rounded_shift(sum: i64, shift: u32) -> i64 {
    let half = (1_i64 << (shift & 31)) >> 1;
    (sum + half) >> (shift & 31)
}

/// The function of a sum in Q15, in Q15.
fn activated(activation: Activation, sum: i64) -> i64 {
    match activation {
        Activation::Tanh => tanh(sum),
        Activation::Linear => sum,
        Activation::Logistic => (tanh(rounded_shift(sum, 1)) + (1 << 15)) >> 1,
        Activation::Relu => sum.max(0),
    }
}

/// The hyperbolic tangent of a Q15 number, in Q15.
fn tanh(x: i64) -> i64 {
    let size = x.saturating_abs().min(TABLE_END - 1);
    let step = usize::try_from(size >> STEP_BITS).unwrap_or(0);
    let &[low, high] = TABLE.get(step..).and_then(<[i16]>::first_chunk).unwrap_or(&[i16::MAX; 2]);
    let (low, high) = (i64::from(low), i64::from(high));
    let part = size & ((1 << STEP_BITS) - 1);
    let value = low + rounded_shift((high - low) * part, STEP_BITS);
    if x < 0 { -value } else { value }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const HIDDEN: [Activation; 3] = [Activation::Tanh, Activation::Logistic, Activation::Linear];

    #[test]
    fn tanh_is_within_its_bound_everywhere() {
        let mut worst = 0.0_f64;
        for x in -10 * 32_768..=10 * 32_768_i64 {
            let exact = (x as f64 / ONE).tanh() * ONE;
            worst = worst.max((tanh(x) as f64 - exact).abs());
            assert_eq!(tanh(-x), -tanh(x));
            assert!(tanh(x + 1) >= tanh(x), "falls at {x}");
        }
        eprintln!("largest error of the integer tanh: {worst:.3} / 2^15");
        assert!(worst <= TANH_ERROR, "{worst}");
        assert_eq!((tanh(i64::MIN), tanh(i64::MAX)), (-32_767, 32_767));
    }

    fn outputs(network: &Network<&[f32]>, input: &[i16]) -> (Vec<f64>, Vec<f64>, f64) {
        let (w, b) = room(network.sizes());
        let (mut weights, mut biases) = (vec![0; w], vec![0; b]);
        let integer = Q15::quantize(network, &mut weights, &mut biases).unwrap();
        let mut out = vec![0; network.outputs()];
        integer.forward(input, &mut out).unwrap();
        let mut exact = vec![0.0; network.outputs()];
        let raw: Vec<f64> = input.iter().map(|x| f64::from(*x) / ONE).collect();
        network.forward_double(&raw, &mut exact).unwrap();
        (out.iter().map(|y| f64::from(*y) / ONE).collect(), exact, integer.error_bound())
    }

    proptest! {
        #[test]
        fn outputs_are_within_the_stated_bound_of_double_precision(
            weights in prop::collection::vec(-3.0_f32..3.0, crate::weight_count(&[3, 8, 6, 2])),
            input in prop::collection::vec(any::<i16>(), 3),
        ) {
            let network = Network::new(&[3, 8, 6, 2], &HIDDEN, &weights[..]).unwrap();
            let (integer, exact, bound) = outputs(&network, &input);
            for (y, exact) in integer.iter().zip(exact) {
                prop_assert!((y - exact).abs() <= bound, "{} {} bound {}", y, exact, bound);
            }
        }
    }

    #[test]
    fn the_usual_error_is_far_below_the_bound() {
        let weights: Vec<f32> = (0..41).map(|at| (at as f32 * 1.7).sin()).collect();
        let activations = [Activation::Tanh, Activation::Linear];
        let network = Network::new(&[2, 10, 1], &activations, &weights[..]).unwrap();
        let (mut squares, mut worst, mut bound) = (0.0, 0.0_f64, 0.0);
        for at in 0..1000_i32 {
            let input = [at * 7919, at * 104_729].map(|x| i16::try_from(x % 32_768).unwrap());
            let (integer, exact, stated) = outputs(&network, &input);
            let error = integer[0] - exact[0];
            squares += error * error;
            worst = worst.max(error.abs());
            bound = stated;
        }
        let rms = (squares / 1000.0_f64).sqrt();
        eprintln!("2-10-1: rms {rms:.2e}, largest {worst:.2e}, bound {bound:.2e}");
        assert!(rms < 1.5e-4 && worst <= bound && bound < 2e-3, "{rms} {worst} {bound}");
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        let quantize = |activations: &[Activation], weights: &[f32], room: (usize, usize)| {
            let network = Network::new(&[1, 1, 1], activations, weights).unwrap();
            let (mut w, mut b) = (vec![0; room.0], vec![0; room.1]);
            Q15::quantize(&network, &mut w, &mut b).map(|_| ()).unwrap_err()
        };
        let relu = [Activation::Relu, Activation::Linear];
        let tanh = [Activation::Tanh, Activation::Linear];
        assert_eq!(
            quantize(&relu, &[1.0; 4], (2, 2)),
            Q15Error::Unbounded { layer: 0, activation: Activation::Relu }
        );
        assert_eq!(
            quantize(&tanh, &[1.0, 1.0, 1.0, -4e4], (2, 2)),
            Q15Error::TooLarge { layer: 1, largest: 4e4 }
        );
        assert_eq!(
            quantize(&tanh, &[1.0; 4], (2, 1)),
            ShapeError::WeightCount { needed: 4, given: 3 }.into()
        );
        let (weights, biases) = ([1_i16, 2], [3_i32, 4]);
        assert_eq!(
            Q15::new(&[1, 1, 1], &tanh, &[0, 16], &weights, &biases),
            Err(Q15Error::Exponents)
        );
        let network = Q15::new(&[1, 1, 1], &tanh, &[0, 15], &weights, &biases).unwrap();
        assert_eq!(
            network.forward(&[1, 2], &mut [0]),
            Err(ShapeError::Inputs { needed: 1, given: 2 })
        );
    }
}
