//! Fit of data sets by settings: a chosen trained model with its errors.

use core::time::Duration;

use super::data::DataSet;
use super::file::{FileError, LargeModel, ModelFile, TrainingNote};
use super::init::nguyen_widrow;
use super::lanes::Real;
use super::metrics::{EvaluateError, Evaluation, evaluate};
use super::objective::{NetworkObjective, Objective, count};
use super::run::{Run, RunConfig, Stop, Training, run};
use super::scaling::{Method, Scaling, as_min_max, columns};
use super::setting::{SettingError, at_least_one};
use super::topology::Topology;
use super::trainer::Algorithm;
use crate::activation::Activation;
use crate::model::Column;
use crate::network::ShapeError;
use ndarray::Array2;

/// Which of several runs becomes the model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Choice {
    /// The one with the lowest training error.
    #[default]
    Best,
    /// The one whose training error is nearest the average of all runs: the typical outcome.
    NearestAverage,
}

/// Precision of the arithmetic of a training.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Precision {
    /// `f32`: two to four times as fast. Errors below about 1e-10 of the first one drown in rounding.
    Single,
    /// `f64`.
    #[default]
    Double,
}

/// What to train and how.
#[derive(Debug, Clone, PartialEq)]
pub struct FitConfig {
    /// Neurons of each hidden layer; outputs are linear. Default one layer of 10.
    pub hidden: Vec<usize>,
    /// Function of the hidden neurons. Default tanh.
    pub activation: Activation,
    /// Training rule. Default RPROP.
    pub algorithm: Algorithm,
    /// Stop rules.
    pub run: RunConfig,
    /// Seed of the first run; the others count up from it. Default 0.
    pub seed: u64,
    /// Number of runs, at least 1. Default 1.
    pub repeats: usize,
    /// Which run becomes the model. Default the best.
    pub choice: Choice,
    /// Precision of the training; saved weights are `f32` in any case. Default double.
    pub precision: Precision,
    /// Penalty `decay / 2 * sum w^2` on the weights without the biases, in scaled units. Default 0.
    pub decay: f64,
    /// What the training sees of the columns; the saved model has min-max limits in any case. Default min-max.
    pub scaler: Method,
}

impl Default for FitConfig {
    fn default() -> Self {
        Self {
            hidden: vec![10],
            activation: Activation::Tanh,
            algorithm: Algorithm::Rprop(super::trainer::RpropConfig::default()),
            run: RunConfig::default(),
            seed: 0,
            repeats: 1,
            choice: Choice::Best,
            precision: Precision::Double,
            decay: 0.0,
            scaler: Method::MinMax,
        }
    }
}

/// Why there is no trained model.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum FitError {
    /// A setting out of its range.
    #[error(transparent)]
    Setting(#[from] SettingError),
    /// More weights than the rule can handle.
    #[error("{weights} weights: {algorithm} is meant for at most {limit}")]
    TooManyWeights {
        /// Name of the rule.
        algorithm: &'static str,
        /// Weights of the network.
        weights: usize,
        /// Largest number.
        limit: usize,
    },
    /// A rule for squares where classes are to be distinguished.
    #[error("{algorithm} minimises squares only: classes need another rule")]
    Squares {
        /// Name of the rule.
        algorithm: &'static str,
    },
    /// A penalty beside that of Bayesian regularisation.
    #[error("br finds the penalty on large weights by itself: leave the decay at 0")]
    Decay,
    /// Layers out of limits, or weights too large for the model's precision.
    #[error(transparent)]
    Shape(#[from] ShapeError),
    /// Training, validation or test rows have other columns than the training rows.
    #[error("{file} was read with other columns than the training rows")]
    OtherColumns {
        /// Name of the file.
        file: String,
    },
    /// Every run diverged before any epoch was better than its random start.
    #[error(
        "diverged at once: none of {runs} runs was ever better than its random start; take a smaller rate or another rule"
    )]
    Diverged {
        /// Number of runs.
        runs: usize,
    },
    /// The trained network can not be saved.
    #[error(transparent)]
    File(#[from] FileError),
    /// The trained model has no prediction for a row.
    #[error("{file}: {source}")]
    Evaluate {
        /// Name of the file.
        file: String,
        /// Which row and why.
        source: EvaluateError,
    },
}

/// A trained model.
#[derive(Debug, Clone)]
pub struct Fit {
    /// What is saved.
    pub file: ModelFile,
    /// The model in it; its limits of 1,024 columns are too much for the stack of one who trains in parallel.
    pub model: Box<LargeModel>,
    /// All runs, in order of their seeds.
    pub runs: Vec<Run>,
    /// Place of the run that became the model.
    pub chosen: usize,
    /// Errors of the saved model on the training rows.
    pub train: Evaluation,
    /// Errors of the saved model on the test rows.
    pub test: Option<Evaluation>,
    /// What speaks against the model: [`warnings`] of its rows and, with `r2`, of its answers.
    pub warnings: Vec<String>,
}

impl Fit {
    /// The same, unless its run diverged before any epoch was better than the random start: a study counts such runs, a user wants no
    /// such model.
    ///
    /// # Errors
    /// [`FitError::Diverged`].
    pub fn learned(self) -> Result<Self, FitError> {
        let at_once = |run: &Run| run.best_epoch == 0 && matches!(run.stop, Stop::Diverged { .. });
        match self.runs.get(self.chosen).is_some_and(at_once) {
            true => Err(FitError::Diverged { runs: self.runs.len() }),
            false => Ok(self),
        }
    }
}

/// What speaks against rows for a model of `weights` weights: columns that do not vary, and as few rows as it can learn by heart.
#[must_use]
pub fn warnings(rows: &DataSet, weights: usize) -> Vec<String> {
    let (inputs, targets) = rows.scalings(Method::MinMax);
    let mut found = Vec::new();
    let columns = rows.inputs.iter().zip(&inputs).map(|column| (column, false));
    let targets = rows.targets.iter().zip(&targets).map(|column| (column, true));
    for ((spec, limits), target) in columns.chain(targets) {
        let (name, Column { min, max, .. }) = (&spec.name, limits.column);
        if min == max {
            found.push(if target {
                format!("target \"{name}\" is {min} in every row: nothing to be learned")
            } else {
                format!("input \"{name}\" is {min} in every row: nothing is learned of it, and every other value will be outside the training range; leave it out")
            });
        } else if limits.column.is_constant_in_single() {
            found.push(format!(
                "\"{name}\" varies by {:.3e} about {min}, which seven digits do not show: gripd and exports compute in f32 and will see a constant; subtract a fixed value from it",
                max - min
            ));
        }
    }
    let values = rows.rows() * if rows.classes.is_some() { 1 } else { rows.targets.len() };
    if values <= weights {
        found.push(format!(
            "{} rows for {weights} weights: a network learns so few by heart; take fewer hidden neurons or judge it on rows that it has not seen",
            rows.rows()
        ));
    }
    found
}

/// The same of answers whose [`Evaluation::r2`] is `r2` on rows called `of`.
#[must_use]
pub fn no_better_than_the_mean(of: &str, r2: Option<f64>) -> Option<String> {
    let r2 = r2.filter(|r2| *r2 <= 0.0)?;
    Some(format!("R2 is {r2:.2} on the {of} rows: no better than answering their mean every time"))
}

/// Scaled rows and settings from which runs start, each on its own.
#[derive(Debug, Clone)]
pub struct Fitting<'a> {
    train: &'a DataSet,
    config: &'a FitConfig,
    inputs: Vec<Scaling>,
    targets: Vec<Scaling>,
    topology: Topology,
    rows: Rows,
}

/// Training and validation rows, laid out for one precision.
#[derive(Debug, Clone)]
enum Rows {
    Single(Pair<f32>),
    Double(Pair<f64>),
}

#[derive(Debug, Clone)]
struct Pair<T> {
    train: NetworkObjective<T>,
    validation: Option<NetworkObjective<T>>,
}

impl<T: Real> Pair<T> {
    fn new(
        topology: &Topology,
        train: &[Array2<f64>; 2],
        validation: Option<&[Array2<f64>; 2]>,
        classes: bool,
        decay: f64,
    ) -> Result<Self, FitError> {
        let objective = |[inputs, targets]: &[Array2<f64>; 2]| {
            let squares = NetworkObjective::new(topology, inputs, targets)?;
            Ok::<_, ShapeError>(if classes { squares.with_softmax() } else { squares })
        };
        let validation = validation.map(objective).transpose()?;
        Ok(Self { train: objective(train)?.with_decay(decay)?, validation })
    }

    fn run(&self, config: &FitConfig, seed: u64, elapsed: &dyn Fn() -> Duration) -> Run {
        let Self { mut train, mut validation } = self.clone();
        let weights: Vec<T> =
            nguyen_widrow(train.topology(), seed).into_iter().map(T::of).collect();
        let mut trainer = config.algorithm.trainer(weights.len());
        let validation = validation.as_mut().map(|rows| rows as &mut dyn Objective<T>);
        let training =
            Training { trainer: trainer.as_mut(), objective: &mut train, validation, elapsed };
        run(training, weights, &config.run)
    }
}

impl<'a> Fitting<'a> {
    /// Scales the rows by the limits of the training rows.
    ///
    /// # Errors
    /// [`FitError::Setting`], [`FitError::Shape`], [`FitError::TooManyWeights`],
    /// [`FitError::Squares`], [`FitError::Decay`] or [`FitError::OtherColumns`].
    pub fn new(
        train: &'a DataSet,
        validation: Option<&DataSet>,
        config: &'a FitConfig,
    ) -> Result<Self, FitError> {
        at_least_one("repeats", config.repeats)?;
        config.algorithm.check()?;
        config.run.check()?;
        let (n_in, n_out) = (train.inputs.len(), train.targets.len());
        let topology = Topology::with_hidden(n_in, &config.hidden, config.activation, n_out)?;
        let (algorithm, weights) = (config.algorithm.name(), topology.weights());
        if let Some(limit) = config.algorithm.max_weights().filter(|limit| weights > *limit) {
            return Err(FitError::TooManyWeights { algorithm, weights, limit });
        }
        if config.algorithm == Algorithm::Br && config.decay != 0.0 {
            return Err(FitError::Decay);
        }
        if let (Some(_), Algorithm::Lm(_) | Algorithm::Br) = (&train.classes, &config.algorithm) {
            return Err(FitError::Squares { algorithm });
        }
        let (inputs, targets) = train.scalings(config.scaler);
        let scaled = |data: &DataSet| {
            check_columns(train, data)?;
            Ok::<_, FitError>(data.scaled(&inputs, &targets))
        };
        let (rows, validation) = (scaled(train)?, validation.map(scaled).transpose()?);
        let (validation, classes) = (validation.as_ref(), train.classes.is_some());
        let decay = config.decay;
        let rows = match config.precision {
            Precision::Single => {
                Rows::Single(Pair::new(&topology, &rows, validation, classes, decay)?)
            }
            Precision::Double => {
                Rows::Double(Pair::new(&topology, &rows, validation, classes, decay)?)
            }
        };
        Ok(Self { train, config, inputs, targets, topology, rows })
    }

    /// Number of weights and biases of the network.
    #[must_use]
    pub fn weights(&self) -> usize {
        self.topology.weights()
    }

    /// Trains from the starting weights of seed `config.seed + repeat`, without a clock: a time limit never ends it.
    /// Runs are independent, so they may go in parallel; each gives the same result on any thread.
    #[must_use]
    pub fn run(&self, repeat: usize) -> Run {
        self.run_timed(repeat, &|| Duration::ZERO)
    }

    /// The same with a clock: `elapsed`, asked before each epoch, gives the time since the training began.
    #[must_use]
    pub fn run_timed(&self, repeat: usize, elapsed: &dyn Fn() -> Duration) -> Run {
        let seed = self.seed(repeat);
        match &self.rows {
            Rows::Single(rows) => rows.run(self.config, seed, elapsed),
            Rows::Double(rows) => rows.run(self.config, seed, elapsed),
        }
    }

    /// Chooses among `runs`, which are those of repeats 0, 1, ..., and evaluates the saved model.
    ///
    /// # Errors
    /// [`FitError::Diverged`]; [`FitError::OtherColumns`];
    /// [`FitError::Shape`] and [`FitError::File`] when weights overflow; [`FitError::Evaluate`].
    pub fn finish(&self, runs: Vec<Run>, test: Option<&DataSet>) -> Result<Fit, FitError> {
        let chosen =
            choose(&runs, self.config.choice).ok_or(FitError::Diverged { runs: runs.len() })?;
        let mut file = ModelFile::new(
            &columns(&self.train.inputs, &self.inputs),
            &columns(&self.train.targets, &self.targets),
            &self.topology,
            &as_min_max(&self.topology, &runs[chosen].weights, &self.inputs, &self.targets),
        );
        file.classes.clone_from(&self.train.classes);
        // That of a run is one for all targets.
        let noise = if self.targets.len() == 1 { runs[chosen].noise() } else { 0.0 };
        for (column, scaling) in file.targets.iter_mut().zip(&self.targets) {
            column.set_noise(noise / scaling.over_min_max()[0].powi(2));
        }
        let model = Box::new(file.large_model()?);
        let train = self.evaluate(&model, self.train)?;
        let test = test.map(|data| self.evaluate(&model, data)).transpose()?;
        file.training = Some(TrainingNote {
            algorithm: self.config.algorithm.name().to_owned(),
            seed: self.seed(chosen),
            repeats: runs.len(),
            epochs: runs[chosen].epochs,
            stop: runs[chosen].stop.to_string(),
            rows: self.train.rows(),
            data_sha256: self.train.sha256.clone(),
            train_mse: train.mse,
            train_scaled_mse: train.scaled_mse,
            test_mse: test.as_ref().map(|test| test.mse),
            test_scaled_mse: test.as_ref().map(|test| test.scaled_mse),
            split: None,
        });
        let mut warnings = warnings(self.train, self.weights());
        let of = test.as_ref().map_or(("training", train.r2), |test| ("test", test.r2));
        warnings.extend(no_better_than_the_mean(of.0, of.1));
        Ok(Fit { file, model, runs, chosen, train, test, warnings })
    }

    fn seed(&self, repeat: usize) -> u64 {
        self.config.seed.wrapping_add(repeat as u64)
    }

    fn evaluate(&self, model: &LargeModel, data: &DataSet) -> Result<Evaluation, FitError> {
        check_columns(self.train, data)?;
        evaluate(model, data)
            .map_err(|source| FitError::Evaluate { file: data.file.clone(), source })
    }
}

/// Trains `config.repeats` times, one after the other, and keeps the chosen model.
///
/// # Errors
/// As [`Fitting::new`], [`Fitting::finish`] and [`Fit::learned`].
pub fn fit(
    train: &DataSet,
    validation: Option<&DataSet>,
    test: Option<&DataSet>,
    config: &FitConfig,
) -> Result<Fit, FitError> {
    let fitting = Fitting::new(train, validation, config)?;
    let runs = (0..config.repeats).map(|repeat| fitting.run(repeat)).collect();
    fitting.finish(runs, test)?.learned()
}

/// Place of the [form](DataSet::target_forms) of the target whose best run of its fit has the highest evidence; 0 for rules without one.
#[must_use]
pub fn by_evidence(forms: &[(DataSet, Fit)]) -> usize {
    let evidence = |(rows, fit): &(DataSet, Fit)| {
        let found = fit.runs.get(fit.chosen).and_then(|run| run.evidence);
        found.map_or(f64::NEG_INFINITY, |found| found.ln_evidence + rows.ln_jacobian())
    };
    let best = forms.iter().map(evidence).enumerate();
    best.reduce(|best, next| if next.1 > best.1 { next } else { best })
        .map_or(0, |(place, _)| place)
}

/// Place of the run to keep, among those with a finite error.
#[must_use]
pub fn choose(runs: &[Run], choice: Choice) -> Option<usize> {
    // What the best run has least of: its error, or where a rule estimates it the evidence against it.
    let score = |run: &Run| match (choice, run.evidence) {
        (Choice::Best, Some(evidence)) => -evidence.ln_evidence,
        _ => run.mse,
    };
    let finite: Vec<(usize, f64)> =
        runs.iter().map(score).enumerate().filter(|(_, score)| score.is_finite()).collect();
    let mean = finite.iter().map(|(_, score)| score).sum::<f64>() / count(finite.len());
    let distance = |score: f64| match choice {
        Choice::Best => score,
        Choice::NearestAverage => (score - mean).abs(),
    };
    finite
        .into_iter()
        .min_by(|(_, left), (_, right)| distance(*left).total_cmp(&distance(*right)))
        .map(|(place, _)| place)
}

fn check_columns(train: &DataSet, other: &DataSet) -> Result<(), FitError> {
    let columns =
        |data: &DataSet| (data.inputs.clone(), data.targets.clone(), data.classes.clone());
    if columns(train) == columns(other) {
        return Ok(());
    }
    Err(FitError::OtherColumns { file: other.file.clone() })
}
