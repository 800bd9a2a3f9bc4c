//! Bayesian regularisation: Levenberg-Marquardt on `beta E_D + alpha E_W`, alpha and beta by their evidence.
//!
//! MacKay (1992); Foresee and Hagan (1997). With the sum of squared residuals `E_D` over n of them, the sum of squared weights `E_W` over N, the
//! Jacobian J and `r = alpha / beta`:
//!
//! ```text
//! A = J'J + r I        gamma = N - r tr(A^-1)        alpha = gamma / (2 E_W)        beta = (n - gamma) / (2 E_D)
//! ln evidence = -beta E_D - alpha E_W + n/2 ln(beta / pi) + N/2 ln r - 1/2 ln |A|
//! ```
//!
//! gamma is the effective number of parameters, from 0 to N: those that the data determine. The deviation of the noise is `1 / sqrt(2 beta)`.

use super::super::linear::{inverse_columns, log_determinant, product, solve_shifted};
use super::super::objective::count;
use super::lm::{LESS, MIN_MU, MORE, MOST, System};
use super::{Evidence, Finish, Objective, Real, StepReport, Trainer};

/// The trace of an inverse in each step: its time grows with the cube of the weights.
pub const MAX_WEIGHTS: usize = 1024;

/// First damping as a share of the largest diagonal element of `J'J`: that of MATLAB's trainbr, but for the scale.
const MU: f64 = 5e-3;
/// A step that lowers the regularised sum of squares by no more than this share has arrived, so many times in a row.
const ARRIVED: f64 = 1e-7;
const IN_A_ROW: u32 = 10;
/// Sums of squares below this are none.
const LEAST: f64 = 1e-300;

/// Bayesian regularisation. One step is one Jacobian, the trace of an inverse and as many trials as it takes; all of that in `f64`.
/// Penalty and noise are found from the training rows alone, so that no rows are held back for validation.
#[derive(Debug, Clone)]
pub struct Bayesian<T = f64> {
    mu: f64,
    system: System<T>,
    arrived: u32,
    evidence: Option<Evidence>,
}

impl<T: Real> Bayesian<T> {
    /// Ready for the first step on `weights` weights.
    #[must_use]
    pub fn new(weights: usize) -> Self {
        Self { mu: MU, system: System::new(weights), arrived: 0, evidence: None }
    }

    /// Estimates alpha and beta at weights with these sums of squares over `n` residuals; `None` where the matrix is not positive definite.
    fn estimate(&mut self, n: f64, residuals2: f64, weights2: f64) -> Option<Evidence> {
        let System { normal, factor, step, .. } = &mut self.system;
        let size = count(step.len());
        let (residuals2, weights2) = (residuals2.max(LEAST), weights2.max(LEAST));
        let of = |gamma: f64| {
            let alpha = gamma / (2.0 * weights2);
            // As many parameters as residuals: nothing is left that shows the noise.
            let free = if n > gamma { n - gamma } else { 1.0 };
            (alpha, free / (2.0 * residuals2))
        };
        let (alpha, beta) = self.evidence.map_or_else(|| of(size), |e| (e.alpha, e.beta));
        let ratio = alpha / beta;
        step.fill(0.0);
        solve_shifted(normal, ratio, factor, step)?;
        let mut trace = 0.0;
        inverse_columns(factor, step.len(), |_, column| trace += product(column, column));
        let gamma = size - ratio * trace;
        let gamma = gamma.clamp(1e-6 * size, size);
        let ln_determinant = log_determinant(factor, step.len());
        // Of the alpha and beta that the matrix is of.
        let ln_evidence = -beta * residuals2 - alpha * weights2
            + 0.5 * n * (beta / core::f64::consts::PI).ln()
            + 0.5 * size * ratio.ln()
            - 0.5 * ln_determinant;
        let (alpha, beta) = of(gamma);
        Some(Evidence { alpha, beta, effective: gamma, ln_evidence })
    }

    /// Moves `weights` to where the regularised sum of squares is below `sum`, by how much; `None` when no damping does.
    fn descend(
        &mut self,
        objective: &mut dyn Objective<T>,
        weights: &mut [T],
        ratio: f64,
        sum: f64,
    ) -> Option<f64> {
        let n = count(objective.residuals());
        let scale = self.system.scale(LEAST);
        let slopes = self.system.projected.iter().zip(&*weights);
        let right: Vec<f64> = slopes.map(|(p, w)| p + ratio * w.double()).collect();
        while self.mu <= MOST {
            let shift = ratio + self.mu * scale;
            let mse = self.system.try_step(objective, weights, &right, shift);
            let after = mse.map(|mse| n * mse + ratio * squares(&self.system.trial));
            if let Some(after) = after.filter(|after| *after < sum) {
                weights.copy_from_slice(&self.system.trial);
                self.mu = (self.mu * LESS).max(MIN_MU);
                return Some(sum - after);
            }
            self.mu *= MORE;
        }
        None
    }
}

impl<T: Real> Trainer<T> for Bayesian<T> {
    fn step(&mut self, objective: &mut dyn Objective<T>, weights: &mut [T]) -> StepReport {
        let n = count(objective.residuals());
        let (mse, gradient_norm) = self.system.read(objective, weights);
        let (residuals2, weights2) = (n * mse, squares(weights));
        let report =
            |finished| StepReport { mse, gradient_norm, gradient_evaluations: 1, finished };
        if !(mse.is_finite() && gradient_norm.is_finite()) {
            return report(Some(Finish::NotFinite));
        }
        // Where rounding leaves no matrix to solve with, nothing is left to be found.
        let Some(evidence) = self.estimate(n, residuals2, weights2) else {
            return report(Some(Finish::Arrived));
        };
        self.evidence = Some(evidence);
        let ratio = evidence.alpha / evidence.beta;
        let sum = residuals2 + ratio * weights2;
        let Some(fall) = self.descend(objective, weights, ratio, sum) else {
            return report(Some(Finish::DampingLimit));
        };
        self.arrived = if fall <= ARRIVED * sum { self.arrived + 1 } else { 0 };
        report((self.arrived >= IN_A_ROW).then_some(Finish::Arrived))
    }

    fn evidence(&self) -> Option<Evidence> {
        self.evidence
    }
}

fn squares<T: Real>(weights: &[T]) -> f64 {
    weights.iter().map(|w| w.double().powi(2)).sum()
}
