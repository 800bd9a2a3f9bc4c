//! Levenberg-Marquardt: damped Gauss-Newton steps from Jacobian products.
//!
//! Hagan and Menhaj (1994): `dw = -(J'J + mu I)^-1 J'e`, with more damping until the error falls.

use super::super::linear::solve_shifted;
use super::super::objective::count;
use super::{Finish, Objective, Real, StepReport, Trainer, norm};

/// Its two square matrices then fill 256 MiB.
pub const MAX_WEIGHTS: usize = 4096;

/// Damping never falls below this, so that it can always rise again.
pub(super) const MIN_MU: f64 = 1e-20;

/// Factors of the damping after an accepted and a rejected step, and the damping at which a rule gives up: those of MATLAB.
pub(super) const LESS: f64 = 0.1;
pub(super) const MORE: f64 = 10.0;
pub(super) const MOST: f64 = 1e10;

/// How the damping follows the success of the steps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Damping {
    /// By a tenth after every accepted step, however good it was, and tenfold after a rejected one: MATLAB's trainlm.
    Factors,
    /// By the gain, the error's true fall over that of the linear model: times `max(1/3, 1 - (2 gain - 1)^3)` after an
    /// accepted step, times 2, 4, 8, ... after rejected ones (Nielsen 1999).
    #[default]
    Gain,
}

/// Settings of [`LevenbergMarquardt`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LevenbergMarquardtConfig {
    /// Which rule. Default by the gain.
    pub damping: Damping,
    /// First damping: under [`Damping::Gain`] as a share of the largest diagonal element of `J'J`, under
    /// [`Damping::Factors`] as it is. Default 0.03.
    ///
    /// With a first damping near zero the first step saturates neurons, which costs some starts over 80 epochs.
    pub mu: f64,
}

impl Default for LevenbergMarquardtConfig {
    fn default() -> Self {
        Self { damping: Damping::Gain, mu: 0.03 }
    }
}

/// The normal equations at some weights and a trial step from there, as [`br`](super::br) takes them too.
#[derive(Debug, Clone)]
pub(super) struct System<T> {
    pub(super) normal: Vec<f64>,
    /// Half the gradient times the number of residuals.
    pub(super) projected: Vec<f64>,
    pub(super) factor: Vec<f64>,
    pub(super) step: Vec<f64>,
    pub(super) trial: Vec<T>,
}

impl<T: Real> System<T> {
    pub(super) fn new(weights: usize) -> Self {
        let (square, zeros) = (vec![0.0; weights * weights], vec![0.0; weights]);
        let trial = vec![T::default(); weights];
        let (normal, projected) = (square.clone(), zeros.clone());
        Self { normal, projected, factor: square, step: zeros, trial }
    }

    /// Reads them off; returns the error and the norm of its gradient.
    pub(super) fn read(&mut self, objective: &mut dyn Objective<T>, weights: &[T]) -> (f64, f64) {
        let mse = objective.normal_equations(weights, &mut self.normal, &mut self.projected);
        (mse, 2.0 / count(objective.residuals()) * norm(&self.projected))
    }

    /// The largest element on the diagonal, `least` at least.
    pub(super) fn scale(&self, least: f64) -> f64 {
        self.normal.iter().step_by(self.projected.len() + 1).copied().fold(least, f64::max)
    }

    /// The error one step of `-(J'J + shift I)^-1 right` away, left in `trial`; `None` where the matrix is not positive definite.
    pub(super) fn try_step(
        &mut self,
        objective: &mut dyn Objective<T>,
        weights: &[T],
        right: &[f64],
        shift: f64,
    ) -> Option<f64> {
        self.step.copy_from_slice(right);
        solve_shifted(&self.normal, shift, &mut self.factor, &mut self.step)?;
        for (trial, (weight, step)) in self.trial.iter_mut().zip(weights.iter().zip(&self.step)) {
            *trial = T::of(weight.double() - step);
        }
        Some(objective.mse(&self.trial))
    }
}

/// Levenberg-Marquardt. One step is one Jacobian and as many trials as it takes to lower the error. Products of the
/// Jacobian and the system of equations are in `f64` whatever the precision of the network. Memory
/// and time grow with the square and the cube of the number of weights.
#[derive(Debug, Clone)]
pub struct LevenbergMarquardt<T = f64> {
    config: LevenbergMarquardtConfig,
    /// Damping, unknown until the first Jacobian.
    mu: Option<f64>,
    /// Factor of the damping after the next rejected step, under [`Damping::Gain`].
    growth: f64,
    system: System<T>,
}

impl<T: Real> LevenbergMarquardt<T> {
    /// Ready for the first step on `weights` weights.
    #[must_use]
    pub fn new(config: LevenbergMarquardtConfig, weights: usize) -> Self {
        Self { config, mu: None, growth: 2.0, system: System::new(weights) }
    }

    /// Moves `weights` to a lower error than `mse`; false when no damping up to the limit does.
    fn descend(&mut self, objective: &mut dyn Objective<T>, weights: &mut [T], mse: f64) -> bool {
        let mut mu = self.mu.unwrap_or_else(|| self.first_damping());
        let right = self.system.projected.clone();
        while mu <= MOST {
            let trial = self.system.try_step(objective, weights, &right, mu);
            if let Some(trial) = trial.filter(|trial| *trial < mse) {
                weights.copy_from_slice(&self.system.trial);
                let fall = count(objective.residuals()) * (mse - trial);
                self.mu = Some((mu * self.less(fall, mu)).max(MIN_MU));
                self.growth = 2.0;
                return true;
            }
            mu *= match self.config.damping {
                Damping::Factors => MORE,
                Damping::Gain => self.growth,
            };
            self.growth *= 2.0;
        }
        false
    }

    fn first_damping(&self) -> f64 {
        if self.config.damping == Damping::Factors {
            return self.config.mu;
        }
        (self.config.mu * self.system.scale(0.0)).max(MIN_MU)
    }

    /// Factor of the damping after a step that lowered the sum of squares by `fall`.
    fn less(&self, fall: f64, mu: f64) -> f64 {
        if self.config.damping == Damping::Factors {
            return LESS;
        }
        let products = self.system.step.iter().zip(&self.system.projected);
        let predicted: f64 = products.map(|(step, p)| step * (mu * step + p)).sum();
        let gain = fall / predicted;
        if !gain.is_finite() {
            return 1.0;
        }
        (1.0 - (2.0 * gain - 1.0).powi(3)).clamp(1.0 / 3.0, 2.0)
    }
}

impl<T: Real> Trainer<T> for LevenbergMarquardt<T> {
    fn step(&mut self, objective: &mut dyn Objective<T>, weights: &mut [T]) -> StepReport {
        let (mse, gradient_norm) = self.system.read(objective, weights);
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
