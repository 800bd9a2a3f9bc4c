//! The four nets of the source study and three more, trained under many conditions, beside the best possible answer.
//!
//! ```text
//! Condition::sets -> repeats of each net -> one run -> Scores, Curve
//!                 -> Ceiling, Gaussian process      -> distances, tables, figures
//! ```
//! Every net is 2-10-1 (more inputs where a condition has them), trained on all rows at once for 1000 epochs from 20
//! starts; the run whose training error is nearest the average of all is the one reported, as in the source study.
//! Everything is done on several independent draws of rows: figures and Tables 1 and 2 show the first, the table of all
//! conditions the mean.

mod ceiling;
pub mod claims;
mod distances;
mod net;
mod pages;
mod training;

pub use ceiling::{Ceiling, ceiling};
pub use distances::{Distance, distances};
pub use net::{HEAVY_BALL, HIDDEN, NETS, Net};
pub use training::{Curve, Summary};

use crate::{Condition, Scores, StudyError, condition};
use crate::{chapter::answer, outlook::learners::gp_by_evidence};
use mlp::train::{Hyper, RunConfig};
use rayon::iter::{IntoParallelIterator as _, IntoParallelRefIterator as _, ParallelIterator as _};
use serde::Serialize;

/// Called after each training, from any thread.
pub type Progress<'a> = &'a (dyn Fn() + Sync);

/// How much work the study does.
#[derive(Clone, Debug, PartialEq)]
pub struct StudyConfig {
    /// Seed of rows and starting weights.
    pub seed: u64,
    /// Trainings of each net from different starts, at least 1. The source study has 20 and keeps the one near the average.
    pub repeats: usize,
    /// Independent draws of rows, at least 1.
    pub draws: usize,
    /// Most epochs of each training, at least 1. The source study stops at a number that it does not name.
    pub epochs: usize,
    /// Training error, in scaled units, at which a training stops. The source study has one and does not name it; 0 stops none.
    pub goal: f64,
    /// Neurons of the hidden layer, at least 1. The source study does not name them.
    pub hidden: usize,
    /// Settings of the trainers other than the usual ones.
    pub hyper: Hyper,
    /// Rows that the estimate of the best possible answer knows, at least 1000.
    pub known_rows: usize,
    /// The conditions, at least one.
    pub conditions: Vec<Condition>,
}

impl StudyConfig {
    /// The whole study.
    #[must_use]
    pub fn full(seed: u64) -> Self {
        Self {
            seed,
            repeats: 20,
            draws: 2,
            epochs: 1000,
            goal: 0.0,
            hidden: HIDDEN,
            hyper: Hyper::default(),
            known_rows: 50_000,
            conditions: condition::ALL.to_vec(),
        }
    }

    /// A look in seconds: seven conditions, three starts, one draw, 300 epochs.
    #[must_use]
    pub fn quick(seed: u64) -> Self {
        let names =
            ["fixed-0", "paper", "fixed-6", "varied-0", "varied-v", "default", "paper-more"];
        let conditions = names.iter().filter_map(|name| Condition::named(name)).collect();
        let full = Self::full(seed);
        Self { repeats: 3, draws: 1, epochs: 300, known_rows: 10_000, conditions, ..full }
    }

    /// Trainings it takes.
    #[must_use]
    pub fn trainings(&self) -> usize {
        let starts: usize = NETS.iter().map(|net| net.starts(self.repeats)).sum();
        self.conditions.len() * self.draws * starts
    }

    /// Whether every number is large enough, and the trainers can work with their settings.
    ///
    /// # Errors
    /// [`StudyError::Setting`] and [`StudyError::Trainer`] for the first that is not.
    pub fn check(&self) -> Result<(), StudyError> {
        RunConfig { goal: self.goal, ..RunConfig::default() }.check()?;
        NETS.iter().try_for_each(|net| net.algorithm(&self.hyper).check())?;
        let least = [
            ("repeats", self.repeats, 1),
            ("draws", self.draws, 1),
            ("epochs", self.epochs, 1),
            ("hidden", self.hidden, 1),
            ("known_rows", self.known_rows, 1000),
            ("conditions", self.conditions.len(), 1),
        ];
        match least.into_iter().find(|(_, value, least)| value < least) {
            Some((name, value, 1)) => Err(StudyError::Setting { name, value, range: "1 or more" }),
            Some((name, value, _)) => {
                Err(StudyError::Setting { name, value, range: "1000 or more" })
            }
            None => Ok(()),
        }
    }
}

/// One net under one condition.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct NetResult {
    /// Name of the net.
    pub net: &'static str,
    /// Its trainer.
    pub trainer: &'static str,
    /// How the training went, first draw.
    pub summary: Summary,
    /// Scores of the chosen run, one for each draw.
    pub scores: Vec<Scores>,
    /// Error against epochs, first draw.
    pub curve: Curve,
}

/// All nets under one condition.
#[derive(Clone, Debug, PartialEq)]
pub struct ConditionResult {
    /// The condition.
    pub condition: Condition,
    /// What the best possible learner reaches.
    pub ceiling: Ceiling,
    /// One result for each of [`NETS`].
    pub nets: Vec<NetResult>,
    /// Scores of a Gaussian process, one for each draw.
    pub gp: Vec<Scores>,
}

/// The whole study.
#[derive(Clone, Debug, PartialEq)]
pub struct Study {
    /// What was asked for.
    pub config: StudyConfig,
    /// What came out, condition by condition.
    pub results: Vec<ConditionResult>,
}

impl NetResult {
    /// Mean over the draws of a figure of the scores.
    pub fn mean(&self, figure: impl Fn(&Scores) -> f64) -> f64 {
        self.scores.iter().map(figure).sum::<f64>() / self.scores.len() as f64
    }

    /// Standard deviation over the draws of a figure of the scores.
    pub fn deviation(&self, figure: impl Fn(&Scores) -> f64) -> f64 {
        let mean = self.mean(&figure);
        self.mean(|scores| (figure(scores) - mean).powi(2)).sqrt()
    }
}

impl ConditionResult {
    /// Mean over the draws of the share of unseen answers within 10 % of each net, then of the Gaussian process, with their names.
    #[must_use]
    pub fn unseen(&self) -> Vec<(String, f64)> {
        let within = |scores: &Scores| scores.unseen.within_10pct();
        let nets =
            NETS.iter().zip(&self.nets).map(|(net, found)| (net.title(), found.mean(within)));
        let gp = self.gp.iter().map(within).sum::<f64>() / self.gp.len() as f64;
        nets.chain([("GP".to_owned(), gp)]).collect()
    }
}

impl Study {
    /// The result of the condition of that name.
    #[must_use]
    pub fn result(&self, name: &str) -> Option<&ConditionResult> {
        self.results.iter().find(|result| result.condition.name == name)
    }
}

/// Trains everything that `config` asks for, on all threads of the pool it is called from. The same configuration gives
/// the same study on any number of threads.
///
/// # Errors
/// [`StudyError`] for a configuration out of its ranges and where all trainings of a net diverge.
pub fn run(config: &StudyConfig, progress: Progress<'_>) -> Result<Study, StudyError> {
    config.check()?;
    let results = config
        .conditions
        .par_iter()
        .map(|condition| run_condition(condition, config, progress))
        .collect::<Result<Vec<_>, _>>()?;
    Ok(Study { config: config.clone(), results })
}

fn run_condition(
    condition: &Condition,
    config: &StudyConfig,
    progress: Progress<'_>,
) -> Result<ConditionResult, StudyError> {
    let sets = (0..config.draws as u64)
        .into_par_iter()
        .map(|draw| condition.sets(config.seed, draw))
        .collect::<Result<Vec<_>, _>>()?;
    let (ceiling, (nets, gp)) = rayon::join(
        || ceiling(condition, config.seed, config.known_rows),
        || {
            let one = |net| run_net(condition, net, &sets, config, progress);
            let gp = |sets: &crate::Sets| {
                let fault = |source| StudyError::Learner { condition: condition.name, source };
                let gp = gp_by_evidence(&sets.train).map_err(Box::new).map_err(fault)?;
                Ok(sets.score(|features| answer(&gp, features)))
            };
            rayon::join(
                || NETS.par_iter().map(one).collect::<Result<Vec<_>, _>>(),
                || sets.par_iter().map(gp).collect::<Result<Vec<_>, StudyError>>(),
            )
        },
    );
    Ok(ConditionResult { condition: *condition, ceiling: ceiling?, nets: nets?, gp: gp? })
}

fn run_net(
    condition: &Condition,
    net: &Net,
    sets: &[crate::Sets],
    config: &StudyConfig,
    progress: Progress<'_>,
) -> Result<NetResult, StudyError> {
    let trained = sets
        .par_iter()
        .map(|sets| training::train(condition, net, sets, config, progress))
        .collect::<Result<Vec<_>, _>>()?;
    let fault = |source| StudyError::Fit { condition: condition.name, learner: net.name, source };
    let curve = training::curve(net, &sets[0], &trained[0], config).map_err(fault)?;
    Ok(NetResult {
        net: net.name,
        trainer: net.trainer,
        summary: trained[0].summary.clone(),
        scores: trained.iter().map(|trained| trained.scores).collect(),
        curve,
    })
}

#[cfg(test)]
mod tests;
