//! Every learner under conditions of the study: what lies beyond its four nets.

use core::time::Duration;

use mlp::train::split::Split;
use ndarray::ArrayRef1;

use crate::outlook::compare::uncertainty;
use crate::outlook::learners::{LearnersConfig, learners};
use crate::outlook::score::{OutlookError, Predict};
use crate::{Cell, Condition, Scores, StudyError, Table, comparison};

/// Names of the conditions that learners are compared under: the one nearest the study, and the shipped features with and
/// without noise.
pub const CONDITIONS: [&str; 3] = ["paper", "default", "default-noise-1"];

/// Share of the training rows that decides when training stops and which settings win.
pub const VALIDATION: f64 = 0.25;

/// One learner under one condition.
#[derive(Clone, Debug, PartialEq)]
pub struct Learned {
    /// Its name.
    pub name: String,
    /// What it reached.
    pub scores: Scores,
    /// Numbers it consists of.
    pub size: usize,
    /// What was chosen, and its spread where it has one.
    pub chosen: String,
}

/// All learners under one condition.
#[derive(Clone, Debug, PartialEq)]
pub struct Beyond {
    /// The condition.
    pub condition: Condition,
    /// In the order of [`learners`].
    pub learners: Vec<Learned>,
}

/// Trains every learner under `condition` on the first draw under `seed`. `done` is given the name of each that is ready.
///
/// # Errors
/// [`StudyError`] of the first learner that fails, or of a condition without rows.
pub fn beyond(
    condition: Condition,
    seed: u64,
    config: &LearnersConfig,
    done: &(dyn Fn(&str) + Sync),
) -> Result<Beyond, StudyError> {
    let sets = condition.sets(seed, 0)?;
    let split = Split::holdout(&sets.train, VALIDATION, seed).map_err(OutlookError::from)?;
    let (train, validation) = split.of(&sets.train)?;
    let learners = learners(&train, &validation, config, &|| Duration::ZERO, done)?;
    let learned = learners.into_iter().map(|learner| {
        let scores = sets.score(|features| answer(learner.predict.as_ref(), features));
        let mut chosen = learner.detail;
        if let Some(spread) = uncertainty(learner.predict.as_ref(), &sets.unseen)? {
            let within = 100.0 * spread.within_two;
            chosen += &format!("; spread {:.2} N, {within:.0} % within two of it", spread.spread);
        }
        Ok(Learned { name: learner.name, scores, size: learner.size, chosen })
    });
    Ok(Beyond { condition, learners: learned.collect::<Result<_, OutlookError>>()? })
}

impl Beyond {
    /// The learner of that name.
    #[must_use]
    pub fn learner(&self, name: &str) -> Option<&Learned> {
        self.learners.iter().find(|learner| learner.name == name)
    }

    /// All learners in a table.
    #[must_use]
    pub fn table(&self) -> Table {
        let heads: Vec<&str> =
            comparison::COLUMNS.iter().copied().chain(["numbers", "chosen"]).collect();
        let Condition { name, .. } = self.condition;
        let caption = format!("{name}: {}", self.condition.title());
        let mut table = Table::new(format!("outlook-{name}"), caption, &heads);
        for learner in &self.learners {
            let mut row = comparison::row(&learner.name, &learner.scores);
            row.extend([Cell::Count(learner.size), Cell::text(&learner.chosen)]);
            table.push(row);
        }
        table
    }
}

/// The force (N), or NaN, which counts as wrong everywhere.
pub(crate) fn answer(learner: &dyn Predict, features: &ArrayRef1<f64>) -> f64 {
    let mut force = [f64::NAN];
    match learner.predict(features, &mut force) {
        Ok(()) => force[0],
        Err(_) => f64::NAN,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::outlook::{SearchConfig, learners::count};
    use mlp::train::{FitConfig, RunConfig};

    #[test]
    fn the_shipped_features_win_with_every_good_learner() {
        let run = RunConfig { epochs: 300, max_fail: 50, ..RunConfig::default() };
        let fit = FitConfig { run, repeats: 1, ..FitConfig::default() };
        let search = SearchConfig {
            generations: 1,
            population: 4,
            fit: fit.clone(),
            ..SearchConfig::default()
        };
        let config = LearnersConfig { fit, members: 2, search };
        let [paper, shipped] = ["paper", "default"].map(|name| {
            let beyond = beyond(Condition::named(name).unwrap(), 1, &config, &|_| {}).unwrap();
            assert_eq!((beyond.learners.len(), beyond.table().rows.len()), (count(), count()));
            beyond
        });
        for name in
            ["net, tanh, lm", "net, tanh, br", "Gaussian process", "support vector regression"]
        {
            let of = |of: &Beyond| of.learner(name).unwrap().scores.unseen.within_10pct();
            assert!(
                of(&paper) < 0.8 && of(&shipped) > 0.9,
                "{name}: {} {}",
                of(&paper),
                of(&shipped)
            );
        }
    }

    #[test]
    fn the_conditions_exist() {
        assert!(CONDITIONS.iter().all(|name| Condition::named(name).is_some()));
    }
}
