//! Gradient in, step straight down out: steepest descent with a fixed rate.

use super::{Isa, Objective, Real, StepReport, Trainer, add, norm};

/// Settings of [`GradientDescent`].
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

/// Steepest descent: `dw = -rate g`.
#[derive(Debug, Clone)]
pub struct GradientDescent<T = f64> {
    isa: Isa,
    rate: f64,
    gradient: Vec<T>,
}

impl<T: Real> GradientDescent<T> {
    /// Ready for the first step on `weights` weights.
    #[must_use]
    pub fn new(config: GradientDescentConfig, weights: usize) -> Self {
        Self { isa: Isa::detect(), rate: config.rate, gradient: vec![T::default(); weights] }
    }
}

impl<T: Real> Trainer<T> for GradientDescent<T> {
    fn step(&mut self, objective: &mut dyn Objective<T>, weights: &mut [T]) -> StepReport {
        let mse = objective.gradient(weights, &mut self.gradient);
        add(weights, -self.rate, &self.gradient);
        StepReport::moved(mse, norm(self.isa, &self.gradient))
    }
}
