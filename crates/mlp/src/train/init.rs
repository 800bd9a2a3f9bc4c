//! Starting weights by network shape and seed.
//!
//! D. Nguyen and B. Widrow, "Improving the learning speed of 2-layer neural networks" (1990).

use rand_chacha::ChaCha8Rng;
use rand_core::{Rng, SeedableRng};

use super::objective::count;
use super::topology::{Layer, Topology};
use crate::activation::Activation;

/// Starting weights after Nguyen and Widrow, for inputs in `[-1, 1]`; equal seeds give equal weights.
///
/// The `S` neurons of a saturating layer with `R` inputs share out the input range: rows of random direction
/// and length `m = 0.7 S^(1/R)`, biases `m linspace(-1, 1, S)` with the sign of the row's first weight, both
/// stretched to the active range of the function (2 for tanh, 4 for logistic) and mapped from the range of the
/// layer before. Other layers start small: uniform in +-0.5 for linear ones, in +-sqrt(6 / R) with zero biases
/// for relu (He et al. 2015).
#[must_use]
pub fn nguyen_widrow(topology: &Topology, seed: u64) -> Vec<f64> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut weights = vec![0.0; topology.weights()];
    let mut from_logistic = false;
    for layer in topology.layers() {
        let (matrix, biases) =
            weights[layer.start..layer.end()].split_at_mut(layer.from * layer.to);
        match layer.activation {
            Activation::Tanh => spread(&mut rng, layer, 2.0, matrix, biases),
            Activation::Logistic => spread(&mut rng, layer, 4.0, matrix, biases),
            Activation::Linear => {
                matrix
                    .iter_mut()
                    .chain(biases.iter_mut())
                    .for_each(|w| *w = 0.5 * uniform(&mut rng));
            }
            Activation::Relu => {
                let bound = (6.0 / count(layer.from)).sqrt();
                matrix.iter_mut().for_each(|w| *w = bound * uniform(&mut rng));
            }
        }
        if from_logistic {
            map_from_unit_range(matrix, biases);
        }
        from_logistic = layer.activation == Activation::Logistic;
    }
    weights
}

fn spread(rng: &mut ChaCha8Rng, layer: Layer, range: f64, matrix: &mut [f64], biases: &mut [f64]) {
    let (neurons, inputs) = (count(layer.to), count(layer.from));
    let magnitude = 0.7 * libm::pow(neurons, 1.0 / inputs) * range;
    for (at, (row, bias)) in matrix.chunks_exact_mut(layer.from).zip(biases).enumerate() {
        let length = draw_direction(rng, row);
        row.iter_mut().for_each(|w| *w *= magnitude / length);
        let place = if layer.to == 1 { 0.0 } else { 2.0 * count(at) / (neurons - 1.0) - 1.0 };
        *bias = magnitude * place * row[0].signum();
    }
}

/// Fills `row` from U(-1, 1) and returns its length, drawing again if that is nearly zero.
fn draw_direction(rng: &mut ChaCha8Rng, row: &mut [f64]) -> f64 {
    loop {
        row.iter_mut().for_each(|w| *w = uniform(rng));
        let length = row.iter().map(|w| w * w).sum::<f64>().sqrt();
        if length > 1e-6 {
            return length;
        }
    }
}

/// Rewrites weights meant for inputs in `[-1, 1]` for inputs in `[0, 1]`.
fn map_from_unit_range(matrix: &mut [f64], biases: &mut [f64]) {
    let from = matrix.len() / biases.len();
    for (row, bias) in matrix.chunks_exact_mut(from).zip(biases) {
        *bias -= row.iter().sum::<f64>();
        row.iter_mut().for_each(|w| *w *= 2.0);
    }
}

/// Uniform in [-1, 1) with 53 bits.
fn uniform(rng: &mut ChaCha8Rng) -> f64 {
    (rng.next_u64() >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_have_the_right_length_and_biases_share_out_the_range() {
        let topology = Topology::regression(2, &[10], 1).unwrap();
        let weights = nguyen_widrow(&topology, 7);
        let magnitude = 2.0 * 0.7 * 10_f64.sqrt();
        for row in weights[..20].chunks_exact(2) {
            assert!((row[0].hypot(row[1]) - magnitude).abs() < 1e-12, "{row:?}");
        }
        for (at, (bias, row)) in weights[20..30].iter().zip(weights.chunks_exact(2)).enumerate() {
            let expected = magnitude * (2.0 * at as f64 / 9.0 - 1.0) * row[0].signum();
            assert!((bias - expected).abs() < 1e-12, "bias {at}: {bias} {expected}");
        }
        assert!(weights[30..].iter().all(|w| w.abs() <= 0.5));
    }

    #[test]
    fn seeds_decide() {
        let topology = Topology::regression(3, &[5, 4], 2).unwrap();
        assert_eq!(nguyen_widrow(&topology, 3), nguyen_widrow(&topology, 3));
        assert_ne!(nguyen_widrow(&topology, 3), nguyen_widrow(&topology, 4));
    }

    #[test]
    fn a_layer_after_logistic_neurons_sees_the_same_sums() {
        let (mut matrix, mut biases) = ([3.0, -1.0], [0.5]);
        map_from_unit_range(&mut matrix, &mut biases);
        let (wide, unit): ([f64; 2], [f64; 2]) = ([0.2, -0.6], [0.6, 0.2]);
        let before = 3.0 * wide[0] - wide[1] + 0.5;
        let after = matrix[0] * unit[0] + matrix[1] * unit[1] + biases[0];
        assert!((before - after).abs() < 1e-15, "{before} {after}");
    }

    #[test]
    fn uniform_fills_its_range() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let draws: Vec<f64> = (0..20_000).map(|_| uniform(&mut rng)).collect();
        let mean = draws.iter().sum::<f64>() / 20_000.0;
        let square = draws.iter().map(|x| x * x).sum::<f64>() / 20_000.0;
        assert!(draws.iter().all(|x| (-1.0..1.0).contains(x)));
        assert!(mean.abs() < 0.016 && (square - 1.0 / 3.0).abs() < 0.009, "{mean} {square}");
    }
}
