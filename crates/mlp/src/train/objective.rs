//! Objective of the training: mean squared error over scaled rows and its derivatives, for given weights.

use super::lanes::{Isa, Real};
use super::setting::{SettingError, not_negative};
use super::topology::Topology;
use ndarray::ArrayRef2;

use crate::network::ShapeError;

mod kernel;
mod normal;
mod panel;
mod pass;

use kernel::{AllRows, Tape, Wanted};
use normal::{Jacobian, Sums};
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

    fn all_rows(&mut self, weights: &[T], wanted: Wanted<'_, T>) -> f64 {
        let Self { panels, tape, isa, .. } = self;
        isa.dispatch(AllRows { panels, tape, weights, wanted })
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
        let wanted = Wanted::Normal(jacobian, Sums { normal, projected });
        let sum = isa.dispatch(AllRows { panels, tape, weights, wanted });
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
