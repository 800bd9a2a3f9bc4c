//! Weights in, mean squared error over scaled rows and its derivatives out.

use super::data::Patterns;
use super::topology::Topology;
use crate::network::ShapeError;

mod block;
mod tanh;

use block::{Block, Tape};

/// What the trainers minimise: a sum of squared residuals, seen as its mean.
///
/// Weights are in the flat order of [`Network`](crate::Network). With residuals `e` (output minus target),
/// `n` of them over rows and targets, `mse = sum e^2 / n`. Implementations keep scratch memory, hence
/// `&mut self`; equal weights give equal results.
pub trait Objective {
    /// Number of weights.
    fn weights(&self) -> usize;

    /// Number of residuals: rows times targets.
    fn residuals(&self) -> usize;

    /// The mean squared error.
    fn mse(&mut self, weights: &[f64]) -> f64;

    /// The mean squared error; writes `d mse / d weight` to `gradient`, which carries the factor `2 / n`.
    fn gradient(&mut self, weights: &[f64], gradient: &mut [f64]) -> f64;

    /// The mean squared error; writes `J'e` to `projected` and the lower triangle of `J'J`, row by row in a
    /// square matrix, to `normal`, with `J[k][w] = d e_k / d weight_w`. Neither is divided by `n`.
    fn normal_equations(
        &mut self,
        weights: &[f64],
        normal: &mut [f64],
        projected: &mut [f64],
    ) -> f64;
}

/// The objective of a feed-forward network in double precision.
///
/// Rows are kept in blocks of up to 128, transposed so that all rows of a block advance together through a
/// neuron in plain loops over 8 lanes.
#[derive(Debug, Clone)]
pub struct NetworkObjective {
    topology: Topology,
    rows: usize,
    blocks: Vec<Block>,
    tape: Tape,
}

impl NetworkObjective {
    /// Lays out the scaled rows for `topology`.
    ///
    /// # Errors
    /// [`ShapeError::Inputs`] or [`ShapeError::Outputs`] when the values do not divide into at least one row
    /// of the topology's width, with the numbers of values.
    pub fn new(topology: &Topology, patterns: &Patterns) -> Result<Self, ShapeError> {
        let (inputs, outputs) = (topology.inputs(), topology.outputs());
        let rows = patterns.inputs.len() / inputs;
        if rows == 0 || patterns.inputs.len() != rows * inputs {
            let needed = rows.max(1) * inputs;
            return Err(ShapeError::Inputs { needed, given: patterns.inputs.len() });
        }
        if patterns.targets.len() != rows * outputs {
            let needed = rows * outputs;
            return Err(ShapeError::Outputs { needed, given: patterns.targets.len() });
        }
        let blocks = patterns
            .inputs
            .chunks(block::ROWS * inputs)
            .zip(patterns.targets.chunks(block::ROWS * outputs))
            .map(|(x, y)| Block::new(x, inputs, y, outputs))
            .collect();
        Ok(Self { topology: topology.clone(), rows, blocks, tape: Tape::new(topology) })
    }

    /// The network's shape.
    #[must_use]
    pub fn topology(&self) -> &Topology {
        &self.topology
    }

    /// Number of rows.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.rows
    }

    fn mean(&self, sum: f64) -> f64 {
        sum / count(self.residuals())
    }
}

/// Counts stay far below 2^53.
pub(super) fn count(n: usize) -> f64 {
    n as f64
}

impl Objective for NetworkObjective {
    fn weights(&self) -> usize {
        self.topology.weights()
    }

    fn residuals(&self) -> usize {
        self.rows * self.topology.outputs()
    }

    fn mse(&mut self, weights: &[f64]) -> f64 {
        let sum = self.blocks.iter().map(|block| self.tape.forward(block, weights)).sum();
        self.mean(sum)
    }

    fn gradient(&mut self, weights: &[f64], gradient: &mut [f64]) -> f64 {
        gradient.fill(0.0);
        let mut sum = 0.0;
        for block in &self.blocks {
            sum += self.tape.forward(block, weights);
            self.tape.start_at_residuals();
            self.tape.backward(weights, &mut |weight, value| gradient[weight] += value.sum());
        }
        let factor = 2.0 / count(self.residuals());
        gradient.iter_mut().for_each(|g| *g *= factor);
        self.mean(sum)
    }

    fn normal_equations(
        &mut self,
        weights: &[f64],
        normal: &mut [f64],
        projected: &mut [f64],
    ) -> f64 {
        normal.fill(0.0);
        projected.fill(0.0);
        let mut sum = 0.0;
        for block in &self.blocks {
            sum += self.tape.forward(block, weights);
            for output in 0..self.topology.outputs() {
                self.tape.start_at_output(output);
                self.tape.jacobian(weights);
                self.tape.add_normal_equations(output, normal, projected);
            }
        }
        self.mean(sum)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::activation::Activation;
    use rand_chacha::ChaCha8Rng;
    use rand_core::{Rng, SeedableRng};

    fn uniform(rng: &mut ChaCha8Rng) -> f64 {
        f64::from(rng.next_u32()) / f64::from(u32::MAX) * 2.0 - 1.0
    }

    fn case(topology: &Topology, rows: usize, seed: u64) -> (NetworkObjective, Vec<f64>) {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut draw = |n: usize| (0..n).map(|_| uniform(&mut rng)).collect::<Vec<_>>();
        let patterns = Patterns {
            inputs: draw(rows * topology.inputs()),
            targets: draw(rows * topology.outputs()),
        };
        let weights = draw(topology.weights());
        (NetworkObjective::new(topology, &patterns).unwrap(), weights)
    }

    fn topologies() -> impl Iterator<Item = Topology> {
        Activation::ALL.into_iter().flat_map(|hidden| {
            Activation::ALL.into_iter().flat_map(move |output| {
                [
                    Topology::new(&[3, 5, 2], &[hidden, output]).unwrap(),
                    Topology::new(&[2, 4, 3, 1], &[hidden, Activation::Tanh, output]).unwrap(),
                ]
            })
        })
    }

    /// Central differences with step h: error about mse'''/6 h^2 + eps/h, best near h = 1e-5.
    #[test]
    fn gradient_agrees_with_central_differences() {
        let step = 1e-5;
        for (seed, topology) in topologies().enumerate() {
            // 131 rows: a full block, a short one and a group with empty lanes.
            let (mut objective, mut weights) = case(&topology, 131, seed as u64);
            let mut gradient = vec![0.0; weights.len()];
            let mse = objective.gradient(&weights, &mut gradient);
            assert_eq!(mse.to_bits(), objective.mse(&weights).to_bits());
            for at in 0..weights.len() {
                let middle = weights[at];
                weights[at] = middle + step;
                let above = objective.mse(&weights);
                weights[at] = middle - step;
                let below = objective.mse(&weights);
                weights[at] = middle;
                let difference = (above - below) / (2.0 * step);
                // A kink of relu inside the step shifts the difference by up to step / rows * weights.
                let relu = topology.activations().contains(&Activation::Relu);
                let bound = if relu { 2e-5 } else { 2e-9 };
                let error = (difference - gradient[at]).abs();
                assert!(error < bound, "{topology:?} weight {at}: {difference} {}", gradient[at]);
            }
        }
    }

    #[test]
    fn projected_residuals_are_the_gradient_without_its_factor() {
        for (seed, topology) in topologies().enumerate() {
            let (mut objective, weights) = case(&topology, 137, seed as u64);
            let n = weights.len();
            let (mut gradient, mut projected) = (vec![0.0; n], vec![0.0; n]);
            let mut normal = vec![0.0; n * n];
            objective.gradient(&weights, &mut gradient);
            objective.normal_equations(&weights, &mut normal, &mut projected);
            let factor = 2.0 / count(objective.residuals());
            for (g, p) in gradient.iter().zip(&projected) {
                assert!((g - factor * p).abs() < 1e-13, "{g} {}", factor * p);
            }
        }
    }

    /// For a network linear in its weights `J'J` is the matrix of input products.
    #[test]
    fn normal_matrix_of_a_linear_network_is_the_input_products() {
        let topology = Topology::new(&[2, 1], &[Activation::Linear]).unwrap();
        let patterns =
            Patterns { inputs: vec![1.0, 2.0, 3.0, 4.0, 5.0, 6.0], targets: vec![1.0, 0.0, 2.0] };
        let mut objective = NetworkObjective::new(&topology, &patterns).unwrap();
        let (mut normal, mut projected) = (vec![0.0; 9], vec![0.0; 3]);
        let mse = objective.normal_equations(&[1.0, 0.0, 0.5], &mut normal, &mut projected);
        // Outputs 1.5 3.5 5.5, residuals 0.5 3.5 3.5.
        assert!((mse - 24.75 / 3.0).abs() < 1e-14);
        let close = |got: &[f64], expected: &[f64]| {
            got.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12)
        };
        assert!(close(&normal[..1], &[35.0]), "{normal:?}");
        assert!(close(&normal[3..5], &[44.0, 56.0]), "{normal:?}");
        assert!(close(&normal[6..], &[9.0, 12.0, 3.0]), "{normal:?}");
        assert!(close(&projected, &[28.5, 36.0, 7.5]), "{projected:?}");
    }

    #[test]
    fn rows_that_do_not_fit_are_refused() {
        let topology = Topology::regression(2, &[3], 1).unwrap();
        let build = |inputs: usize, targets: usize| {
            let patterns = Patterns { inputs: vec![0.0; inputs], targets: vec![0.0; targets] };
            NetworkObjective::new(&topology, &patterns).unwrap_err()
        };
        assert_eq!(build(0, 0), ShapeError::Inputs { needed: 2, given: 0 });
        assert_eq!(build(5, 2), ShapeError::Inputs { needed: 4, given: 5 });
        assert_eq!(build(4, 3), ShapeError::Outputs { needed: 2, given: 3 });
    }
}
