//! Inputs in, outputs of each kind of network out.

use mlp_core::{
    Activation, Column, DeepMlp, Dense, Estimate, Mlp, Model, Network, PredictError,
    ScaleError, Scaler, ShapeError, tanh,
};

/// One hidden layer of known size.
#[unsafe(no_mangle)]
pub fn mlp_forward(network: &Mlp<2, 10, 1>, input: &[f32; 2]) -> [f32; 1] {
    network.forward(input)
}

/// The same with the exact tanh.
#[unsafe(no_mangle)]
pub fn mlp_forward_exact(network: &Mlp<2, 10, 1>, input: &[f32; 2]) -> [f32; 1] {
    network.forward_exact(input)
}

/// The same in double precision.
#[unsafe(no_mangle)]
pub fn mlp_forward_double(network: &Mlp<2, 10, 1>, input: &[f64; 2]) -> [f64; 1] {
    network.forward_double(input)
}

/// Checks weights.
#[unsafe(no_mangle)]
pub fn mlp_new(weights: &[f32], activations: [Activation; 2]) -> Result<Mlp<2, 10, 1>, ShapeError> {
    let [hidden, output] = activations;
    Mlp::new(weights, hidden, output)
}

/// One layer.
#[unsafe(no_mangle)]
pub fn dense_new(weights: &[f32], activation: Activation) -> Result<Dense<3, 4>, ShapeError> {
    Dense::new(weights, activation)
}

/// One layer in each precision; the sum shows that all three are needed.
#[unsafe(no_mangle)]
pub fn dense_forward(layer: &Dense<3, 4>, input: &[f32; 3]) -> f64 {
    let [fast, ..] = layer.forward(input);
    let [exact, ..] = layer.forward_exact(input);
    let [double, ..] = layer.forward_double(&input.map(f64::from));
    f64::from(fast) + f64::from(exact) + double
}

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

/// Checks weights of two hidden layers of known size.
#[unsafe(no_mangle)]
pub fn deep_new(
    weights: &[f32],
    activations: [Activation; 3],
) -> Result<DeepMlp<2, 8, 6, 1>, ShapeError> {
    DeepMlp::new(weights, activations)
}

/// Two hidden layers of known size.
#[unsafe(no_mangle)]
pub fn deep_forward(network: &DeepMlp<2, 8, 6, 1>, input: &[f32; 2]) -> [f32; 1] {
    network.forward(input)
}

/// The same in double precision.
#[unsafe(no_mangle)]
pub fn deep_forward_double(network: &DeepMlp<2, 8, 6, 1>, input: &[f64; 2]) -> [f64; 1] {
    network.forward_double(input)
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
