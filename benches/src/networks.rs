//! Networks with repeatable weights, and a training.

use mlp::{
    Activation, Column, Model, Network, Scaler, ShapeError, Transform,
    train::{Topology, init::nguyen_widrow},
    weight_count,
};
use ndarray::{Array2, aview1};
use rand_chacha::ChaCha8Rng;
use rand_core::{Rng as _, SeedableRng};
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

/// A training: made-up rows in the shape of Proben1's building1 (2104 rows, 14-16-3: tanh, then linear) and starting weights.
#[derive(Clone, Debug)]
pub struct Training {
    /// Shape.
    pub topology: Topology,
    /// Inputs of the rows in [-1, 1].
    pub inputs: Array2<f64>,
    /// Their targets in [-1, 1].
    pub targets: Array2<f64>,
    /// Starting weights.
    pub weights: Vec<f64>,
}

/// The training of building1.
///
/// # Errors
/// Never: the shape is possible.
pub fn building() -> Result<Training, ShapeError> {
    let mut rng = ChaCha8Rng::seed_from_u64(12);
    let mut uniform = || f64::from(rng.next_u32()) / 2_147_483_648.0 - 1.0;
    let inputs = Array2::from_shape_simple_fn((2104, 14), &mut uniform);
    let mut targets = Array2::zeros((2104, 3));
    for (row, mut target) in inputs.rows().into_iter().zip(targets.rows_mut()) {
        let sum = |step: usize| row.iter().step_by(step).sum::<f64>() / 4.0;
        let wanted = [sum(2).tanh(), (sum(3) * row[1]).sin(), 0.5 * (sum(5) - row[7])];
        target.assign(&aview1(&wanted));
    }
    let topology = Topology::regression(14, &[16], 3)?;
    let weights = nguyen_widrow(&topology, 1);
    Ok(Training { topology, inputs, targets, weights })
}
