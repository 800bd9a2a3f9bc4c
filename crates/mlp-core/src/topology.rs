//! Checked network shape: layer sizes and activation functions.

use crate::activation::Activation;
use crate::network::{ShapeError, check_sizes, weight_count};

/// Most inputs, and neurons of a hidden layer, of a network that is trained, evaluated or exported. gripd loads fewer
/// ([`MAX_IO`](crate::MAX_IO), [`MAX_WIDTH`](crate::MAX_WIDTH)): it has its memory before it begins.
pub const MOST_INPUTS: usize = 1024;

/// Most outputs of such a network.
pub const MOST_OUTPUTS: usize = 64;

/// Layer sizes and activation functions of a network that is to be trained.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Topology {
    sizes: Vec<usize>,
    activations: Vec<Activation>,
}

impl Topology {
    /// Checks `sizes` (inputs, hidden layers, outputs) and one activation function per layer of weights
    /// against [`MOST_INPUTS`], [`MOST_OUTPUTS`] and the layers of a [`Network`](crate::Network).
    ///
    /// # Errors
    /// [`ShapeError::Layers`], [`ShapeError::Width`] or [`ShapeError::Activations`].
    pub fn new(sizes: &[usize], activations: &[Activation]) -> Result<Self, ShapeError> {
        check_sizes(sizes, activations, MOST_INPUTS)?;
        let (layer, given) = (activations.len(), sizes.last().copied().unwrap_or(0));
        if given > MOST_OUTPUTS {
            return Err(ShapeError::Width { layer, given, limit: MOST_OUTPUTS });
        }
        Ok(Self { sizes: sizes.to_vec(), activations: activations.to_vec() })
    }

    /// Tanh in the hidden layers and linear outputs: the usual shape for regression.
    ///
    /// # Errors
    /// As [`Topology::new`].
    pub fn regression(inputs: usize, hidden: &[usize], outputs: usize) -> Result<Self, ShapeError> {
        Self::with_hidden(inputs, hidden, Activation::Tanh, outputs)
    }

    /// Hidden layers of these widths with one function for all of them, and linear outputs.
    ///
    /// # Errors
    /// As [`Topology::new`].
    pub fn with_hidden(
        inputs: usize,
        widths: &[usize],
        activation: Activation,
        outputs: usize,
    ) -> Result<Self, ShapeError> {
        let sizes: Vec<usize> =
            core::iter::once(inputs).chain(widths.iter().copied()).chain([outputs]).collect();
        let mut activations = vec![activation; widths.len()];
        activations.push(Activation::Linear);
        Self::new(&sizes, &activations)
    }

    /// Inputs, hidden layers, outputs.
    #[must_use]
    pub fn sizes(&self) -> &[usize] {
        &self.sizes
    }

    /// One function per layer of weights.
    #[must_use]
    pub fn activations(&self) -> &[Activation] {
        &self.activations
    }

    /// Number of inputs.
    #[must_use]
    pub fn inputs(&self) -> usize {
        self.sizes[0]
    }

    /// Number of outputs.
    #[must_use]
    pub fn outputs(&self) -> usize {
        self.sizes[self.sizes.len() - 1]
    }

    /// Number of weights and biases.
    #[must_use]
    pub fn weights(&self) -> usize {
        weight_count(&self.sizes)
    }

    /// The layers of weights in flat order.
    #[must_use]
    pub fn layers(&self) -> impl DoubleEndedIterator<Item = Layer> + '_ {
        let mut start = 0;
        let layers: Vec<Layer> = self
            .sizes
            .windows(2)
            .zip(&self.activations)
            .map(|(pair, &activation)| {
                let layer = Layer { start, from: pair[0], to: pair[1], activation };
                start += (layer.from + 1) * layer.to;
                layer
            })
            .collect();
        layers.into_iter()
    }
}

/// One layer of weights and where it lies in the flat order.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Layer {
    /// Place of its first weight.
    pub start: usize,
    /// Width of the layer before.
    pub from: usize,
    /// Number of neurons.
    pub to: usize,
    /// Their function.
    pub activation: Activation,
}

impl Layer {
    /// Place of its first bias.
    #[must_use]
    pub fn biases(&self) -> usize {
        self.start + self.from * self.to
    }

    /// Place behind its last bias.
    #[must_use]
    pub fn end(&self) -> usize {
        self.biases() + self.to
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layers_follow_each_other_without_gaps() {
        let topology = Topology::regression(2, &[10, 3], 1).unwrap();
        let places: Vec<_> =
            topology.layers().map(|layer| (layer.start, layer.biases(), layer.end())).collect();
        assert_eq!(places, [(0, 20, 30), (30, 60, 63), (63, 66, 67)]);
        assert_eq!(topology.weights(), 67);
    }
}
