//! Networks of given layer sizes with repeatable weights.

use mlp::{Activation, Column, Model, Network, Scaler, ShapeError, Transform, weight_count};
use rand_chacha::ChaCha8Rng;
use rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

/// `count` weights from N(0, 1/4).
#[must_use]
pub fn weights(count: usize) -> Vec<f32> {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    StandardNormal.sample_iter(&mut rng).map(|weight: f32| 0.5 * weight).take(count).collect()
}

/// A network of `sizes` (inputs first): tanh in the hidden layers, linear at the end.
///
/// # Errors
/// Where there are too many layers or neurons.
pub fn network(sizes: &[usize]) -> Result<Network<Box<[f32]>>, ShapeError> {
    let mut activations = vec![Activation::Tanh; sizes.len().saturating_sub(1)];
    if let Some(last) = activations.last_mut() {
        *last = Activation::Linear;
    }
    Network::new(sizes, &activations, weights(weight_count(sizes)).into())
}

/// A 2-10-1 model with the scaling of the embedded one: acceleration as it is, both forces as logarithms.
///
/// # Errors
/// Never: the shape and the ranges fit.
pub fn model() -> anyhow::Result<Model<Box<[f32]>>> {
    let acceleration = Column::new(Transform::Identity, -12.0, 9.5);
    let force = Column::new(Transform::Ln, 0.1, 50.0);
    let (inputs, targets) = (Scaler::new(&[acceleration, force])?, Scaler::new(&[force])?);
    Ok(Model::new(network(&[2, 10, 1])?, inputs, targets)?)
}
