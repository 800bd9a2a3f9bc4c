//! Weights in, mean squared error over scaled rows and its derivatives out.

use super::lanes::Isa;
use super::real::Real;
use super::setting::{SettingError, not_negative};
use super::topology::Topology;
use ndarray::ArrayRef2;

use crate::network::ShapeError;

mod kernel;
mod normal;
mod panel;
mod pass;

use kernel::{AllRows, Tape, Wanted};
use normal::{Jacobian, NormalEquations, Sums};
use panel::Panels;

/// What the trainers minimise: a mean of squared residuals or, for classes, of cross-entropies; with a penalty on large
/// weights if one is set.
///
/// Weights are in the flat order of [`Network`](crate::Network). With residuals `e` (output minus target), `n` of
/// them over rows and targets, the error is `sum e^2 / n + decay / 2 * sum w^2`, where the second sum leaves the
/// biases out and `decay` is usually 0. Implementations keep scratch memory, hence `&mut self`; equal weights give
/// equal results.
pub trait Objective<T = f64> {
    /// Number of weights.
    fn weights(&self) -> usize;

    /// Number of residuals: rows times targets; rows for classes.
    fn residuals(&self) -> usize;

    /// The error.
    fn mse(&mut self, weights: &[T]) -> f64;

    /// The error; writes its derivatives to `gradient`.
    fn gradient(&mut self, weights: &[T], gradient: &mut [T]) -> f64;

    /// The error; writes half its gradient times `n`, without a penalty `J'e`, to `projected` and the lower
    /// triangle of half its Gauss-Newton Hessian times `n`, without a penalty `J'J`, row by row in a square
    /// matrix, to `normal`, with `J[k][w] = d e_k / d weight_w`.
    fn normal_equations(&mut self, weights: &[T], normal: &mut [f64], projected: &mut [f64])
    -> f64;
}

/// The objective of a feed-forward network over all its rows, in `f32` or `f64`.
///
/// Rows are transposed once, so that the rows of up to four machine vectors go through the network together, forward
/// and back, without leaving the first-level cache. Values have the precision `T`; sums over rows go on in `f64`
/// after at most 256 additions.
#[derive(Debug, Clone)]
pub struct NetworkObjective<T = f64> {
    topology: Topology,
    rows: usize,
    decay: f64,
    isa: Isa,
    panels: Panels<T>,
    tape: Tape<T>,
    jacobian: Option<Jacobian<T>>,
}

impl<T: Real> NetworkObjective<T> {
    /// Lays out scaled rows, inputs (rows x inputs) and targets (rows x outputs) of any memory layout, for `topology` and
    /// the widest vectors of this machine.
    ///
    /// # Errors
    /// [`ShapeError::Inputs`] or [`ShapeError::Outputs`] for columns of another number than the topology has,
    /// [`ShapeError::Rows`] without rows or for different numbers of them.
    pub fn new(
        topology: &Topology,
        inputs: &ArrayRef2<f64>,
        targets: &ArrayRef2<f64>,
    ) -> Result<Self, ShapeError> {
        Self::with_isa(topology, inputs, targets, Isa::detect())
    }

    /// The same for the vectors of `isa`.
    ///
    /// # Errors
    /// As [`NetworkObjective::new`].
    pub fn with_isa(
        topology: &Topology,
        inputs: &ArrayRef2<f64>,
        targets: &ArrayRef2<f64>,
        isa: Isa,
    ) -> Result<Self, ShapeError> {
        let (needed, given) = (topology.inputs(), inputs.ncols());
        if needed != given {
            return Err(ShapeError::Inputs { needed, given });
        }
        let (needed, given) = (topology.outputs(), targets.ncols());
        if needed != given {
            return Err(ShapeError::Outputs { needed, given });
        }
        let rows = inputs.nrows();
        if rows == 0 || targets.nrows() != rows {
            return Err(ShapeError::Rows { inputs: rows, outputs: targets.nrows() });
        }
        let width = isa.width::<T>();
        Ok(Self {
            topology: topology.clone(),
            rows,
            decay: 0.0,
            isa,
            panels: Panels::new(inputs, targets, width),
            tape: Tape::new(topology, width),
            jacobian: None,
        })
    }

    /// Adds the penalty `decay / 2 * sum w^2` over all weights but the biases.
    ///
    /// # Errors
    /// [`SettingError`] unless `decay` is 0 or a positive number.
    pub fn with_decay(mut self, decay: f64) -> Result<Self, SettingError> {
        not_negative("decay", decay)?;
        self.decay = decay;
        Ok(self)
    }

    /// Takes the outputs as scores and the targets as probabilities of classes: the error becomes the mean over the rows of the
    /// cross-entropy `-sum t ln p`, p the softmax of the outputs. For rules that take errors and gradients alone.
    #[must_use]
    pub fn with_softmax(mut self) -> Self {
        self.tape.softmax = true;
        self
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

    /// The vectors it runs on.
    #[must_use]
    pub fn isa(&self) -> Isa {
        self.isa
    }

    fn all_rows(&mut self, weights: &[T], wanted: Wanted) -> f64 {
        let Self { panels, tape, .. } = self;
        self.isa.dispatch(AllRows { panels, tape, weights, wanted })
    }

    /// Places of all weights that are no biases.
    fn decaying(&self) -> impl Iterator<Item = core::ops::Range<usize>> {
        self.topology.layers().map(|layer| layer.start..layer.biases())
    }

    /// The mean of squares that sum up to `sum`, with the penalty.
    fn error(&self, sum: f64, weights: &[T]) -> f64 {
        let mean = sum / count(self.residuals());
        if self.decay == 0.0 {
            return mean;
        }
        let squares: f64 =
            self.decaying().flat_map(|range| &weights[range]).map(|w| w.double().powi(2)).sum();
        mean + 0.5 * self.decay * squares
    }
}

/// Counts stay far below 2^53.
pub(super) fn count(n: usize) -> f64 {
    n as f64
}

impl<T: Real> Objective<T> for NetworkObjective<T> {
    fn weights(&self) -> usize {
        self.topology.weights()
    }

    fn residuals(&self) -> usize {
        if self.tape.softmax { self.rows } else { self.rows * self.topology.outputs() }
    }

    fn mse(&mut self, weights: &[T]) -> f64 {
        let sum = self.all_rows(weights, Wanted::Error);
        self.error(sum, weights)
    }

    fn gradient(&mut self, weights: &[T], gradient: &mut [T]) -> f64 {
        let sum = self.all_rows(weights, Wanted::Gradient);
        // The derivative of a cross-entropy by its scores is the residual, of a square twice that.
        let factor = if self.tape.softmax { 1.0 } else { 2.0 } / count(self.residuals());
        for (g, total) in gradient.iter_mut().zip(&self.tape.totals) {
            *g = T::of(factor * total);
        }
        if self.decay > 0.0 {
            for at in self.decaying().flatten() {
                gradient[at] += T::of(self.decay * weights[at].double());
            }
        }
        self.error(sum, weights)
    }

    fn normal_equations(
        &mut self,
        weights: &[T],
        normal: &mut [f64],
        projected: &mut [f64],
    ) -> f64 {
        normal.fill(0.0);
        projected.fill(0.0);
        let Self { panels, tape, jacobian, isa, .. } = self;
        let width = isa.width::<T>();
        let jacobian = jacobian.get_or_insert_with(|| Jacobian::new(weights.len(), width));
        let sums = Sums { normal, projected };
        let sum = isa.dispatch(NormalEquations { panels, tape, jacobian, weights, sums });
        if self.decay > 0.0 {
            let half = 0.5 * self.decay * count(self.residuals());
            for at in self.decaying().flatten() {
                projected[at] += half * weights[at].double();
                normal[at * weights.len() + at] += half;
            }
        }
        self.error(sum, weights)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::activation::Activation;
    use ndarray::{Array2, Axis, ShapeBuilder as _, Slice, arr2};
    use rand_chacha::ChaCha8Rng;
    use rand_core::{Rng, SeedableRng};

    fn uniform(rng: &mut ChaCha8Rng) -> f64 {
        f64::from(rng.next_u32()) / f64::from(u32::MAX) * 2.0 - 1.0
    }

    /// For a network linear in its weights `J'J` is the matrix of input products.
    #[test]
    fn normal_matrix_of_a_linear_network_is_the_input_products() {
        let topology = Topology::new(&[2, 1], &[Activation::Linear]).unwrap();
        let (inputs, targets) =
            (arr2(&[[1.0, 2.0], [3.0, 4.0], [5.0, 6.0]]), arr2(&[[1.0], [0.0], [2.0]]));
        let mut objective = NetworkObjective::new(&topology, &inputs, &targets).unwrap();
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
        let build = |inputs: (usize, usize), targets: (usize, usize)| {
            let (inputs, targets) = (Array2::zeros(inputs), Array2::zeros(targets));
            NetworkObjective::<f64>::new(&topology, &inputs, &targets).unwrap_err()
        };
        assert_eq!(build((0, 2), (0, 1)), ShapeError::Rows { inputs: 0, outputs: 0 });
        assert_eq!(build((5, 3), (5, 1)), ShapeError::Inputs { needed: 2, given: 3 });
        assert_eq!(build((4, 2), (4, 0)), ShapeError::Outputs { needed: 1, given: 0 });
        assert_eq!(build((4, 2), (3, 1)), ShapeError::Rows { inputs: 4, outputs: 3 });
    }

    /// Columns side by side in memory, rows backwards, every second row: the same bits as rows copied one by one.
    #[test]
    fn any_memory_layout_gives_the_same_bits() {
        let topology = Topology::regression(2, &[4], 2).unwrap();
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let all = Array2::from_shape_simple_fn((60, 2).f(), || uniform(&mut rng));
        let weights: Vec<f64> = (0..topology.weights()).map(|_| uniform(&mut rng)).collect();
        let every = |axis, step| all.slice_axis(axis, Slice::from(..).step_by(step));
        for view in [all.view(), every(Axis(0), -1), every(Axis(0), 2), every(Axis(1), -1)] {
            assert!(!view.is_standard_layout());
            let mut copy = Array2::zeros((view.nrows(), 2));
            for row in 0..view.nrows() {
                for column in 0..2 {
                    copy[[row, column]] = view[[row, column]];
                }
            }
            let gradient = |x: &ArrayRef2<f64>| {
                let mut gradient = vec![0.0; weights.len()];
                NetworkObjective::<f64>::new(&topology, x, x)
                    .unwrap()
                    .gradient(&weights, &mut gradient);
                gradient
            };
            assert_eq!(gradient(&view), gradient(&copy));
        }
    }

    /// Cross-entropy by hand, row by row, and its gradient by differences; 37 rows leave lanes of the last vector empty.
    #[test]
    fn cross_entropy_and_its_gradient_are_those_of_softmax() {
        let topology = Topology::regression(3, &[4], 5).unwrap();
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let inputs = Array2::from_shape_simple_fn((37, 3), || uniform(&mut rng));
        let targets = Array2::from_shape_fn((37, 5), |(row, class)| {
            f64::from(u8::from(row * 7 % 5 == class))
        });
        let weights: Vec<f64> = (0..topology.weights()).map(|_| uniform(&mut rng)).collect();
        for isa in Isa::available() {
            let mut objective = NetworkObjective::with_isa(&topology, &inputs, &targets, isa)
                .unwrap()
                .with_softmax();
            let mut by_hand = 0.0;
            for (row, target) in inputs.rows().into_iter().zip(targets.rows()) {
                let mut scores = by_definition(&topology, &weights, &row.to_vec());
                let sum: f64 = scores.iter().map(|score| score.exp()).sum();
                scores.iter_mut().for_each(|score| *score -= sum.ln());
                by_hand -= scores.iter().zip(target).map(|(ln_p, t)| t * ln_p).sum::<f64>() / 37.0;
            }
            let mut gradient = vec![0.0; weights.len()];
            let error = objective.gradient(&weights, &mut gradient);
            assert!((error - by_hand).abs() < 1e-12, "{isa}: {error} {by_hand}");
            assert_eq!(error.to_bits(), objective.mse(&weights).to_bits(), "{isa}");
            for at in 0..weights.len() {
                let shifted = |by: f64| {
                    let mut weights = weights.clone();
                    weights[at] += by;
                    weights
                };
                let slope = (objective.mse(&shifted(1e-5)) - objective.mse(&shifted(-1e-5))) / 2e-5;
                assert!((slope - gradient[at]).abs() < 1e-8, "{isa} {at}: {slope} {gradient:?}");
            }
        }
    }

    /// Scores of a network with one hidden layer of tanh.
    fn by_definition(topology: &Topology, weights: &[f64], row: &[f64]) -> Vec<f64> {
        topology.layers().fold(row.to_vec(), |values, layer| {
            let sum = |neuron: usize| {
                let from = layer.start + neuron * layer.from;
                let sum: f64 =
                    weights[from..][..layer.from].iter().zip(&values).map(|(w, x)| w * x).sum();
                let sum = sum + weights[layer.biases() + neuron];
                if layer.activation == Activation::Tanh { sum.tanh() } else { sum }
            };
            (0..layer.to).map(sum).collect()
        })
    }
}
