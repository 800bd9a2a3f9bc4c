//! Network from scaled inputs to scaled outputs, through any number of hidden layers.

use crate::activation::{Activation, Number};
use crate::tanh;

/// Largest number of layers of weights: up to three hidden layers and the output layer.
pub const MAX_LAYERS: usize = 4;

/// Largest number of inputs, outputs or neurons of one layer, where no other is asked for.
pub const MAX_WIDTH: usize = 64;

/// Why sizes, weights and slices do not fit together.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum ShapeError {
    /// Fewer than one or more than [`MAX_LAYERS`] layers of weights.
    #[error("{given} sizes: a network has 2 to {max} of them", max = MAX_LAYERS + 1)]
    Layers {
        /// Number of sizes given: inputs, hidden layers, outputs.
        given: usize,
    },
    /// A layer without neurons or with too many.
    #[error("layer {layer} has {given} neurons: it may have 1 to {limit}")]
    Width {
        /// 0 for the inputs.
        layer: usize,
        /// Its size.
        given: usize,
        /// Its largest size.
        limit: usize,
    },
    /// Not one activation function per layer of weights.
    #[error("{given} activation functions for {needed} layers")]
    Activations {
        /// Layers of weights.
        needed: usize,
        /// Functions given.
        given: usize,
    },
    /// Too few or too many weights.
    #[error("{given} weights where the layers need {needed}")]
    WeightCount {
        /// Weights and biases of all layers.
        needed: usize,
        /// Weights given.
        given: usize,
    },
    /// A weight is NaN or infinite.
    #[error("weight {index} is not finite")]
    NotFinite {
        /// Its place in the flat order.
        index: usize,
    },
    /// Wrong number of inputs.
    #[error("{given} inputs where {needed} are needed")]
    Inputs {
        /// Inputs of the network.
        needed: usize,
        /// Inputs given.
        given: usize,
    },
    /// Wrong number of outputs.
    #[error("room or columns for {given} outputs where there are {needed}")]
    Outputs {
        /// Outputs of the network.
        needed: usize,
        /// Room given.
        given: usize,
    },
    /// No rows, or not as many of inputs as of outputs.
    #[error(
        "{inputs} rows of inputs and {outputs} of outputs: as many of both are needed, at least one"
    )]
    Rows {
        /// Rows of inputs given.
        inputs: usize,
        /// Rows of outputs given.
        outputs: usize,
    },
}

/// Number of weights and biases of a network with these layer sizes (inputs first); saturates.
#[must_use]
pub fn weight_count(sizes: &[usize]) -> usize {
    let layers = sizes.windows(2).map(|pair| pair[0].saturating_add(1).saturating_mul(pair[1]));
    layers.fold(0, usize::saturating_add)
}

pub(crate) fn check_sizes(
    sizes: &[usize],
    activations: &[Activation],
    limit: usize,
) -> Result<(), ShapeError> {
    if !(2..=MAX_LAYERS + 1).contains(&sizes.len()) {
        return Err(ShapeError::Layers { given: sizes.len() });
    }
    for (layer, &given) in sizes.iter().enumerate() {
        if !(1..=limit).contains(&given) {
            return Err(ShapeError::Width { layer, given, limit });
        }
    }
    if activations.len() != sizes.len() - 1 {
        return Err(ShapeError::Activations { needed: sizes.len() - 1, given: activations.len() });
    }
    Ok(())
}

/// A feed-forward network whose weights lie in one flat slice.
///
/// Layer `k` computes `x_k = f_k(W_k x_(k-1) + b_k)`. `W` holds for each layer the matrix row by row (one
/// row per neuron), then the biases. It may be a `&'static [f32]` in flash or a `Box<[f32]>`.
///
/// A weighted sum runs in four lanes `a`, `b`, `c`, `d`: lane `a` starts at the bias, input `i` goes to lane `i mod 4`, and the sum
/// is `(a + c) + (b + d)`.
///
/// No layer is wider than `WIDTH`; a pass needs twice that room on the stack.
#[derive(Debug, Clone, PartialEq)]
pub struct Network<W, const WIDTH: usize = MAX_WIDTH> {
    sizes: [usize; MAX_LAYERS + 1],
    activations: [Activation; MAX_LAYERS],
    layers: usize,
    weights: W,
}

impl<W: AsRef<[f32]>> Network<W> {
    /// Checks that `sizes` (inputs, hidden layers, outputs), `activations` (one per layer of weights)
    /// and `weights` fit together.
    ///
    /// # Errors
    /// The first [`ShapeError`] found; weights must be finite.
    pub fn new(
        sizes: &[usize],
        activations: &[Activation],
        weights: W,
    ) -> Result<Self, ShapeError> {
        Self::within(sizes, activations, weights)
    }
}

impl<W: AsRef<[f32]>, const WIDTH: usize> Network<W, WIDTH> {
    /// As [`Network::new`], for layers of up to `WIDTH` neurons.
    ///
    /// # Errors
    /// As [`Network::new`].
    pub fn within(
        sizes: &[usize],
        activations: &[Activation],
        weights: W,
    ) -> Result<Self, ShapeError> {
        check_sizes(sizes, activations, WIDTH)?;
        let (needed, given) = (weight_count(sizes), weights.as_ref().len());
        if needed != given {
            return Err(ShapeError::WeightCount { needed, given });
        }
        if let Some(index) = weights.as_ref().iter().position(|weight| !weight.is_finite()) {
            return Err(ShapeError::NotFinite { index });
        }
        let mut network = Self {
            sizes: [0; MAX_LAYERS + 1],
            activations: [Activation::Linear; MAX_LAYERS],
            layers: activations.len(),
            weights,
        };
        for (place, size) in network.sizes.iter_mut().zip(sizes) {
            *place = *size;
        }
        for (place, activation) in network.activations.iter_mut().zip(activations) {
            *place = *activation;
        }
        Ok(network)
    }

    /// Layer sizes: inputs, hidden layers, outputs.
    #[must_use]
    pub fn sizes(&self) -> &[usize] {
        self.sizes.get(..=self.layers).unwrap_or(&self.sizes)
    }

    /// One activation function per layer of weights.
    #[must_use]
    pub fn activations(&self) -> &[Activation] {
        self.activations.get(..self.layers).unwrap_or(&self.activations)
    }

    /// Number of inputs.
    #[must_use]
    pub fn inputs(&self) -> usize {
        self.sizes[0]
    }

    /// Number of outputs.
    #[must_use]
    pub fn outputs(&self) -> usize {
        self.sizes().last().copied().unwrap_or(0)
    }

    /// All weights in flat order.
    #[must_use]
    pub fn weights(&self) -> &[f32] {
        self.weights.as_ref()
    }

    /// Computes the outputs for `input`, both in scaled units.
    ///
    /// Allocates nothing and never panics. A NaN input or an overflow shows in the outputs, which the
    /// caller checks ([`Model`](crate::Model) does). Tanh is [`rational`](crate::tanh::rational).
    ///
    /// # Errors
    /// [`ShapeError::Inputs`] or [`ShapeError::Outputs`] for a slice of the wrong length;
    /// [`ShapeError::WeightCount`] when `W` no longer shows as many weights as it did.
    pub fn forward(&self, input: &[f32], output: &mut [f32]) -> Result<(), ShapeError> {
        self.pass(input, output, tanh::rational)
    }

    /// As [`forward`](Self::forward), with [`exact`](crate::tanh::exact) for tanh.
    ///
    /// # Errors
    /// As [`forward`](Self::forward).
    pub fn forward_exact(&self, input: &[f32], output: &mut [f32]) -> Result<(), ShapeError> {
        self.pass(input, output, tanh::exact)
    }

    /// As [`forward`](Self::forward), in double precision throughout.
    ///
    /// # Errors
    /// As [`forward`](Self::forward).
    pub fn forward_double(&self, input: &[f64], output: &mut [f64]) -> Result<(), ShapeError> {
        self.pass(input, output, tanh::double)
    }

    #[inline(always)]
    fn pass<N: Number>(
        &self,
        input: &[N],
        output: &mut [N],
        tanh: impl Fn(N) -> N,
    ) -> Result<(), ShapeError> {
        if input.len() != self.inputs() {
            return Err(ShapeError::Inputs { needed: self.inputs(), given: input.len() });
        }
        if output.len() != self.outputs() {
            return Err(ShapeError::Outputs { needed: self.outputs(), given: output.len() });
        }
        let mut weights = self.weights.as_ref();
        let given = weights.len();
        let mut current = [N::ZERO; WIDTH];
        let mut next = [N::ZERO; WIDTH];
        for (place, x) in current.iter_mut().zip(input) {
            *place = *x;
        }
        for (pair, activation) in self.sizes().windows(2).zip(self.activations()) {
            let &[from, to] = pair else { continue };
            let missing = ShapeError::WeightCount { needed: weight_count(self.sizes()), given };
            let (matrix, rest) = weights.split_at_checked(from * to).ok_or(missing)?;
            let (biases, rest) = rest.split_at_checked(to).ok_or(missing)?;
            weights = rest;
            let sums = next.get_mut(..to).unwrap_or(&mut []);
            weighted_sums(matrix, biases, current.get(..from).unwrap_or(&[]), sums);
            activation.apply(sums, &tanh);
            core::mem::swap(&mut current, &mut next);
        }
        for (place, x) in output.iter_mut().zip(current) {
            *place = x;
        }
        Ok(())
    }
}

/// Partial sums of a neuron, so that one addition does not wait for the one before.
const LANES: usize = 4;

/// The weighted sums of a layer. `from` is not empty.
#[inline(always)]
fn weighted_sums<N: Number>(matrix: &[f32], biases: &[f32], from: &[N], to: &mut [N]) {
    let rows = matrix.chunks_exact(from.len().max(1)).zip(biases);
    let (whole, rest) = from.as_chunks::<LANES>();
    for (sum, (row, bias)) in to.iter_mut().zip(rows) {
        // Adding -0 changes nothing, not even the sign of a zero, so that compilers leave the addition out.
        let mut lanes = [-N::ZERO; LANES];
        lanes[0] = N::from_single(*bias);
        let (weights, last) = row.as_chunks::<LANES>();
        for (weights, xs) in weights.iter().zip(whole) {
            for ((lane, weight), x) in lanes.iter_mut().zip(weights).zip(xs) {
                *lane = *lane + N::from_single(*weight) * *x;
            }
        }
        for ((lane, weight), x) in lanes.iter_mut().zip(last).zip(rest) {
            *lane = *lane + N::from_single(*weight) * *x;
        }
        let [a, b, c, d] = lanes;
        *sum = (a + c) + (b + d);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const TANH_LINEAR: [Activation; 2] = [Activation::Tanh, Activation::Linear];

    #[test]
    fn hand_computed_two_hidden_layers() {
        // 1 -> relu(2*1.5 - 1) = 2 -> linear(-3*2 + 0.5) = -5.5 -> relu(5.5) via weight -1
        let weights = [2.0, -1.0, -3.0, 0.5, -1.0, 0.0];
        let activations = [Activation::Relu, Activation::Linear, Activation::Relu];
        let network = Network::new(&[1, 1, 1, 1], &activations, weights).unwrap();
        let mut output = [0.0];
        network.forward(&[1.5], &mut output).unwrap();
        assert_eq!(output[0].to_bits(), 5.5_f32.to_bits());
    }

    #[test]
    fn shapes_that_do_not_fit_are_named() {
        let new = |sizes: &[usize], activations: &[Activation], count: usize| {
            Network::new(sizes, activations, vec![0.5_f32; count]).unwrap_err()
        };
        assert_eq!(new(&[2], &[], 0), ShapeError::Layers { given: 1 });
        assert_eq!(new(&[1; 6], &[Activation::Tanh; 5], 10), ShapeError::Layers { given: 6 });
        assert_eq!(
            new(&[2, 0, 1], &TANH_LINEAR, 1),
            ShapeError::Width { layer: 1, given: 0, limit: 64 }
        );
        assert_eq!(
            new(&[2, 65, 1], &TANH_LINEAR, 1),
            ShapeError::Width { layer: 1, given: 65, limit: 64 }
        );
        assert_eq!(
            new(&[2, 3, 1], &[Activation::Tanh], 13),
            ShapeError::Activations { needed: 2, given: 1 }
        );
        assert_eq!(
            new(&[2, 3, 1], &TANH_LINEAR, 12),
            ShapeError::WeightCount { needed: 13, given: 12 }
        );
    }

    #[test]
    fn slices_of_the_wrong_length_are_refused() {
        let network = Network::new(&[2, 3, 1], &TANH_LINEAR, [0.1_f32; 13]).unwrap();
        let short = network.forward(&[1.0], &mut [0.0]).unwrap_err();
        assert_eq!(short, ShapeError::Inputs { needed: 2, given: 1 });
        let long = network.forward(&[1.0, 2.0], &mut [0.0; 2]).unwrap_err();
        assert_eq!(long, ShapeError::Outputs { needed: 1, given: 2 });
    }

    proptest! {
        #[test]
        fn any_finite_weights_and_any_input_never_panic(
            sizes in prop::collection::vec(1_usize..=MAX_WIDTH, 2..=MAX_LAYERS + 1),
            value in prop::num::f32::NORMAL,
            x in prop::num::f32::ANY,
        ) {
            let activations = vec![Activation::Tanh; sizes.len() - 1];
            let weights = vec![value; weight_count(&sizes)];
            let network = Network::new(&sizes, &activations, weights).unwrap();
            let mut output = vec![0.0; network.outputs()];
            network.forward(&vec![x; network.inputs()], &mut output).unwrap();
            prop_assert!(output.iter().all(|y| y.is_nan() || y.abs() <= 1.0));
        }
    }
}
