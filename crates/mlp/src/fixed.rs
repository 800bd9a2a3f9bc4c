//! `I` scaled inputs in, `O` scaled outputs out, through one hidden layer of `H` neurons.

use crate::activation::Activation;
use crate::network::{ShapeError, check_finite};

/// A network with one hidden layer whose sizes are known at compile time.
///
/// `output = f_out(V f_hidden(W input + b) + c)` with `W` of shape H x I and `V` of shape O x H. Every
/// sum starts at the bias and runs over the inputs in order, so the result equals that of a
/// [`Network`](crate::Network) with the same weights bit for bit.
#[derive(Debug, Clone, PartialEq)]
pub struct Mlp<const I: usize, const H: usize, const O: usize> {
    /// Column by column, so that one input advances all hidden sums together.
    hidden_weights: [[f32; H]; I],
    hidden_biases: [f32; H],
    output_weights: [[f32; O]; H],
    output_biases: [f32; O],
    hidden: Activation,
    output: Activation,
}

impl<const I: usize, const H: usize, const O: usize> Mlp<I, H, O> {
    /// Number of weights and biases.
    pub const WEIGHTS: usize = H * (I + 1) + O * (H + 1);

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
        if weights.len() != Self::WEIGHTS {
            return Err(ShapeError::WeightCount { needed: Self::WEIGHTS, given: weights.len() });
        }
        check_finite(weights)?;
        let (hidden_weights, rest) = weights.split_at(H * I);
        let (hidden_biases, rest) = rest.split_at(H);
        let (output_weights, output_biases) = rest.split_at(O * H);
        Ok(Self {
            hidden_weights: columns(hidden_weights),
            hidden_biases: core::array::from_fn(|row| hidden_biases[row]),
            output_weights: columns(output_weights),
            output_biases: core::array::from_fn(|row| output_biases[row]),
            hidden,
            output,
        })
    }

    /// The outputs for `input`, both in scaled units. Never panics; a NaN or overflow shows in the
    /// outputs.
    #[must_use]
    pub fn forward(&self, input: &[f32; I]) -> [f32; O] {
        let mut hidden = weighted_sums(&self.hidden_weights, &self.hidden_biases, input);
        self.hidden.apply(&mut hidden);
        let mut output = weighted_sums(&self.output_weights, &self.output_biases, &hidden);
        self.output.apply(&mut output);
        output
    }
}

/// Turns a matrix stored row by row into its columns. `flat` holds `ROWS * COLUMNS` values.
fn columns<const ROWS: usize, const COLUMNS: usize>(flat: &[f32]) -> [[f32; ROWS]; COLUMNS] {
    core::array::from_fn(|column| core::array::from_fn(|row| flat[row * COLUMNS + column]))
}

#[inline]
fn weighted_sums<const N: usize, const M: usize>(
    columns: &[[f32; M]; N],
    biases: &[f32; M],
    input: &[f32; N],
) -> [f32; M] {
    let mut sums = *biases;
    for (column, x) in columns.iter().zip(input) {
        for (sum, weight) in sums.iter_mut().zip(column) {
            *sum += weight * x;
        }
    }
    sums
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
