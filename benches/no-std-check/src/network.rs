//! Exported functions of each kind of network, from inputs to outputs.

use mlp_core::{
    Activation, Column, Estimate, Model, Network, PredictError, ScaleError, Scaler, ShapeError,
    tanh,
};

/// Every tanh.
#[unsafe(no_mangle)]
pub fn tanh_of_each_kind(x: f32) -> f64 {
    f64::from(tanh::rational(x)) + f64::from(tanh::exact(x)) + tanh::double(f64::from(x))
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

/// The same with the exact tanh.
#[unsafe(no_mangle)]
pub fn network_forward_exact(
    network: &Network<&'static [f32]>,
    input: &[f32],
    output: &mut [f32],
) -> Result<(), ShapeError> {
    network.forward_exact(input, output)
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
