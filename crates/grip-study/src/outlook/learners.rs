//! Every kind of learner, trained on the same rows.

use core::fmt;
use core::time::Duration;

use mlp::Activation;
use mlp::train::{Algorithm, DataSet, FitConfig, Fitting, RunConfig, fit, fit::by_evidence};
use rayon::iter::{IntoParallelIterator as _, ParallelIterator as _};

use super::ensemble::{Ensemble, EnsembleConfig, Sampling};
use super::score::{OutlookError, Predict};
use super::search::{SearchConfig, search};
use super::svr::{Svr, SvrConfig};
use super::{Gp, Poly};

/// Settings of all learners.
#[derive(Debug, Clone, PartialEq)]
pub struct LearnersConfig {
    /// The plain nets: shape, stop rules, starts and precision.
    pub fit: FitConfig,
    /// Members of each ensemble.
    pub members: usize,
    /// The search.
    pub search: SearchConfig,
}

impl Default for LearnersConfig {
    fn default() -> Self {
        let run = RunConfig { epochs: 1000, max_fail: 100, ..RunConfig::default() };
        let fit = FitConfig { run, repeats: 5, ..FitConfig::default() };
        Self { fit, members: 10, search: SearchConfig::default() }
    }
}

impl LearnersConfig {
    /// A look in seconds: two starts, four members, a search of a few genomes.
    #[must_use]
    pub fn quick() -> Self {
        let run = RunConfig { epochs: 200, max_fail: 40, ..RunConfig::default() };
        let fit = FitConfig { run, repeats: 2, ..FitConfig::default() };
        let own = FitConfig { run: RunConfig { epochs: 100, ..run }, ..fit.clone() };
        let search =
            SearchConfig { generations: 3, population: 8, fit: own, ..SearchConfig::default() };
        Self { fit, members: 4, search }
    }
}

/// A trained learner.
pub struct Learner {
    /// Its name.
    pub name: String,
    /// What was chosen: shape, settings.
    pub detail: String,
    /// Numbers it consists of: weights, or values of all support vectors.
    pub size: usize,
    /// Time of training (s) by the caller's clock.
    pub seconds: f64,
    /// What answers.
    pub predict: Box<dyn Predict + Send + Sync>,
}

impl fmt::Debug for Learner {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (name, detail) = (&self.name, &self.detail);
        f.debug_struct("Learner")
            .field("name", name)
            .field("detail", detail)
            .finish_non_exhaustive()
    }
}

/// One way to learn.
#[derive(Debug, Clone, Copy)]
enum Method {
    Net(Activation, Algorithm),
    Ensemble(Sampling),
    Poly(usize),
    Gp,
    Svr,
    Search,
}

/// What answers, what was chosen, and how large it is.
type Trained = (Box<dyn Predict + Send + Sync>, String, usize);

impl Method {
    fn all() -> Vec<Self> {
        let mut all: Vec<Self> =
            Algorithm::all().map(|rule| Self::Net(Activation::Tanh, rule)).to_vec();
        for activation in [Activation::Logistic, Activation::Relu] {
            let rules = Algorithm::all().into_iter();
            let some = rules.filter(|rule| matches!(rule.name(), "rprop" | "scg" | "lm"));
            all.extend(some.map(|rule| Self::Net(activation, rule)));
        }
        all.extend([
            Self::Ensemble(Sampling::Starts),
            Self::Ensemble(Sampling::Bagging),
            Self::Poly(1),
            Self::Poly(3),
            Self::Gp,
            Self::Svr,
            Self::Search,
        ]);
        all
    }

    fn name(self) -> String {
        match self {
            Self::Net(activation, rule) => format!("net, {activation}, {}", rule.name()),
            Self::Ensemble(Sampling::Starts) => "ensemble, other starts".to_owned(),
            Self::Ensemble(Sampling::Bagging) => "ensemble, bagging".to_owned(),
            Self::Poly(1) => "line".to_owned(),
            Self::Poly(_) => "cubic".to_owned(),
            Self::Gp => "Gaussian process".to_owned(),
            Self::Svr => "support vector regression".to_owned(),
            Self::Search => "net found by search".to_owned(),
        }
    }

    fn train(
        self,
        train: &DataSet,
        validation: &DataSet,
        config: &LearnersConfig,
    ) -> Result<Trained, OutlookError> {
        match self {
            Self::Net(_, Algorithm::Br) => bayesian(train, config),
            Self::Poly(degree) => {
                let poly = Poly::fit(train, degree)?;
                let size = poly.size();
                Ok((Box::new(poly), String::new(), size))
            }
            Self::Gp => {
                let gp = gp_by_evidence(train)?;
                let (detail, size) = (gp.detail(), gp.size());
                Ok((Box::new(gp), detail, size))
            }
            Self::Net(activation, algorithm) => {
                net(train, validation, &FitConfig { activation, algorithm, ..config.fit.clone() })
            }
            Self::Ensemble(sampling) => ensemble(train, validation, config, sampling),
            Self::Svr => svr(train, validation),
            Self::Search => searched(train, validation, config),
        }
    }
}

/// A Gaussian process of the [form](DataSet::target_forms) of the target with the higher evidence.
///
/// # Errors
/// As [`Gp::fit`].
pub fn gp_by_evidence(train: &DataSet) -> Result<Gp, OutlookError> {
    // The form as asked for is the first.
    let mut best: Option<(f64, Gp)> = None;
    for form in train.target_forms() {
        let gp = Gp::fit(&form)?;
        let evidence = gp.ln_evidence() + form.ln_jacobian();
        if best.as_ref().is_none_or(|(most, _)| evidence > *most) {
            best = Some((evidence, gp));
        }
    }
    best.map(|(_, gp)| gp).ok_or(OutlookError::Singular)
}

/// Evidence decides on start and form of the target, and no rows are needed to stop by.
fn bayesian(train: &DataSet, config: &LearnersConfig) -> Result<Trained, OutlookError> {
    let config = FitConfig { algorithm: Algorithm::Br, ..config.fit.clone() };
    let fits = train.target_forms().into_iter().map(|form| {
        let fit = fit(&form, None, None, &config)?;
        Ok((form, fit))
    });
    let mut fits = fits.collect::<Result<Vec<_>, OutlookError>>()?;
    let (form, fit) = fits.swap_remove(by_evidence(&fits));
    let run = &fit.runs[fit.chosen];
    let used = run.evidence.map_or(0.0, |found| found.effective);
    let detail = format!("target {}, {used:.0} parameters in use", form.targets[0].transform);
    let size = run.weights.len();
    Ok((fit.model, detail, size))
}

/// Of several starts the one with the least validation error.
fn net(train: &DataSet, validation: &DataSet, config: &FitConfig) -> Result<Trained, OutlookError> {
    let fitting = Fitting::new(train, Some(validation), config)?;
    let error = |repeat: usize| {
        let run = fitting.run(repeat);
        run.validation.get(run.best_epoch).copied().unwrap_or(f64::INFINITY)
    };
    let errors: Vec<f64> = (0..config.repeats).map(error).collect();
    let best = errors.iter().enumerate().min_by(|a, b| a.1.total_cmp(b.1)).map_or(0, |(at, _)| at);
    let seed = config.seed.wrapping_add(best as u64);
    let one = FitConfig { seed, repeats: 1, ..config.clone() };
    let fit = fit(train, Some(validation), None, &one)?;
    let widths: Vec<String> = config.hidden.iter().map(ToString::to_string).collect();
    let epochs = fit.runs.first().map_or(0, |run| run.best_epoch);
    let detail = format!("{} hidden, epoch {epochs}", widths.join("-"));
    Ok((fit.model, detail, fitting.weights()))
}

fn ensemble(
    train: &DataSet,
    validation: &DataSet,
    config: &LearnersConfig,
    sampling: Sampling,
) -> Result<Trained, OutlookError> {
    let fit = FitConfig { repeats: 1, ..config.fit.clone() };
    let own = EnsembleConfig { members: config.members, sampling, fit };
    let ensemble = Ensemble::fit(train, Some(validation), &own)?;
    let detail = format!("{} nets, {}", config.members, config.fit.algorithm.name());
    let size = ensemble.weights();
    Ok((Box::new(ensemble), detail, size))
}

fn svr(train: &DataSet, validation: &DataSet) -> Result<Trained, OutlookError> {
    let svr = Svr::choose(train, validation, &SvrConfig::grid())?;
    let SvrConfig { c, gamma, .. } = svr.config;
    let vectors = svr.support_vectors();
    let size = vectors * (svr.columns.inputs.len() + 1);
    Ok((Box::new(svr), format!("{vectors} support vectors, c {c}, gamma {gamma}"), size))
}

fn searched(
    train: &DataSet,
    validation: &DataSet,
    config: &LearnersConfig,
) -> Result<Trained, OutlookError> {
    let found = search(train, validation, &config.search, &|_| {})?;
    let fit = found.train_best(train, validation, None, &config.search)?;
    let best = found.best()?;
    let detail = format!("{}; {} genomes tried", best.genome, found.candidates.len());
    Ok((fit.model, detail, best.weights))
}

/// Trains every learner on the same rows; `validation` decides when training stops, which start is kept and which
/// settings win. `elapsed` is any clock; `done` is given each name when its learner is ready. They train in parallel, so times
/// are those of a busy machine.
///
/// # Errors
/// The first [`OutlookError`] of any learner.
pub fn learners(
    train: &DataSet,
    validation: &DataSet,
    config: &LearnersConfig,
    elapsed: &(dyn Fn() -> Duration + Sync),
    done: &(dyn Fn(&str) + Sync),
) -> Result<Vec<Learner>, OutlookError> {
    Method::all()
        .into_par_iter()
        .map(|method| {
            let start = elapsed();
            let (predict, detail, size) = method.train(train, validation, config)?;
            let seconds = elapsed().saturating_sub(start).as_secs_f64();
            let name = method.name();
            done(&name);
            Ok(Learner { name, detail, size, seconds, predict })
        })
        .collect()
}

/// Number of learners there are.
#[must_use]
pub fn count() -> usize {
    Method::all().len()
}
