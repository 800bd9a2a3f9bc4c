//! Scaled conjugate gradient: conjugate steps of a length found without a line search.
//!
//! M. F. Moller, "A scaled conjugate gradient algorithm for fast supervised learning" (1993).

use super::{Finish, Objective, Real, StepReport, Trainer, combine, dot, finite, norm};

/// The damping stays within these limits.
const LAMBDA: core::ops::RangeInclusive<f64> = 1e-15..=1e20;

/// Settings of [`Scg`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScgConfig {
    /// Length of the probe along the direction that measures the curvature. Default `None`: 5e-5 in `f64`, 5e-4 in
    /// `f32`, where a shorter one drowns in rounding.
    pub sigma: Option<f64>,
    /// First damping of the curvature. Default 5e-7.
    pub lambda: f64,
}

impl Default for ScgConfig {
    fn default() -> Self {
        Self { sigma: None, lambda: 5e-7 }
    }
}

/// Scaled conjugate gradient. One step is one trial move, accepted or not.
///
/// An accepted trial costs two gradients (one of them a probe for the curvature), the trial after a rejected one
/// costs one. Where the published steps leave gaps: the measured curvature is kept after a rejected trial;
/// the damping is clamped; a direction that does not descend is replaced by the steepest descent; a trial that
/// is not finite counts as rejected with no gain.
#[derive(Debug, Clone)]
pub struct Scg<T = f64> {
    sigma: f64,
    lambda: f64,
    lambda_bar: f64,
    /// Error at the current weights once they are known.
    mse: Option<f64>,
    /// Curvature `p'Hp + (lambda - lambda_bar) |p|^2` along the direction.
    delta: f64,
    /// Whether the last trial was accepted, so that the curvature must be measured anew.
    moved: bool,
    /// Accepted trials since the direction was the steepest descent.
    successes: usize,
    /// Steepest descent `r = -g` at the current weights.
    descent: Vec<T>,
    /// Search direction `p`.
    direction: Vec<T>,
    trial: Vec<T>,
    gradient: Vec<T>,
}

impl<T: Real> Scg<T> {
    /// Ready for the first step on `weights` weights.
    #[must_use]
    pub fn new(config: ScgConfig, weights: usize) -> Self {
        let zeros = vec![T::default(); weights];
        let usual = if T::NAME == f32::NAME { 5e-4 } else { 5e-5 };
        Self {
            sigma: config.sigma.unwrap_or(usual),
            lambda: config.lambda,
            lambda_bar: 0.0,
            mse: None,
            delta: 0.0,
            moved: true,
            successes: 0,
            descent: zeros.clone(),
            direction: zeros.clone(),
            trial: zeros.clone(),
            gradient: zeros,
        }
    }

    /// Gradient and error at `weights + length * direction`, left in `trial` and `gradient`.
    fn look(&mut self, objective: &mut dyn Objective<T>, weights: &[T], length: f64) -> f64 {
        combine(&mut self.trial, weights, length, &self.direction);
        objective.gradient(&self.trial, &mut self.gradient)
    }

    fn take_descent(&mut self) {
        for (r, &g) in self.descent.iter_mut().zip(&self.gradient) {
            *r = -g;
        }
    }

    /// Curvature along the direction by a difference of gradients.
    fn curvature(&mut self, objective: &mut dyn Objective<T>, weights: &[T], length: f64) -> f64 {
        let sigma = self.sigma / length;
        self.look(objective, weights, sigma);
        for (probe, &r) in self.gradient.iter_mut().zip(&self.descent) {
            *probe += r;
        }
        dot(&self.direction, &self.gradient) / sigma
    }

    /// Damps the curvature until it is positive.
    fn damp(&mut self, mut delta: f64, square: f64) -> f64 {
        delta += (self.lambda - self.lambda_bar) * square;
        if delta <= 0.0 {
            self.lambda_bar = 2.0 * (self.lambda - delta / square);
            delta = -delta + self.lambda * square;
            self.lambda = self.lambda_bar;
        }
        delta
    }

    /// Moves to the trial and chooses the next direction. `ratio` compares true and predicted gain.
    fn accept(&mut self, weights: &mut [T], mu: f64, ratio: f64) {
        weights.copy_from_slice(&self.trial);
        let overlap = -dot(&self.gradient, &self.descent);
        self.take_descent();
        self.lambda_bar = 0.0;
        self.moved = true;
        self.successes += 1;
        if self.successes >= weights.len() {
            self.successes = 0;
            self.direction.copy_from_slice(&self.descent);
        } else {
            let square = dot(&self.descent, &self.descent);
            let beta = (square - overlap) / mu;
            let beta = T::of(beta);
            for (p, &r) in self.direction.iter_mut().zip(&self.descent) {
                *p = r + beta * *p;
            }
        }
        if ratio >= 0.75 {
            self.lambda *= 0.25;
        }
    }

    /// The descent's share along the direction, `p'r`; restarts with the steepest descent unless positive.
    fn slope(&mut self) -> f64 {
        let mu = dot(&self.direction, &self.descent);
        if mu > 0.0 {
            return mu;
        }
        self.direction.copy_from_slice(&self.descent);
        self.successes = 0;
        self.moved = true;
        self.lambda_bar = 0.0;
        dot(&self.descent, &self.descent)
    }

    /// One trial along the direction; returns the gradients it cost and why it is the last, if it is.
    fn attempt(
        &mut self,
        objective: &mut dyn Objective<T>,
        weights: &mut [T],
        before: f64,
    ) -> (usize, Option<Finish>) {
        let mu = self.slope();
        let square = dot(&self.direction, &self.direction);
        if square == 0.0 || mu == 0.0 {
            return (0, Some(Finish::Flat));
        }
        if !square.is_finite() {
            return (0, Some(Finish::NotFinite));
        }
        let mut cost = 1;
        if self.moved {
            self.delta = self.curvature(objective, weights, square.sqrt());
            cost += 1;
            if !self.delta.is_finite() {
                return (1, Some(Finish::NotFinite));
            }
        }
        self.delta = self.damp(self.delta, square);
        let alpha = mu / self.delta;
        let mse = self.look(objective, weights, alpha);
        let usable = mse.is_finite() && finite(&self.gradient);
        let ratio = if usable { 2.0 * self.delta * (before - mse) / (mu * mu) } else { 0.0 };
        if usable && ratio >= 0.0 {
            self.accept(weights, mu, ratio);
            self.mse = Some(mse);
        } else {
            self.lambda_bar = self.lambda;
            self.moved = false;
        }
        if ratio < 0.25 {
            self.lambda += self.delta * (1.0 - ratio) / square;
        }
        let stuck = !self.moved && self.lambda > *LAMBDA.end();
        self.lambda = self.lambda.clamp(*LAMBDA.start(), *LAMBDA.end());
        (cost, stuck.then_some(Finish::DampingLimit))
    }
}

impl<T: Real> Trainer<T> for Scg<T> {
    fn step(&mut self, objective: &mut dyn Objective<T>, weights: &mut [T]) -> StepReport {
        let (mse, first) = match self.mse {
            Some(mse) => (mse, 0),
            None => {
                let mse = self.look(objective, weights, 0.0);
                self.take_descent();
                self.direction.copy_from_slice(&self.descent);
                (mse, 1)
            }
        };
        self.mse = Some(mse);
        let gradient_norm = norm(&self.descent);
        let (cost, finished) = if mse.is_finite() && gradient_norm.is_finite() {
            self.attempt(objective, weights, mse)
        } else {
            (0, Some(Finish::NotFinite))
        };
        StepReport { mse, gradient_norm, gradient_evaluations: first + cost, finished }
    }
}
