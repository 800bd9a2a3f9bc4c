//! The embedded model of the host, its weights in flash.

use mlp_core::{Activation, Column, Model, Network, Scaler, Transform};

include!(concat!(env!("OUT_DIR"), "/embedded.rs"));

/// Weights in flash.
pub type Weights = &'static [f32];

/// The network alone.
pub fn network() -> Option<Network<Weights>> {
    Network::new(&[2, 10, 1], &[Activation::Tanh, Activation::Linear], &WEIGHTS[..]).ok()
}

/// Network and scaling.
pub fn model() -> Option<Model<Weights>> {
    let column = |place: usize, transform| {
        let [min, max] = RANGES[place].map(f64::from);
        Column::new(transform, min, max)
    };
    let inputs = Scaler::new(&[column(0, Transform::Identity), column(1, Transform::Ln)]).ok()?;
    let targets = Scaler::new(&[column(2, Transform::Ln)]).ok()?;
    Model::new(network()?, inputs, targets).ok()
}
