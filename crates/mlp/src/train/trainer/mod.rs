//! Training rules: each improves the weights of an objective, one epoch a step.
//!
//! | rule | module | cost of a step |
//! |---|---|---|
//! | steepest descent, and with momentum in two forms | [`gd`] | 1 gradient |
//! | RPROP, four variants | [`rprop`] | 1 gradient |
//! | scaled conjugate gradient | [`scg`] | 2 gradients, 1 after a rejected trial |
//! | with momentum and adaptive rate | [`gdx`] | 1 gradient |
//! | L-BFGS | [`lbfgs`] | 1 gradient, more where the line search goes on |
//! | Levenberg-Marquardt | [`lm`] | 1 Jacobian, 1 error per trial |
//! | Bayesian regularisation | [`br`] | the same, and the trace of an inverse |
//!
//! All run in `f32` and `f64`. Every rule is deterministic: equal starts give equal bits on one instruction set.

use core::str::FromStr;

use mlp_core::named::Unknown;

use super::lanes::{Isa, Real};
use super::objective::Objective;
use super::setting::{SettingError, above_one, not_negative, positive, share};
use super::vector::{add, combine, dot, finite, norm};

pub mod br;
pub mod gd;
pub mod gdx;
pub mod lbfgs;
pub mod lm;
pub mod rprop;
pub mod scg;

pub use br::Bayesian;
pub use gd::{GradientDescentConfig, Momentum, MomentumConfig, MomentumForm};
pub use gdx::{AdaptiveRate, AdaptiveRateConfig};
pub use lbfgs::Lbfgs;
pub use lm::{Damping, LevenbergMarquardt, LevenbergMarquardtConfig};
pub use rprop::{Rprop, RpropConfig, RpropVariant};
pub use scg::{Scg, ScgConfig};

/// What one step saw and did.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepReport {
    /// Mean squared error of the weights the step was given, before it changed them.
    pub mse: f64,
    /// Euclidean norm of the gradient there.
    pub gradient_norm: f64,
    /// Gradients computed (a Jacobian counts as one).
    pub gradient_evaluations: usize,
    /// Set when the rule can not go on; the weights are then those given.
    pub finished: Option<Finish>,
}

impl StepReport {
    /// A step that took one gradient and is not the last.
    fn moved(mse: f64, gradient_norm: f64) -> Self {
        Self { mse, gradient_norm, gradient_evaluations: 1, finished: None }
    }
}

mlp_core::named! {
    "reason",
    /// Why a rule can not improve the weights any more.
    pub enum Finish {
        /// The gradient is exactly zero.
        Flat = "gradient is zero",
        /// No step was short enough to lower the error: the damping reached its limit.
        DampingLimit = "no shorter step lowers the error",
        /// Steps no longer change error and penalty.
        Arrived = "error and penalty no longer change",
        /// The error or gradient is not finite.
        NotFinite = "error or gradient is not finite",
    }
}

/// A training rule with its memory of earlier steps.
pub trait Trainer<T = f64> {
    /// Improves `weights` by one epoch.
    ///
    /// Between the steps of one training the caller must not change objective or weights: rules remember
    /// gradients. `weights` has [`Objective::weights`] values.
    fn step(&mut self, objective: &mut dyn Objective<T>, weights: &mut [T]) -> StepReport;

    /// What the rule has found out about noise and weights, if it does: its last weights are then the best, not those of the lowest
    /// training error.
    fn evidence(&self) -> Option<Evidence> {
        None
    }
}

/// Noise and weights by the evidence of the training rows, in scaled units ([`br`]).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Evidence {
    /// 1 / (2 variance) of a weight.
    pub alpha: f64,
    /// 1 / (2 variance) of the noise of a target.
    pub beta: f64,
    /// Effective number of parameters, of as many as there are weights.
    pub effective: f64,
    /// Logarithm of the evidence.
    pub ln_evidence: f64,
}

/// A training rule and its settings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Algorithm {
    /// Steepest descent.
    Gd(GradientDescentConfig),
    /// Steepest descent with momentum.
    Gdm(MomentumConfig),
    /// Resilient propagation.
    Rprop(RpropConfig),
    /// Scaled conjugate gradient.
    Scg(ScgConfig),
    /// Steepest descent with momentum and adaptive rate.
    Gdx(AdaptiveRateConfig),
    /// Limited-memory BFGS.
    Lbfgs,
    /// Levenberg-Marquardt.
    Lm(LevenbergMarquardtConfig),
    /// Bayesian regularisation.
    Br,
}

/// Settings in place of the usual ones, for the rules that have them.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Hyper {
    /// Learning rate of gd, gdm and gdx.
    pub rate: Option<f64>,
    /// Momentum of gdm and gdx.
    pub momentum: Option<f64>,
    /// Which momentum of gdm.
    pub form: Option<MomentumForm>,
    /// Which RPROP.
    pub variant: Option<RpropVariant>,
    /// First step of RPROP.
    pub initial: Option<f64>,
    /// Growth of RPROP's steps.
    pub increase: Option<f64>,
    /// Shrinking of RPROP's steps.
    pub decrease: Option<f64>,
    /// Longest step of RPROP.
    pub max: Option<f64>,
    /// Step of SCG's probe for the curvature.
    pub sigma: Option<f64>,
    /// First damping of SCG.
    pub lambda: Option<f64>,
    /// First damping of LM.
    pub mu: Option<f64>,
}

impl Hyper {
    /// `algorithm` with these settings; those that it has not are left aside.
    #[must_use]
    pub fn of(&self, mut algorithm: Algorithm) -> Algorithm {
        match &mut algorithm {
            Algorithm::Gd(config) => config.rate = self.rate.unwrap_or(config.rate),
            Algorithm::Gdm(config) => {
                config.rate = self.rate.unwrap_or(config.rate);
                config.momentum = self.momentum.unwrap_or(config.momentum);
                config.form = self.form.unwrap_or(config.form);
            }
            Algorithm::Gdx(config) => {
                config.rate = self.rate.unwrap_or(config.rate);
                config.momentum = self.momentum.unwrap_or(config.momentum);
            }
            Algorithm::Rprop(config) => {
                config.variant = self.variant.unwrap_or(config.variant);
                config.initial = self.initial.unwrap_or(config.initial);
                config.increase = self.increase.unwrap_or(config.increase);
                config.decrease = self.decrease.unwrap_or(config.decrease);
                config.max = self.max.unwrap_or(config.max);
            }
            Algorithm::Scg(config) => {
                config.sigma = self.sigma.or(config.sigma);
                config.lambda = self.lambda.unwrap_or(config.lambda);
            }
            Algorithm::Lm(config) => config.mu = self.mu.unwrap_or(config.mu),
            Algorithm::Lbfgs | Algorithm::Br => {}
        }
        algorithm
    }
}

impl Algorithm {
    /// All rules with their usual settings.
    #[must_use]
    pub fn all() -> [Self; 8] {
        [
            Self::Gd(GradientDescentConfig::default()),
            Self::Gdm(MomentumConfig::default()),
            Self::Rprop(RpropConfig::default()),
            Self::Scg(ScgConfig::default()),
            Self::Lm(LevenbergMarquardtConfig::default()),
            Self::Gdx(AdaptiveRateConfig::default()),
            Self::Lbfgs,
            Self::Br,
        ]
    }

    /// Short name: `gd`, `gdm`, `rprop`, `scg`, `lm`, `gdx`, `lbfgs` or `br`.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        match self {
            Self::Gd(_) => "gd",
            Self::Gdm(_) => "gdm",
            Self::Rprop(_) => "rprop",
            Self::Scg(_) => "scg",
            Self::Lm(_) => "lm",
            Self::Gdx(_) => "gdx",
            Self::Lbfgs => "lbfgs",
            Self::Br => "br",
        }
    }

    /// Gradient norm below which training with this rule usually ends.
    #[must_use]
    pub const fn min_gradient(&self) -> f64 {
        match self {
            Self::Gd(_) | Self::Gdm(_) | Self::Gdx(_) | Self::Rprop(_) => 1e-5,
            Self::Scg(_) | Self::Lbfgs => 1e-6,
            Self::Lm(_) | Self::Br => 1e-7,
        }
    }

    /// Whether the settings are within the ranges their docs give.
    ///
    /// # Errors
    /// [`SettingError`] for the first that is not.
    pub fn check(&self) -> Result<(), SettingError> {
        match *self {
            Self::Gd(config) => positive("rate", config.rate),
            Self::Gdm(config) => {
                positive("rate", config.rate)?;
                check_momentum(config.momentum)
            }
            Self::Gdx(AdaptiveRateConfig { rate, momentum }) => {
                positive("rate", rate)?;
                check_momentum(momentum)
            }
            Self::Rprop(config) => {
                positive("initial", config.initial)?;
                positive("max", config.max)?;
                above_one("increase", config.increase)?;
                share("decrease", config.decrease)
            }
            Self::Scg(config) => {
                if let Some(sigma) = config.sigma {
                    positive("sigma", sigma)?;
                }
                positive("lambda", config.lambda)
            }
            Self::Lm(config) => positive("mu", config.mu),
            Self::Lbfgs | Self::Br => Ok(()),
        }
    }

    /// Largest number of weights the rule is meant for, if there is one.
    #[must_use]
    pub const fn max_weights(&self) -> Option<usize> {
        match self {
            Self::Lm(_) => Some(lm::MAX_WEIGHTS),
            Self::Br => Some(br::MAX_WEIGHTS),
            _ => None,
        }
    }

    /// A trainer without memory, ready for the first step on `weights` weights.
    #[must_use]
    pub fn trainer<T: Real>(&self, weights: usize) -> Box<dyn Trainer<T> + Send> {
        match *self {
            Self::Gd(config) => Box::new(Momentum::plain(config, weights)),
            Self::Gdm(config) => Box::new(Momentum::new(config, weights)),
            Self::Rprop(config) => Box::new(Rprop::new(config, weights)),
            Self::Scg(config) => Box::new(Scg::new(config, weights)),
            Self::Gdx(config) => Box::new(AdaptiveRate::new(config, weights)),
            Self::Lbfgs => Box::new(Lbfgs::new(weights)),
            Self::Lm(config) => Box::new(LevenbergMarquardt::new(config, weights)),
            Self::Br => Box::new(Bayesian::new(weights)),
        }
    }
}

impl FromStr for Algorithm {
    type Err = Unknown;

    /// The rule of that name with its usual settings.
    fn from_str(text: &str) -> Result<Self, Unknown> {
        let known = "gd, gdm, rprop, scg, lm, gdx, lbfgs, br";
        let unknown = Unknown { what: "algorithm", known };
        Self::all().into_iter().find(|known| known.name() == text).ok_or(unknown)
    }
}

fn check_momentum(momentum: f64) -> Result<(), SettingError> {
    if momentum >= 1.0 {
        return share("momentum", momentum);
    }
    not_negative("momentum", momentum)
}

#[cfg(test)]
mod tests;
