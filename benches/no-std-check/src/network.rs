//! Inputs in, outputs of each kind of network out.

use mlp::{
    Activation, Column, Estimate, Mlp, Model, Network, PredictError, ScaleError, Scaler, ShapeError,
};

/// One hidden layer of known size.
#[unsafe(no_mangle)]
pub fn mlp_forward(network: &Mlp<2, 10, 1>, input: &[f32; 2]) -> [f32; 1] {
    network.forward(input)
}

/// Any number of layers.
#[unsafe(no_mangle)]
pub fn network_forward(
    network: &Network<&'static [f32]>,
    input: &[f32],
    output: &mut [f32],
) -> Result<(), ShapeError> {
    network.forward(input, output)
}

/// Raw features to a raw target.
#[unsafe(no_mangle)]
pub fn model_estimate(
    model: &Model<&'static [f32]>,
    raw: &[f32],
) -> Result<Estimate, PredictError> {
    model.estimate(raw)
}

/// Checks sizes and weights.
#[unsafe(no_mangle)]
pub fn network_new(
    sizes: &[usize],
    activations: &[Activation],
    weights: &'static [f32],
) -> Result<Network<&'static [f32]>, ShapeError> {
    Network::new(sizes, activations, weights)
}

/// Checks ranges.
#[unsafe(no_mangle)]
pub fn scaler_new(columns: &[Column]) -> Result<Scaler, ScaleError> {
    Scaler::new(columns)
}
