//! Gradient in, step straight down out: steepest descent with a fixed rate.

use super::{Objective, StepReport, Trainer, norm};

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
pub struct GradientDescent {
    rate: f64,
    gradient: Vec<f64>,
}

impl GradientDescent {
    /// Ready for the first step on `weights` weights.
    #[must_use]
    pub fn new(config: GradientDescentConfig, weights: usize) -> Self {
        Self { rate: config.rate, gradient: vec![0.0; weights] }
    }
}

impl Trainer for GradientDescent {
    fn step(&mut self, objective: &mut dyn Objective, weights: &mut [f64]) -> StepReport {
        let mse = objective.gradient(weights, &mut self.gradient);
        for (weight, g) in weights.iter_mut().zip(&self.gradient) {
            *weight -= self.rate * g;
        }
        StepReport {
            mse,
            gradient_norm: norm(&self.gradient),
            gradient_evaluations: 1,
            finished: None,
        }
    }
}
