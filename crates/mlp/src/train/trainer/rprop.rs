//! Signs of the gradient in, steps of adapted length out: resilient propagation.
//!
//! Riedmiller and Braun (1993), variants after Igel and Huesken (2003).

use super::{Objective, StepReport, Trainer, norm};

/// What happens to a weight whose gradient changed its sign, besides a shorter next step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum RpropVariant {
    /// Rprop-: it moves on with the shorter step.
    Minus,
    /// Rprop+: its last move is undone.
    Plus,
    /// iRprop-: it rests for one epoch.
    #[default]
    ImprovedMinus,
    /// iRprop+: its last move is undone if the error rose, otherwise it rests.
    ImprovedPlus,
}

/// Settings of [`Rprop`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RpropConfig {
    /// Which rule. Default iRprop-.
    pub variant: RpropVariant,
    /// First step length. Default 0.07.
    pub initial: f64,
    /// Factor while the sign stays. Default 1.2.
    pub increase: f64,
    /// Factor when the sign changes. Default 0.5.
    pub decrease: f64,
    /// Longest step. Default 50.
    pub max: f64,
    /// Shortest step. Default 1e-6.
    pub min: f64,
}

impl Default for RpropConfig {
    fn default() -> Self {
        Self {
            variant: RpropVariant::ImprovedMinus,
            initial: 0.07,
            increase: 1.2,
            decrease: 0.5,
            max: 50.0,
            min: 1e-6,
        }
    }
}

/// Memory of one weight.
#[derive(Debug, Clone, Copy)]
struct Memory {
    /// Length of its steps.
    length: f64,
    /// Gradient of the last epoch, or 0 where the rule forgets it.
    gradient: f64,
    /// Its last move.
    step: f64,
}

/// Resilient propagation: step lengths per weight that grow while the gradient keeps its sign and shrink when
/// it changes; the gradient's size plays no part.
#[derive(Debug, Clone)]
pub struct Rprop {
    config: RpropConfig,
    gradient: Vec<f64>,
    memory: Vec<Memory>,
    last_mse: f64,
}

impl Rprop {
    /// Ready for the first step on `weights` weights.
    #[must_use]
    pub fn new(config: RpropConfig, weights: usize) -> Self {
        let memory = Memory { length: config.initial, gradient: 0.0, step: 0.0 };
        Self {
            config,
            gradient: vec![0.0; weights],
            memory: vec![memory; weights],
            last_mse: f64::INFINITY,
        }
    }
}

/// The move of one weight with gradient `g`; `rose` says that the error rose since the last epoch.
fn advance(config: &RpropConfig, memory: &mut Memory, g: f64, rose: bool) -> f64 {
    let agreement = g * memory.gradient;
    let mut seen = g;
    let mut step = None;
    if agreement > 0.0 {
        memory.length = (memory.length * config.increase).min(config.max);
    } else if agreement < 0.0 {
        memory.length = (memory.length * config.decrease).max(config.min);
        match config.variant {
            RpropVariant::Minus => {}
            RpropVariant::ImprovedMinus => seen = 0.0,
            RpropVariant::Plus => (seen, step) = (0.0, Some(-memory.step)),
            RpropVariant::ImprovedPlus => {
                (seen, step) = (0.0, Some(if rose { -memory.step } else { 0.0 }));
            }
        }
    }
    memory.gradient = seen;
    memory.step = step.unwrap_or_else(|| -memory.length * sign(seen));
    memory.step
}

/// -1, 0 or 1.
fn sign(x: f64) -> f64 {
    if x == 0.0 { 0.0 } else { x.signum() }
}

impl Trainer for Rprop {
    fn step(&mut self, objective: &mut dyn Objective, weights: &mut [f64]) -> StepReport {
        let mse = objective.gradient(weights, &mut self.gradient);
        let rose = mse > self.last_mse;
        self.last_mse = mse;
        let memories = self.memory.iter_mut().zip(&self.gradient);
        for (weight, (memory, &g)) in weights.iter_mut().zip(memories) {
            *weight += advance(&self.config, memory, g, rose);
        }
        StepReport {
            mse,
            gradient_norm: norm(&self.gradient),
            gradient_evaluations: 1,
            finished: None,
        }
    }
}
