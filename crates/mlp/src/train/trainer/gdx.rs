//! Gradient descent with momentum and a rate that follows the error.
//!
//! After Vogl et al. (1988) with the constants of MATLAB's traingdx.

use super::{Finish, Objective, Real, StepReport, Trainer, add, finite, norm};

/// Factor of the rate after a step that lowered the error.
const INCREASE: f64 = 1.05;
/// Factor of the rate after a rejected step.
const DECREASE: f64 = 0.7;
/// A step that raises the error by more than this factor is rejected.
const MAX_RISE: f64 = 1.04;

/// Settings of [`AdaptiveRate`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AdaptiveRateConfig {
    /// First learning rate, above 0. Default 0.01.
    pub rate: f64,
    /// Share of the last step that is kept, 0 to below 1. Default 0.9.
    pub momentum: f64,
}

impl Default for AdaptiveRateConfig {
    fn default() -> Self {
        Self { rate: 0.01, momentum: 0.9 }
    }
}

/// Steepest descent with momentum and adaptive rate: `dw = momentum dw' - rate (1 - momentum) g`.
///
/// One step is one trial. It is undone if the error rises by more than 4 %; the rate then falls and the
/// momentum is forgotten. It is kept otherwise, and the rate rises if the error fell.
#[derive(Debug, Clone)]
pub struct AdaptiveRate<T = f64> {
    momentum: f64,
    rate: f64,
    /// Error at the current weights once they are known.
    mse: Option<f64>,
    gradient: Vec<T>,
    steps: Vec<T>,
    trial: Vec<T>,
    trial_gradient: Vec<T>,
}

impl<T: Real> AdaptiveRate<T> {
    /// Ready for the first step on `weights` weights, at rest.
    #[must_use]
    pub fn new(config: AdaptiveRateConfig, weights: usize) -> Self {
        let zeros = vec![T::default(); weights];
        Self {
            momentum: config.momentum,
            rate: config.rate,
            mse: None,
            gradient: zeros.clone(),
            steps: zeros.clone(),
            trial: zeros.clone(),
            trial_gradient: zeros,
        }
    }

    fn propose(&mut self, weights: &[T]) {
        let momentum = T::of(self.momentum);
        let rate = T::of(self.rate * (1.0 - self.momentum));
        let moves = self.steps.iter_mut().zip(&self.gradient);
        for ((trial, &weight), (step, &g)) in self.trial.iter_mut().zip(weights).zip(moves) {
            *step = momentum * *step - rate * g;
            *trial = weight + *step;
        }
    }
}

impl<T: Real> Trainer<T> for AdaptiveRate<T> {
    fn step(&mut self, objective: &mut dyn Objective<T>, weights: &mut [T]) -> StepReport {
        let (mse, first) = match self.mse {
            Some(mse) => (mse, 0),
            None => (objective.gradient(weights, &mut self.gradient), 1),
        };
        let gradient_norm = norm(&self.gradient);
        if !(mse.is_finite() && gradient_norm.is_finite()) {
            let finished = Some(Finish::NotFinite);
            return StepReport { mse, gradient_norm, gradient_evaluations: first, finished };
        }
        self.propose(weights);
        let trial = objective.gradient(&self.trial, &mut self.trial_gradient);
        let usable = trial.is_finite() && finite(&self.trial_gradient);
        if usable && trial <= MAX_RISE * mse {
            weights.copy_from_slice(&self.trial);
            core::mem::swap(&mut self.gradient, &mut self.trial_gradient);
            self.mse = Some(trial);
            if trial < mse {
                self.rate *= INCREASE;
            }
        } else {
            self.mse = Some(mse);
            self.rate *= DECREASE;
            // The next step starts from the plain descent at the lower rate.
            self.steps.fill(T::default());
            add(&mut self.steps, -self.rate, &self.gradient);
        }
        let finished = (self.rate == 0.0).then_some(Finish::DampingLimit);
        StepReport { mse, gradient_norm, gradient_evaluations: first + 1, finished }
    }
}
