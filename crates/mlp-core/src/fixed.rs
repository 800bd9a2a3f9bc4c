//! `I` scaled inputs in, `O` scaled outputs out, through one or two hidden layers of sizes known at compile time.

use crate::activation::{Activation, Number};
use crate::network::{LANES, ShapeError, check_finite, joined};

/// One layer of weights with `I` inputs and `O` neurons: `f(W input + b)`.
///
/// Sums run in the order that [`Network`](crate::Network) reports.
#[derive(Debug, Clone, PartialEq)]
pub struct Dense<const I: usize, const O: usize> {
    /// Column by column, so that one input advances all sums together.
    weights: [[f32; O]; I],
    biases: [f32; O],
    activation: Activation,
}

impl<const I: usize, const O: usize> Dense<I, O> {
    /// Number of weights and biases.
    pub const WEIGHTS: usize = O * (I + 1);

    /// Takes the weight matrix row by row (one row per neuron), then the biases.
    ///
    /// # Errors
    /// [`ShapeError::WeightCount`] unless there are [`Self::WEIGHTS`] weights, and
    /// [`ShapeError::NotFinite`] when one of them is NaN or infinite.
    pub fn new(weights: &[f32], activation: Activation) -> Result<Self, ShapeError> {
        let (needed, given) = (Self::WEIGHTS, weights.len());
        if needed != given {
            return Err(ShapeError::WeightCount { needed, given });
        }
        check_finite(weights)?;
        let (matrix, biases) = weights.split_at(O * I);
        Ok(Self {
            weights: core::array::from_fn(|column| {
                core::array::from_fn(|row| matrix[row * I + column])
            }),
            biases: core::array::from_fn(|row| biases[row]),
            activation,
        })
    }

    /// Four neurons at a time go through whole vectors; the last ones beside zeros, a last single one alone.
    #[inline(always)]
    fn sums<N: Number>(&self, input: &[N; I]) -> [N; O] {
        let mut sums = [N::ZERO; O];
        for at in 0..O / 4 {
            let four = self.sums_of(input, |column| {
                column.as_chunks::<4>().0.get(at).copied().unwrap_or([0.0; 4])
            });
            if let Some(place) = sums.as_chunks_mut::<4>().0.get_mut(at) {
                *place = four;
            }
        }
        let rest = sums.as_chunks_mut::<4>().1;
        if let [sum] = rest {
            [*sum] = self.sums_of(input, |column| [column.last().copied().unwrap_or(0.0)]);
        } else if !rest.is_empty() {
            for (sum, y) in rest.iter_mut().zip(self.sums_of(input, padded_end)) {
                *sum = y;
            }
        }
        sums
    }

    /// Weighted sums of the `W` neurons that `pick` takes out of a column, in the order that
    /// [`Network`](crate::Network) reports.
    #[inline(always)]
    fn sums_of<N: Number, const W: usize>(
        &self,
        input: &[N; I],
        pick: impl Fn(&[f32; O]) -> [f32; W],
    ) -> [N; W] {
        let mut lanes = [[N::NOTHING; W]; LANES];
        for (sum, bias) in lanes[0].iter_mut().zip(pick(&self.biases)) {
            *sum = N::from_weight(bias);
        }
        let add = |lane: &mut [N; W], column: &[f32; O], x: N| {
            for (sum, weight) in lane.iter_mut().zip(pick(column)) {
                *sum = *sum + N::from_weight(weight) * x;
            }
        };
        let (columns, last_columns) = self.weights.as_chunks::<LANES>();
        let (inputs, last_inputs) = input.as_chunks::<LANES>();
        for (columns, xs) in columns.iter().zip(inputs) {
            for ((lane, column), x) in lanes.iter_mut().zip(columns).zip(xs) {
                add(lane, column, *x);
            }
        }
        for ((lane, column), x) in lanes.iter_mut().zip(last_columns).zip(last_inputs) {
            add(lane, column, *x);
        }
        let [mut a, b, c, d] = lanes;
        for (((a, b), c), d) in a.iter_mut().zip(b).zip(c).zip(d) {
            *a = joined([*a, b, c, d]);
        }
        a
    }

    /// The outputs for `input`, with [`rational`](crate::tanh::rational) for tanh.
    ///
    /// Never inlined: outputs that pass through memory do so as whole vectors; inlined, compilers split them into the pairs
    /// in which the next layer joins its lanes.
    #[must_use]
    #[inline(never)]
    pub fn forward(&self, input: &[f32; I]) -> [f32; O] {
        let mut sums = self.sums(input);
        self.activation.apply(&mut sums);
        sums
    }

    /// The same with [`exact`](crate::tanh::exact) for tanh.
    #[must_use]
    pub fn forward_exact(&self, input: &[f32; I]) -> [f32; O] {
        let mut sums = self.sums(input);
        self.activation.apply_exact(&mut sums);
        sums
    }

    /// The same in double precision throughout.
    #[must_use]
    pub fn forward_double(&self, input: &[f64; I]) -> [f64; O] {
        let mut sums = self.sums(input);
        self.activation.apply_double(&mut sums);
        sums
    }
}

/// The last values of `column`, as many as do not fill four, and zeros.
#[inline(always)]
fn padded_end<const O: usize>(column: &[f32; O]) -> [f32; 4] {
    let mut four = [0.0; 4];
    for (place, weight) in four.iter_mut().zip(column.as_chunks::<4>().1) {
        *place = *weight;
    }
    four
}

/// A network with one hidden layer whose sizes are known at compile time.
///
/// `output = f_out(V f_hidden(W input + b) + c)` with `W` of shape H x I and `V` of shape O x H. The result
/// equals that of a [`Network`](crate::Network) with the same weights bit for bit.
#[derive(Debug, Clone, PartialEq)]
pub struct Mlp<const I: usize, const H: usize, const O: usize> {
    hidden: Dense<I, H>,
    output: Dense<H, O>,
}

impl<const I: usize, const H: usize, const O: usize> Mlp<I, H, O> {
    /// Number of weights and biases.
    pub const WEIGHTS: usize = Dense::<I, H>::WEIGHTS + Dense::<H, O>::WEIGHTS;

    /// Takes the weights in flat order: for each layer the weight matrix row by row (one row per
    /// neuron), then its biases.
    ///
    /// # Errors
    /// [`ShapeError::WeightCount`] unless there are [`Self::WEIGHTS`] weights, and
    /// [`ShapeError::NotFinite`] when one of them is NaN or infinite.
    pub fn new(
        weights: &[f32],
        hidden: Activation,
        output: Activation,
    ) -> Result<Self, ShapeError> {
        let (first, second) = check(weights, Self::WEIGHTS, Dense::<I, H>::WEIGHTS)?;
        Ok(Self { hidden: Dense::new(first, hidden)?, output: Dense::new(second, output)? })
    }

    /// The outputs for `input`, both in scaled units. Never panics; a NaN or overflow shows in the
    /// outputs.
    #[must_use]
    #[inline]
    pub fn forward(&self, input: &[f32; I]) -> [f32; O] {
        self.output.forward(&self.hidden.forward(input))
    }

    /// The same with [`exact`](crate::tanh::exact) for tanh.
    #[must_use]
    pub fn forward_exact(&self, input: &[f32; I]) -> [f32; O] {
        self.output.forward_exact(&self.hidden.forward_exact(input))
    }

    /// The same in double precision throughout.
    #[must_use]
    pub fn forward_double(&self, input: &[f64; I]) -> [f64; O] {
        self.output.forward_double(&self.hidden.forward_double(input))
    }
}

/// A network with two hidden layers of `H` and `K` neurons whose sizes are known at compile time; otherwise as
/// [`Mlp`].
#[derive(Debug, Clone, PartialEq)]
pub struct DeepMlp<const I: usize, const H: usize, const K: usize, const O: usize> {
    first: Dense<I, H>,
    rest: Mlp<H, K, O>,
}

impl<const I: usize, const H: usize, const K: usize, const O: usize> DeepMlp<I, H, K, O> {
    /// Number of weights and biases.
    pub const WEIGHTS: usize = Dense::<I, H>::WEIGHTS + Mlp::<H, K, O>::WEIGHTS;

    /// Takes the weights in flat order and one function per layer, as [`Mlp::new`].
    ///
    /// # Errors
    /// [`ShapeError::WeightCount`] unless there are [`Self::WEIGHTS`] weights, and
    /// [`ShapeError::NotFinite`] when one of them is NaN or infinite.
    pub fn new(weights: &[f32], activations: [Activation; 3]) -> Result<Self, ShapeError> {
        let (first, rest) = check(weights, Self::WEIGHTS, Dense::<I, H>::WEIGHTS)?;
        let [a, b, c] = activations;
        Ok(Self { first: Dense::new(first, a)?, rest: Mlp::new(rest, b, c)? })
    }

    /// The outputs for `input`, both in scaled units. Never panics; a NaN or overflow shows in the
    /// outputs.
    #[must_use]
    #[inline]
    pub fn forward(&self, input: &[f32; I]) -> [f32; O] {
        self.rest.forward(&self.first.forward(input))
    }

    /// The same with [`exact`](crate::tanh::exact) for tanh.
    #[must_use]
    pub fn forward_exact(&self, input: &[f32; I]) -> [f32; O] {
        self.rest.forward_exact(&self.first.forward_exact(input))
    }

    /// The same in double precision throughout.
    #[must_use]
    pub fn forward_double(&self, input: &[f64; I]) -> [f64; O] {
        self.rest.forward_double(&self.first.forward_double(input))
    }
}

/// Checks all weights, so that errors count from the first, and splits off those of the first layer.
fn check(weights: &[f32], needed: usize, first: usize) -> Result<(&[f32], &[f32]), ShapeError> {
    let missing = ShapeError::WeightCount { needed, given: weights.len() };
    if weights.len() != needed {
        return Err(missing);
    }
    check_finite(weights)?;
    weights.split_at_checked(first).ok_or(missing)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::network::Network;
    use proptest::prelude::*;

    #[test]
    fn hand_computed_two_two_one() {
        // hidden: relu(1*3 + 2*(-1) + 0.5) = 1.5, relu(-1*3 + 4*(-1) + 1) = 0; output: 2*1.5 - 7*0 + 0.25
        let weights = [1.0, 2.0, -1.0, 4.0, 0.5, 1.0, 2.0, -7.0, 0.25];
        let mlp = Mlp::<2, 2, 1>::new(&weights, Activation::Relu, Activation::Linear).unwrap();
        assert_eq!(mlp.forward(&[3.0, -1.0])[0].to_bits(), 3.25_f32.to_bits());
    }

    #[test]
    fn a_wrong_weight_count_or_value_is_refused() {
        let build = |weights: &[f32]| {
            Mlp::<1, 1, 1>::new(weights, Activation::Tanh, Activation::Linear).unwrap_err()
        };
        assert_eq!(build(&[1.0; 3]), ShapeError::WeightCount { needed: 4, given: 3 });
        assert_eq!(build(&[1.0, 2.0, f32::NAN, 0.0]), ShapeError::NotFinite { index: 2 });
    }

    #[test]
    fn two_hidden_layers_equal_the_general_network_in_every_precision() {
        const SIZES: [usize; 4] = [5, 9, 8, 2];
        type Deep = DeepMlp<5, 9, 8, 2>;
        let weights: Vec<f32> =
            (0..Deep::WEIGHTS).map(|at| (at as f32 * 0.37).sin() * 0.8).collect();
        let activations = [Activation::Tanh, Activation::Logistic, Activation::Linear];
        let deep = Deep::new(&weights, activations).unwrap();
        let network = Network::new(&SIZES, &activations, &weights[..]).unwrap();
        let input = [0.3, -0.8, 0.1, 0.9, -0.4];
        let mut general = [0.0; 2];
        network.forward(&input, &mut general).unwrap();
        assert_eq!(deep.forward(&input), general);
        network.forward_exact(&input, &mut general).unwrap();
        assert_eq!(deep.forward_exact(&input), general);
        let (input, mut double) = (input.map(f64::from), [0.0; 2]);
        network.forward_double(&input, &mut double).unwrap();
        assert_eq!(deep.forward_double(&input), double);
        for ((fast, exact), double) in
            deep.forward(&[0.3, -0.8, 0.1, 0.9, -0.4]).iter().zip(general).zip(double)
        {
            assert!((f64::from(*fast) - double).abs() < 2e-6, "{fast} {double}");
            assert!((f64::from(exact) - double).abs() < 6e-7, "{exact} {double}");
        }
        assert_eq!(
            Deep::new(&weights[1..], activations).unwrap_err(),
            ShapeError::WeightCount { needed: Deep::WEIGHTS, given: Deep::WEIGHTS - 1 }
        );
    }

    proptest! {
        #[test]
        fn equals_the_general_network_bit_for_bit(
            weights in prop::collection::vec(-4.0_f32..4.0, Mlp::<3, 7, 2>::WEIGHTS),
            input in prop::array::uniform3(-2.0_f32..2.0),
            hidden in 0_usize..4,
            output in 0_usize..4,
        ) {
            let activations = [Activation::ALL[hidden], Activation::ALL[output]];
            let mlp = Mlp::<3, 7, 2>::new(&weights, activations[0], activations[1]).unwrap();
            let network = Network::new(&[3, 7, 2], &activations, &weights[..]).unwrap();
            let mut general = [0.0; 2];
            network.forward(&input, &mut general).unwrap();
            prop_assert_eq!(mlp.forward(&input).map(f32::to_bits), general.map(f32::to_bits));
        }
    }
}
