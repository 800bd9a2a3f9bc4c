//! Run of a trainer on an objective under stop rules: the best weights, the error curve and the stop reason.

use core::fmt;
use core::time::Duration;

use super::lanes::Real;
use super::objective::Objective;
use super::setting::{SettingError, not_negative};
use super::trainer::{Evidence, Finish, Trainer};
use super::vector::finite;

/// Training error, as a multiple of the first one, that counts as divergence.
const DIVERGENCE: f64 = 1000.0;

/// When to stop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RunConfig {
    /// Largest number of epochs. Default 1000.
    pub epochs: usize,
    /// Training error that is good enough, in scaled units squared. Default 0.
    pub goal: f64,
    /// Gradient norm that counts as level ground. Default 0;
    /// [`Algorithm::min_gradient`](super::Algorithm::min_gradient) has the usual ones.
    pub min_gradient: f64,
    /// Epochs in a row without a new best validation error before training stops. Default 6.
    pub max_fail: usize,
    /// Time after which no further epoch begins, by the clock of [`Training::elapsed`]. Default none.
    pub time_limit: Option<Duration>,
}

impl Default for RunConfig {
    fn default() -> Self {
        Self { epochs: 1000, goal: 0.0, min_gradient: 0.0, max_fail: 6, time_limit: None }
    }
}

impl RunConfig {
    /// Whether goal and limits are not negative.
    ///
    /// # Errors
    /// [`SettingError`] for the first that is not.
    pub fn check(&self) -> Result<(), SettingError> {
        not_negative("goal", self.goal)?;
        not_negative("min_gradient", self.min_gradient)
    }
}

/// Why training stopped.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Stop {
    /// All epochs were used.
    Epochs,
    /// The training error reached the goal.
    Goal,
    /// The gradient fell to the limit.
    Gradient,
    /// The validation error had no new best for [`RunConfig::max_fail`] epochs.
    Validation,
    /// The time was used up.
    Time,
    /// The training error grew beyond the limit, or it or a weight is not finite.
    Diverged {
        /// Epoch at which that was seen.
        epoch: usize,
        /// The error there.
        mse: f64,
    },
    /// The rule itself found no way down.
    Finished(Finish),
}

impl fmt::Display for Stop {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Epochs => f.write_str("all epochs used"),
            Self::Goal => f.write_str("goal reached"),
            Self::Gradient => f.write_str("gradient below its limit"),
            Self::Time => f.write_str("time limit reached"),
            Self::Validation => f.write_str("validation error no longer falls"),
            Self::Diverged { epoch, mse } => {
                write!(f, "diverged at epoch {epoch} with error {mse:e}; best weights kept")
            }
            Self::Finished(finish) => finish.fmt(f),
        }
    }
}

/// The outcome of one training.
#[derive(Debug, Clone, PartialEq)]
pub struct Run {
    /// Weights of the best epoch: lowest validation error if there were validation rows, otherwise lowest
    /// training error.
    pub weights: Vec<f64>,
    /// That epoch.
    pub best_epoch: usize,
    /// Training error of `weights`.
    pub mse: f64,
    /// Training error before each epoch and, last, after the final one.
    pub history: Vec<f64>,
    /// The same of the validation rows, empty without them.
    pub validation: Vec<f64>,
    /// Epochs done.
    pub epochs: usize,
    /// Gradients computed, the honest cost where rules differ in gradients an epoch.
    pub gradient_evaluations: usize,
    /// Why it stopped.
    pub stop: Stop,
    /// Noise and weights by their evidence, of a rule that estimates them; none with validation rows.
    pub evidence: Option<Evidence>,
}

impl Run {
    /// Variance of the noise of the training rows, scaled: by the evidence, or the training error where there is none.
    #[must_use]
    pub fn noise(&self) -> f64 {
        self.evidence.map_or(self.mse, |found| 0.5 / found.beta)
    }
}

/// The best weights seen so far.
struct Best<T> {
    weights: Vec<T>,
    epoch: usize,
    mse: f64,
    score: f64,
}

/// A run under way.
struct Progress<'a, T> {
    config: &'a RunConfig,
    best: Best<T>,
    history: Vec<f64>,
    validation: Vec<f64>,
}

impl<T: Real> Progress<'_, T> {
    /// Notes the errors of `weights` at the next epoch; returns a reason to stop there.
    /// A rule that `regularises` ends where it is best.
    fn note(
        &mut self,
        weights: &[T],
        mse: f64,
        validation: Option<f64>,
        regularises: bool,
    ) -> Option<Stop> {
        let epoch = self.history.len();
        self.history.push(mse);
        self.validation.extend(validation);
        let first = self.history[0];
        if !mse.is_finite() || mse > DIVERGENCE * first {
            return Some(Stop::Diverged { epoch, mse });
        }
        let score = validation.unwrap_or(mse);
        if score < self.best.score || (regularises && validation.is_none()) {
            // An infinite weight may hide behind a saturated neuron.
            if !finite(weights) {
                return Some(Stop::Diverged { epoch, mse });
            }
            let best = &mut self.best;
            best.weights.copy_from_slice(weights);
            (best.epoch, best.mse, best.score) = (epoch, mse, score);
        }
        if mse <= self.config.goal {
            return Some(Stop::Goal);
        }
        let failed = validation.is_some() && epoch - self.best.epoch >= self.config.max_fail;
        failed.then_some(Stop::Validation)
    }
}

/// What a run works with.
#[expect(missing_debug_implementations, reason = "trainers and objectives are borrowed as traits")]
pub struct Training<'a, T = f64> {
    /// The rule, without memory of other runs.
    pub trainer: &'a mut dyn Trainer<T>,
    /// The training rows.
    pub objective: &'a mut dyn Objective<T>,
    /// The validation rows; their error decides which weights are best and can stop the training.
    pub validation: Option<&'a mut dyn Objective<T>>,
    /// Time since the run began, read before each epoch if there is a limit: the library has no clock.
    pub elapsed: &'a dyn Fn() -> Duration,
}

impl<'a, T> Training<'a, T> {
    /// Without validation rows and without a clock.
    pub fn new(trainer: &'a mut dyn Trainer<T>, objective: &'a mut dyn Objective<T>) -> Self {
        Self { trainer, objective, validation: None, elapsed: &|| Duration::ZERO }
    }
}

/// Trains from `weights` until a rule of `config` stops it.
///
/// `weights` must have as many values as the objective wants. If the very first error is not finite, the run
/// reports divergence at epoch 0 and returns the weights it was given.
#[must_use]
pub fn run<T: Real>(training: Training<'_, T>, mut weights: Vec<T>, config: &RunConfig) -> Run {
    let Training { trainer, objective, mut validation, elapsed } = training;
    let mut progress = Progress {
        config,
        best: Best { weights: weights.clone(), epoch: 0, mse: f64::NAN, score: f64::INFINITY },
        history: Vec::new(),
        validation: Vec::new(),
    };
    let mut before = weights.clone();
    let mut gradient_evaluations = 0;
    let mut epochs = 0;
    let stop = loop {
        let validation_mse = validation.as_mut().map(|rows| rows.mse(&weights));
        let now = elapsed();
        let late = config.time_limit.is_some_and(|limit| now >= limit);
        if epochs == config.epochs || late {
            let mse = objective.mse(&weights);
            let reason = if late { Stop::Time } else { Stop::Epochs };
            let regularises = trainer.evidence().is_some();
            break progress.note(&weights, mse, validation_mse, regularises).unwrap_or(reason);
        }
        before.copy_from_slice(&weights);
        let report = trainer.step(objective, &mut weights);
        gradient_evaluations += report.gradient_evaluations;
        let regularises = trainer.evidence().is_some();
        if let Some(stop) = progress.note(&before, report.mse, validation_mse, regularises) {
            break stop;
        }
        if let Some(finish) = report.finished {
            break Stop::Finished(finish);
        }
        if report.gradient_norm <= config.min_gradient {
            break Stop::Gradient;
        }
        epochs += 1;
    };
    let Progress { best, history, validation, .. } = progress;
    let validated = !validation.is_empty();
    Run {
        weights: best.weights.iter().map(|weight| weight.double()).collect(),
        best_epoch: best.epoch,
        mse: best.mse,
        history,
        validation,
        epochs,
        gradient_evaluations,
        stop,
        // With validation rows other weights are kept than the last.
        evidence: trainer.evidence().filter(|_| !validated),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::train::trainer::StepReport;

    /// Walks along a list of training errors; the weight is the epoch.
    struct Walk {
        errors: Vec<f64>,
        gradient_norm: f64,
    }

    impl Trainer for Walk {
        fn step(&mut self, objective: &mut dyn Objective, weights: &mut [f64]) -> StepReport {
            let mse = objective.mse(weights);
            weights[0] += 1.0;
            let finished = (self.errors.len() < 2).then_some(Finish::DampingLimit);
            let gradient_norm = self.gradient_norm;
            StepReport { mse, gradient_norm, gradient_evaluations: 2, finished }
        }
    }

    /// Looks up the error of an epoch.
    impl Objective for Vec<f64> {
        fn weights(&self) -> usize {
            1
        }

        fn residuals(&self) -> usize {
            1
        }

        fn mse(&mut self, weights: &[f64]) -> f64 {
            self.iter().copied().enumerate().find(|(at, _)| count(*at) >= weights[0]).unwrap().1
        }

        fn gradient(&mut self, weights: &[f64], _: &mut [f64]) -> f64 {
            self.mse(weights)
        }

        fn normal_equations(&mut self, weights: &[f64], _: &mut [f64], _: &mut [f64]) -> f64 {
            self.mse(weights)
        }
    }

    use crate::train::objective::count;

    fn walk(errors: &[f64], validation: Option<&[f64]>, config: RunConfig) -> Run {
        let mut trainer = Walk { errors: errors.to_vec(), gradient_norm: 1.0 };
        let mut rows = validation.map(<[f64]>::to_vec);
        let rows = rows.as_mut().map(|rows| rows as &mut dyn Objective);
        let clock = core::cell::Cell::new(0);
        let elapsed = || Duration::from_secs(clock.replace(clock.get() + 1));
        let mut objective = errors.to_vec();
        let training = Training {
            trainer: &mut trainer,
            objective: &mut objective,
            validation: rows,
            elapsed: &elapsed,
        };
        run(training, vec![0.0], &config)
    }

    fn epochs(epochs: usize) -> RunConfig {
        RunConfig { epochs, ..RunConfig::default() }
    }

    #[test]
    fn all_epochs_give_one_more_error() {
        let outcome = walk(&[4.0, 3.0, 2.0, 2.5], None, epochs(3));
        assert_eq!((outcome.stop, outcome.epochs), (Stop::Epochs, 3));
        assert_eq!(outcome.history, [4.0, 3.0, 2.0, 2.5]);
        assert_eq!((outcome.best_epoch, outcome.gradient_evaluations), (2, 6));
        assert_eq!((outcome.weights, outcome.mse.to_bits()), (vec![2.0], 2_f64.to_bits()));
    }

    #[test]
    fn no_epoch_begins_after_the_time_limit() {
        let config = RunConfig { time_limit: Some(Duration::from_secs(2)), ..epochs(3) };
        let outcome = walk(&[4.0, 3.0, 2.0, 1.0], None, config);
        assert_eq!((outcome.stop, outcome.epochs, outcome.best_epoch), (Stop::Time, 2, 2));
        let outcome = walk(&[4.0, 3.0, 2.0, 1.0], None, epochs(3));
        assert_eq!(outcome.stop, Stop::Epochs, "no limit, no reading of the clock");
    }

    #[test]
    fn the_goal_stops_before_an_update_counts() {
        let outcome = walk(&[4.0, 3.0, 1.0, 0.5], None, RunConfig { goal: 1.0, ..epochs(3) });
        assert_eq!((outcome.stop, outcome.epochs, outcome.weights), (Stop::Goal, 2, vec![2.0]));
    }

    #[test]
    fn validation_without_a_new_best_stops_and_its_best_weights_are_kept() {
        let errors: Vec<f64> = (0..9).map(|epoch| 9.0 - f64::from(epoch)).collect();
        let validation = [5.0, 4.0, 4.5, 4.0, 6.0, 3.0, 2.0, 1.0, 0.5];
        let outcome = walk(&errors, Some(&validation), RunConfig { max_fail: 3, ..epochs(8) });
        assert_eq!((outcome.stop, outcome.epochs), (Stop::Validation, 4));
        assert_eq!((outcome.weights, outcome.mse.to_bits()), (vec![1.0], 8_f64.to_bits()));
        assert_eq!(outcome.validation, validation[..5]);
    }

    #[test]
    fn growth_and_nan_are_divergence_and_keep_the_best_weights() {
        for wild in [f64::NAN, f64::INFINITY, 4001.0] {
            let outcome = walk(&[4.0, 3.0, wild, 1.0], None, epochs(5));
            assert!(matches!(outcome.stop, Stop::Diverged { epoch: 2, .. }), "{}", outcome.stop);
            assert_eq!(outcome.weights, [1.0]);
        }
        let outcome = walk(&[f64::NAN], None, epochs(5));
        assert!(matches!(outcome.stop, Stop::Diverged { epoch: 0, .. }) && outcome.mse.is_nan());
    }

    #[test]
    fn a_level_gradient_and_a_finished_rule_stop() {
        let outcome = walk(&[4.0, 3.0], None, RunConfig { min_gradient: 1.0, ..epochs(5) });
        assert_eq!((outcome.stop, outcome.epochs), (Stop::Gradient, 0));
        let outcome = walk(&[4.0], None, epochs(5));
        assert_eq!(outcome.stop, Stop::Finished(Finish::DampingLimit));
        assert_eq!(outcome.stop.to_string(), "no shorter step lowers the error");
    }
}
