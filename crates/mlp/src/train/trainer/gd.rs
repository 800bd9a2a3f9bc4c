//! Steepest descent: a step straight down the gradient, with or without the momentum of earlier steps.

use super::{Objective, Real, StepReport, Trainer, norm};

/// Settings of steepest descent with a fixed rate: `dw = -rate g`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GradientDescentConfig {
    /// Learning rate, above 0. Default 0.01.
    pub rate: f64,
}

impl Default for GradientDescentConfig {
    fn default() -> Self {
        Self { rate: 0.01 }
    }
}

/// The two rules that go by the name of momentum.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum MomentumForm {
    /// `dw = momentum dw' - rate (1 - momentum) g`: an average of gradients, as in MATLAB's traingdm. Its
    /// steady step is that of steepest descent at the same rate.
    #[default]
    Averaged,
    /// `dw = momentum dw' - rate g`: the classical heavy ball (Polyak 1964). Its steady step is
    /// `1 / (1 - momentum)` times longer.
    HeavyBall,
}

/// Settings of [`Momentum`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MomentumConfig {
    /// Learning rate, above 0. Default 0.01.
    pub rate: f64,
    /// Share of the last step that is kept, 0 to below 1. Default 0.9.
    pub momentum: f64,
    /// Which rule. Default averaged.
    pub form: MomentumForm,
}

impl Default for MomentumConfig {
    fn default() -> Self {
        Self { rate: 0.01, momentum: 0.9, form: MomentumForm::Averaged }
    }
}

/// Steepest descent, with momentum in the form of [`MomentumForm`] or without.
#[derive(Debug, Clone)]
pub struct Momentum<T = f64> {
    momentum: T,
    rate: T,
    gradient: Vec<T>,
    steps: Vec<T>,
}

impl<T: Real> Momentum<T> {
    /// Ready for the first step on `weights` weights, at rest.
    #[must_use]
    pub fn new(config: MomentumConfig, weights: usize) -> Self {
        let rate = match config.form {
            MomentumForm::Averaged => config.rate * (1.0 - config.momentum),
            MomentumForm::HeavyBall => config.rate,
        };
        let zeros = vec![T::default(); weights];
        let (momentum, rate) = (T::of(config.momentum), T::of(rate));
        Self { momentum, rate, gradient: zeros.clone(), steps: zeros }
    }

    /// The same without momentum.
    #[must_use]
    pub fn plain(config: GradientDescentConfig, weights: usize) -> Self {
        let form = MomentumForm::HeavyBall;
        Self::new(MomentumConfig { rate: config.rate, momentum: 0.0, form }, weights)
    }
}

impl<T: Real> Trainer<T> for Momentum<T> {
    fn step(&mut self, objective: &mut dyn Objective<T>, weights: &mut [T]) -> StepReport {
        let mse = objective.gradient(weights, &mut self.gradient);
        let moves = self.steps.iter_mut().zip(&self.gradient);
        for (weight, (step, &g)) in weights.iter_mut().zip(moves) {
            *step = self.momentum * *step - self.rate * g;
            *weight += *step;
        }
        StepReport::moved(mse, norm(&self.gradient))
    }
}
