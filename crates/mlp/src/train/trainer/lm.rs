//! Jacobian products in, damped Gauss-Newton steps out: Levenberg-Marquardt.
//!
//! Hagan and Menhaj (1994): `dw = -(J'J + mu I)^-1 J'e`, with more damping until the error falls.

use super::super::linear::solve_shifted;
use super::super::objective::count;
use super::{Finish, Isa, Objective, Real, StepReport, Trainer, norm};

/// Its two square matrices then fill 256 MiB.
pub const MAX_WEIGHTS: usize = 4096;

/// Damping never falls below this, so that it can always rise again.
const MIN_MU: f64 = 1e-20;

/// Settings of [`LevenbergMarquardt`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LevenbergMarquardtConfig {
    /// First damping. Default 0.001.
    pub mu: f64,
    /// Factor after an accepted step. Default 0.1.
    pub decrease: f64,
    /// Factor after a rejected one. Default 10.
    pub increase: f64,
    /// Damping at which it gives up. Default 1e10.
    pub max: f64,
}

impl Default for LevenbergMarquardtConfig {
    fn default() -> Self {
        Self { mu: 0.001, decrease: 0.1, increase: 10.0, max: 1e10 }
    }
}

/// Levenberg-Marquardt. One step is one Jacobian and as many trials as it takes to lower the error. Products of the
/// Jacobian and the system of equations are in `f64` whatever the precision of the network. Memory
/// and time grow with the square and the cube of the number of weights.
#[derive(Debug, Clone)]
pub struct LevenbergMarquardt<T = f64> {
    isa: Isa,
    config: LevenbergMarquardtConfig,
    mu: f64,
    normal: Vec<f64>,
    projected: Vec<f64>,
    factor: Vec<f64>,
    step: Vec<f64>,
    trial: Vec<T>,
}

impl<T: Real> LevenbergMarquardt<T> {
    /// Ready for the first step on `weights` weights.
    #[must_use]
    pub fn new(config: LevenbergMarquardtConfig, weights: usize) -> Self {
        let (square, zeros) = (vec![0.0; weights * weights], vec![0.0; weights]);
        Self {
            isa: Isa::detect(),
            config,
            mu: config.mu,
            normal: square.clone(),
            projected: zeros.clone(),
            factor: square,
            step: zeros,
            trial: vec![T::default(); weights],
        }
    }

    /// Moves `weights` to a lower error than `mse`; false when no damping up to the limit does.
    fn descend(&mut self, objective: &mut dyn Objective<T>, weights: &mut [T], mse: f64) -> bool {
        while self.mu <= self.config.max {
            if self.error_of_trial(objective, weights).is_some_and(|trial| trial < mse) {
                weights.copy_from_slice(&self.trial);
                self.mu = (self.mu * self.config.decrease).max(MIN_MU);
                return true;
            }
            self.mu *= self.config.increase;
        }
        false
    }

    fn error_of_trial(&mut self, objective: &mut dyn Objective<T>, weights: &[T]) -> Option<f64> {
        self.step.copy_from_slice(&self.projected);
        solve_shifted(&self.normal, self.mu, &mut self.factor, &mut self.step)?;
        for (trial, (weight, step)) in self.trial.iter_mut().zip(weights.iter().zip(&self.step)) {
            *trial = T::of(weight.double() - step);
        }
        Some(objective.mse(&self.trial))
    }
}

impl<T: Real> Trainer<T> for LevenbergMarquardt<T> {
    fn step(&mut self, objective: &mut dyn Objective<T>, weights: &mut [T]) -> StepReport {
        let mse = objective.normal_equations(weights, &mut self.normal, &mut self.projected);
        let gradient_norm = 2.0 / count(objective.residuals()) * norm(self.isa, &self.projected);
        let finished = if !(mse.is_finite() && gradient_norm.is_finite()) {
            Some(Finish::NotFinite)
        } else if gradient_norm == 0.0 {
            Some(Finish::Flat)
        } else if self.descend(objective, weights, mse) {
            None
        } else {
            Some(Finish::DampingLimit)
        };
        StepReport { mse, gradient_norm, gradient_evaluations: 1, finished }
    }
}
