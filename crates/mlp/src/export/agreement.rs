//! Bound on how far another implementation in `f32` may differ from ours, for a model and features.
//!
//! Differences are reported in scaled units (the training range of a target is 2 wide), so that targets of any unit and all
//! transforms compare. The bound adds up the worst roundings of both implementations: each operation and each of `logf`,
//! `expf` and tanh may be 2^-22 off (two units in the last place, four at the start of a binade), errors grow through a layer with the largest row sum of
//! its weights, and tanh and the logistic function keep them below the width of their range. It holds for sums in any order.

use crate::activation::Activation;
use crate::model::Model;
use crate::model::{Axis, Transform};
use crate::network::weight_count;

/// Relative error of one operation.
const UNIT: f64 = 1.0 / 4_194_304.0;

/// The scaled difference of `left` and `right`, both raw values of target `target`; 0 where there is no such target or it is
/// constant, and for results of a logarithmic target too small for normal numbers.
#[must_use]
pub fn difference<W: AsRef<[f32]>, const IO: usize, const WIDTH: usize>(
    model: &Model<W, IO, WIDTH>,
    target: usize,
    left: f32,
    right: f32,
) -> f64 {
    let Some(axis) = model.targets().axes().get(target) else { return 0.0 };
    if axis.is_constant() {
        return f64::from((left - right).abs());
    }
    let span = f64::from(axis.half_span);
    if axis.column.transform == Transform::Ln && left.max(right) < 2.0 * f32::MIN_POSITIVE {
        return 0.0;
    }
    let [left, right] = [left, right].map(|raw| axis.column.transform.forward(f64::from(raw)));
    ((left - right) / span).abs()
}

/// The largest [`difference`] of each target that rounding explains for the features `raw`, which must have an answer.
#[must_use]
pub fn bounds<W: AsRef<[f32]>, const IO: usize, const WIDTH: usize>(
    model: &Model<W, IO, WIDTH>,
    raw: &[f32],
) -> Vec<f64> {
    let mut state = State { size: 0.0, error: 0.0 };
    for (axis, &value) in model.inputs().axes().iter().zip(raw) {
        state = state.joined(scaled(axis, value));
    }
    let network = model.network();
    let mut weights = network.weights();
    for (pair, activation) in network.sizes().windows(2).zip(network.activations()) {
        let &[from, to] = pair else { continue };
        let (layer, rest) = weights.split_at(weight_count(pair));
        weights = rest;
        let (matrix, biases) = layer.split_at(from * to);
        state = state.through(matrix, biases).after(*activation);
    }
    let error = |axis: &Axis| match axis.is_constant() {
        true => UNIT * f64::from(axis.minimum().abs()),
        false => state.error + UNIT * unscaling(axis, state.size),
    };
    model.targets().axes().iter().map(error).collect()
}

/// The largest difference of a probability, where those of the scores have these `bounds`: it changes by at most 2 p (1 - p) times
/// the largest change of a score, and softmax has roundings of its own.
#[must_use]
pub fn probability_bound(bounds: &[f64]) -> f64 {
    let largest = bounds.iter().copied().fold(0.0, f64::max);
    0.5 * largest + UNIT * count(bounds.len() + 8)
}

/// Largest size of the values of a layer, and largest difference of two computations of one.
#[derive(Debug, Clone, Copy)]
struct State {
    size: f64,
    error: f64,
}

impl State {
    fn joined(self, other: Self) -> Self {
        Self { size: self.size.max(other.size), error: self.error.max(other.error) }
    }

    fn through(self, matrix: &[f32], biases: &[f32]) -> Self {
        let from = matrix.len() / biases.len().max(1);
        let sum = |row: &[f32]| row.iter().map(|weight| f64::from(weight.abs())).sum::<f64>();
        let heaviest = matrix.chunks_exact(from.max(1)).map(sum).fold(0.0, f64::max);
        let bias = biases.iter().map(|bias| f64::from(bias.abs())).fold(0.0, f64::max);
        let size = heaviest * self.size + bias;
        // As many roundings of 2^-24 in a sum as it has terms, in both computations.
        let roundings = 0.5 * count(from + 1) * UNIT * size;
        Self { size, error: heaviest * self.error + roundings }
    }

    fn after(self, activation: Activation) -> Self {
        match activation {
            Activation::Linear | Activation::Relu => self,
            Activation::Tanh => Self { size: 1.0, error: self.error.min(2.0) + 2.0 * UNIT },
            Activation::Logistic => {
                Self { size: 1.0, error: (0.25 * self.error).min(1.0) + 2.0 * UNIT }
            }
        }
    }
}

fn count(n: usize) -> f64 {
    f64::from(u32::try_from(n).unwrap_or(u32::MAX))
}

fn scaled(axis: &Axis, raw: f32) -> State {
    if axis.is_constant() {
        return State { size: 0.0, error: 0.0 };
    }
    let raw = f64::from(raw);
    let value = axis.column.transform.forward(raw);
    let (low, half_span) = (f64::from(axis.low), f64::from(axis.half_span));
    let size = ((value - low) / half_span - 1.0).abs();
    State { size, error: UNIT * ((value.abs() + low.abs()) / half_span + size + 2.0) }
}

/// Roundings of the way back to a raw value, in units of [`UNIT`] and scaled.
fn unscaling(axis: &Axis, size: f64) -> f64 {
    // A reciprocal takes five operations on values of up to twice the size.
    let [factor, exponential] = match axis.column.transform {
        Transform::Identity => [2.0, 0.0],
        Transform::Ln => [2.0, 2.0],
        Transform::Reciprocal => [6.0, 0.0],
    };
    let (low, half_span) = (f64::from(axis.low.abs()), f64::from(axis.half_span));
    (factor * low + exponential) / half_span + factor * size + 2.0 * factor
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Column, Scaler};
    use crate::network::Network;

    fn model(activation: Activation, transform: Transform) -> Model<Vec<f32>> {
        let sizes = [2, 9, 1];
        let weights: Vec<f32> =
            (0..weight_count(&sizes)).map(|at| (at as f32 * 1.7).sin()).collect();
        let network = Network::new(&sizes, &[activation, Activation::Linear], weights).unwrap();
        let column = Column { noise: 0.1, ..Column::new(transform, 0.5, 40.0) };
        let inputs = Scaler::new(&[column; 2]).unwrap();
        Model::new(network, inputs, Scaler::new(&[column]).unwrap()).unwrap()
    }

    #[test]
    fn rational_and_exact_tanh_agree_within_the_bound_and_the_bound_is_small() {
        for activation in Activation::ALL {
            for transform in Transform::ALL {
                let model = model(activation, transform);
                let mut worst = 0.0_f64;
                for step in 0..200_u16 {
                    let raw = [0.5 + 0.19 * f32::from(step), 40.0 - 0.15 * f32::from(step)];
                    let [a, b] = raw.map(|x| model.inputs().axes()[0].scaled(x).unwrap());
                    let mut exact = [0.0];
                    model.network().forward_exact(&[a, b], &mut exact).unwrap();
                    let exact = model.targets().axes()[0].raw(exact[0]);
                    let ours = model.estimate(&raw).unwrap().value;
                    let allowed = bounds(&model, &raw)[0];
                    let found = difference(&model, 0, ours, exact);
                    assert!(
                        found <= allowed,
                        "{activation} {transform} {raw:?}: {found} {allowed}"
                    );
                    worst = worst.max(allowed);
                }
                assert!(worst < 1e-4, "{activation} {transform}: {worst}");
            }
        }
    }

    #[test]
    fn a_wrong_weight_exceeds_the_bound() {
        let model = model(Activation::Tanh, Transform::Identity);
        let mut weights = model.network().weights().to_vec();
        weights[20] += 1e-3;
        let activations = [Activation::Tanh, Activation::Linear];
        let other = Network::new(&[2, 9, 1], &activations, weights).unwrap();
        let other = Model::new(other, model.inputs().clone(), model.targets().clone()).unwrap();
        let raw = [12.0, 3.0];
        let [left, right] = [&model, &other].map(|model| model.estimate(&raw).unwrap().value);
        assert!(difference(&model, 0, left, right) > bounds(&model, &raw)[0], "{left} {right}");
    }
}
