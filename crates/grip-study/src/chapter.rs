//! Every learner under conditions of the study: what lies beyond its four nets.

use core::time::Duration;

use mlp::train::split::Split;
use ndarray::ArrayRef1;

use crate::outlook::{Comparison, LearnersConfig, OutlookError, Predict, Sets, compare};
use crate::{Cell, Condition, StudyError, Table};

/// Names of the conditions that learners are compared under: the one nearest the study, and the shipped features with and
/// without noise.
pub const CONDITIONS: [&str; 3] = ["paper", "default", "default-noise-1"];

/// Share of the training rows that decides when training stops and which settings win.
pub const VALIDATION: f64 = 0.25;

/// All learners under one condition, judged by its unseen rows.
#[derive(Clone, Debug, PartialEq)]
pub struct Beyond {
    /// The condition.
    pub condition: Condition,
    /// In the order of [`learners`](crate::outlook::learners()).
    pub learners: Vec<Comparison>,
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
    let sets = Sets { train: &train, validation: &validation, test: &sets.unseen };
    Ok(Beyond { condition, learners: compare(sets, config, &|| Duration::ZERO, done)? })
}

impl Beyond {
    /// The learner of that name.
    #[must_use]
    pub fn learner(&self, name: &str) -> Option<&Comparison> {
        self.learners.iter().find(|learner| learner.name == name)
    }

    /// All learners in a table.
    #[must_use]
    pub fn table(&self) -> Table {
        let heads =
            ["learner", "± 10 % train", "± 10 % unseen", "MSE unseen (N²)", "numbers", "chosen"];
        let Condition { name, .. } = self.condition;
        let caption = format!("{name}: {}", self.condition.title());
        let mut table = Table::new(format!("outlook-{name}"), caption, &heads);
        for Comparison { name, train, test, size, detail, uncertainty, .. } in &self.learners {
            let spread = uncertainty.map_or_else(String::new, |found| {
                let within = 100.0 * found.within_two;
                format!("; spread {:.2} N, {within:.0} % within two of it", found.spread)
            });
            table.push(vec![
                Cell::text(name),
                Cell::Percent(train.within_10pct),
                Cell::Percent(test.within_10pct),
                Cell::Number(test.mse),
                Cell::Count(*size),
                Cell::text(format!("{detail}{spread}")),
            ]);
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
    use crate::outlook::{
        Gp, SearchConfig,
        learners::{count, gp_by_evidence},
    };
    use mlp::Transform;
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
            let of = |of: &Beyond| of.learner(name).unwrap().test.within_10pct;
            assert!(
                of(&paper) < 0.8 && of(&shipped) > 0.9,
                "{name}: {} {}",
                of(&paper),
                of(&shipped)
            );
        }
    }

    #[test]
    fn evidence_finds_the_form_that_is_as_noisy_everywhere() {
        let sets = Condition::named("paper").unwrap().sets(3, 0).unwrap();
        let share = |gp: &Gp| sets.score(|features| answer(gp, features)).unseen.within_10pct();
        let (found, plain) = (gp_by_evidence(&sets.train).unwrap(), Gp::fit(&sets.train).unwrap());
        let target = &found.columns.targets[0];
        assert_eq!((target.transform, target.noise > 0.0), (Transform::Reciprocal, true));
        assert!(share(&found) > share(&plain) + 0.03, "{} {}", share(&found), share(&plain));
    }

    #[test]
    fn the_conditions_exist() {
        assert!(CONDITIONS.iter().all(|name| Condition::named(name).is_some()));
    }
}
