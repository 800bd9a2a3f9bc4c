//! Inputs in, outputs of each kind of network out.

use mlp::{
    Activation, Column, DeepMlp, Estimate, Mlp, Model, Network, PredictError, Q15, ScaleError, Scaler,
    ShapeError,
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

/// Two hidden layers of known size, with the exact tanh.
#[unsafe(no_mangle)]
pub fn deep_forward_exact(network: &DeepMlp<2, 8, 6, 1>, input: &[f32; 2]) -> [f32; 1] {
    network.forward_exact(input)
}

/// Any number of layers in double precision.
#[unsafe(no_mangle)]
pub fn network_forward_double(
    network: &Network<&'static [f32]>,
    input: &[f64],
    output: &mut [f64],
) -> Result<(), ShapeError> {
    network.forward_double(input, output)
}

/// Integers only.
#[unsafe(no_mangle)]
pub fn q15_forward(network: &Q15<'_>, input: &[i16], output: &mut [i32]) -> Result<(), ShapeError> {
    network.forward(input, output)
}

/// Turns weights into integers; whether that worked.
#[unsafe(no_mangle)]
pub fn q15_quantize(
    network: &Network<&'static [f32]>,
    weights: &mut [i16],
    biases: &mut [i32],
) -> bool {
    Q15::quantize(network, weights, biases).is_ok()
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
