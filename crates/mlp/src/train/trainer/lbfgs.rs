//! Limited-memory BFGS: quasi-Newton steps from the last few gradients.
//!
//! Nocedal (1980), two-loop recursion; steps satisfy the weak Wolfe conditions by bisection (Lewis and Overton 2013).

use std::collections::VecDeque;

use super::{Finish, Objective, Real, StepReport, Trainer, add, combine, dot, finite, norm};

/// Share of the slope by which the error must fall.
const ENOUGH_FALL: f64 = 1e-4;

/// Share of the slope that may be left.
const ENOUGH_FLATTER: f64 = 0.9;

/// Gradients a line search may cost.
const TRIALS: usize = 30;

/// Steps remembered.
const MEMORY: usize = 10;

/// One remembered step.
#[derive(Debug, Clone)]
struct Pair<T> {
    /// Change of the weights.
    step: Vec<T>,
    /// Change of the gradient.
    change: Vec<T>,
    /// Their inner product, above 0.
    curvature: f64,
}

/// Limited-memory BFGS. One step is one line search, usually of one gradient.
#[derive(Debug, Clone)]
pub struct Lbfgs<T = f64> {
    pairs: VecDeque<Pair<T>>,
    /// Error at the current weights once they are known.
    mse: Option<f64>,
    gradient: Vec<T>,
    direction: Vec<T>,
    trial: Vec<T>,
    trial_gradient: Vec<T>,
    shares: [f64; MEMORY],
}

/// How a line search ended.
struct Found {
    mse: f64,
    gradients: usize,
    /// A point with a lower error is in `trial`.
    lower: bool,
}

impl<T: Real> Lbfgs<T> {
    /// Ready for the first step on `weights` weights.
    #[must_use]
    pub fn new(weights: usize) -> Self {
        let zeros = vec![T::default(); weights];
        Self {
            pairs: VecDeque::with_capacity(MEMORY),
            mse: None,
            gradient: zeros.clone(),
            direction: zeros.clone(),
            trial: zeros.clone(),
            trial_gradient: zeros,
            shares: [0.0; MEMORY],
        }
    }

    /// `direction = -H g` with the inverse Hessian H that the remembered steps imply.
    fn aim(&mut self) {
        for (d, &g) in self.direction.iter_mut().zip(&self.gradient) {
            *d = -g;
        }
        for (pair, share) in self.pairs.iter().zip(&mut self.shares).rev() {
            *share = dot(&pair.step, &self.direction) / pair.curvature;
            add(&mut self.direction, -*share, &pair.change);
        }
        let Some(last) = self.pairs.back() else { return };
        let scale = T::of(last.curvature / dot(&last.change, &last.change));
        for d in &mut self.direction {
            *d = scale * *d;
        }
        for (pair, share) in self.pairs.iter().zip(&self.shares) {
            let back = dot(&pair.change, &self.direction) / pair.curvature;
            add(&mut self.direction, share - back, &pair.step);
        }
    }

    /// The slope along the direction; starts afresh with the steepest descent unless it descends.
    fn slope(&mut self) -> f64 {
        self.aim();
        let slope = dot(&self.direction, &self.gradient);
        if slope < 0.0 && slope.is_finite() && finite(&self.direction) {
            return slope;
        }
        self.pairs.clear();
        self.aim();
        dot(&self.direction, &self.gradient)
    }

    /// Looks for a point that is lower and flatter, by doubling and bisection.
    fn search(
        &mut self,
        objective: &mut dyn Objective<T>,
        weights: &[T],
        mse: f64,
        slope: f64,
    ) -> Found {
        // Without memory the direction has the length of the gradient, which shows nothing about the distance.
        let first = if self.pairs.is_empty() { (1.0 / (-slope).sqrt()).min(1.0) } else { 1.0 };
        let (mut low, mut high, mut length) = (0.0, f64::INFINITY, first);
        let mut found = Found { mse, gradients: 0, lower: false };
        while found.gradients < TRIALS {
            combine(&mut self.trial, weights, length, &self.direction);
            found.mse = objective.gradient(&self.trial, &mut self.trial_gradient);
            found.gradients += 1;
            let usable = found.mse.is_finite() && finite(&self.trial_gradient);
            found.lower = usable && found.mse < mse;
            if !usable || found.mse > mse + ENOUGH_FALL * length * slope {
                high = length;
            } else if dot(&self.trial_gradient, &self.direction) < ENOUGH_FLATTER * slope {
                low = length;
            } else {
                break;
            }
            length = if high.is_finite() { 0.5 * (low + high) } else { 2.0 * low };
            if length == low || length == high || !length.is_finite() {
                break;
            }
        }
        found
    }

    /// Remembers the step to `trial` in place of the oldest one.
    fn remember(&mut self, weights: &[T]) {
        let (mut step, mut change) = (self.trial.clone(), self.trial.clone());
        combine(&mut step, &self.trial, -1.0, weights);
        combine(&mut change, &self.trial_gradient, -1.0, &self.gradient);
        if self.pairs.len() == MEMORY {
            self.pairs.pop_front();
        }
        let curvature = dot(&step, &change);
        if curvature > f64::EPSILON * norm(&step) * norm(&change) {
            self.pairs.push_back(Pair { step, change, curvature });
        }
    }

    /// Moves the weights; returns the gradients that cost and why it was the last step, if it was.
    fn advance(
        &mut self,
        objective: &mut dyn Objective<T>,
        weights: &mut [T],
        mse: f64,
    ) -> (usize, Option<Finish>) {
        let mut cost = 0;
        loop {
            let slope = self.slope();
            if slope == 0.0 {
                return (cost, Some(Finish::Flat));
            }
            let remembered = !self.pairs.is_empty();
            let found = self.search(objective, weights, mse, slope);
            cost += found.gradients;
            if found.lower {
                self.remember(weights);
                weights.copy_from_slice(&self.trial);
                core::mem::swap(&mut self.gradient, &mut self.trial_gradient);
                self.mse = Some(found.mse);
                return (cost, None);
            }
            self.pairs.clear();
            if !remembered {
                return (cost, Some(Finish::DampingLimit));
            }
        }
    }
}

impl<T: Real> Trainer<T> for Lbfgs<T> {
    fn step(&mut self, objective: &mut dyn Objective<T>, weights: &mut [T]) -> StepReport {
        let (mse, first) = match self.mse {
            Some(mse) => (mse, 0),
            None => (objective.gradient(weights, &mut self.gradient), 1),
        };
        self.mse = Some(mse);
        let gradient_norm = norm(&self.gradient);
        let (cost, finished) = if !(mse.is_finite() && gradient_norm.is_finite()) {
            (0, Some(Finish::NotFinite))
        } else if gradient_norm == 0.0 {
            (0, Some(Finish::Flat))
        } else {
            self.advance(objective, weights, mse)
        };
        StepReport { mse, gradient_norm, gradient_evaluations: first + cost, finished }
    }
}
