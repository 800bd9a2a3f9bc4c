//! Conditions of the study and a seed in, the chapter of its report on what lies beyond the four nets out.

use core::time::Duration;

use mlp::train::split::Split;

use ndarray::ArrayRef1;

use super::compare::uncertainty;
use super::learners::{LearnersConfig, learners};
use super::score::{OutlookError, Predict};
use crate::{Cell, Condition, Section, Table, comparison};

/// Names of the conditions that the chapter compares learners under: the one nearest the study, and the shipped features
/// with and without noise.
pub const CONDITIONS: [&str; 3] = ["paper", "default", "default-noise-1"];

/// Share of the training rows that decides when training stops and which settings win.
pub const VALIDATION: f64 = 0.25;

/// Trains every learner under every one of `conditions` on the first draw under `seed` and puts the tables into a chapter.
/// `done` is given each learner that is ready, as `condition: name`.
///
/// # Errors
/// [`OutlookError`] of the first learner that fails, or of a condition without rows.
pub fn chapter(
    conditions: &[Condition],
    seed: u64,
    config: &LearnersConfig,
    done: &(dyn Fn(&str) + Sync),
) -> Result<Section, OutlookError> {
    let mut section = Section::new("outlook", "Beyond the four nets").with(
        "Other activation functions, ensembles of nets, support vector regression, and the net that a genetic algorithm \
         finds, on the rows of the study. Each learner trains on three quarters of the training rows; the rest decides \
         when it stops, which start is kept and which settings win. Test and unseen rows judge only.",
    );
    for condition in conditions {
        section = section.with(table(condition, seed, config, done)?);
    }
    Ok(section)
}

fn table(
    condition: &Condition,
    seed: u64,
    config: &LearnersConfig,
    done: &(dyn Fn(&str) + Sync),
) -> Result<Table, OutlookError> {
    let sets = condition.sets(seed, 0)?;
    let reported = |name: &str| done(&format!("{}: {name}", condition.name));
    let heads: Vec<&str> =
        comparison::COLUMNS.iter().copied().chain(["numbers", "chosen"]).collect();
    let caption = format!("{}: {}", condition.name, condition.title());
    let mut table = Table::new(format!("outlook-{}", condition.name), caption, &heads);
    let (train, validation) = Split::holdout(&sets.train, VALIDATION, seed)?.of(&sets.train)?;
    for learner in learners(&train, &validation, config, &|| Duration::ZERO, &reported)? {
        let scores = sets.score(|features| answer(learner.predict.as_ref(), features));
        let mut row = comparison::row(&learner.name, &scores);
        let mut chosen = learner.detail;
        if let Some(spread) = uncertainty(learner.predict.as_ref(), &sets.unseen)? {
            let within = 100.0 * spread.within_two;
            chosen += &format!("; spread {:.2} N, {within:.0} % within two of it", spread.spread);
        }
        row.extend([Cell::Count(learner.size), Cell::text(chosen)]);
        table.push(row);
    }
    Ok(table)
}

/// The force (N), or NaN, which counts as wrong everywhere.
fn answer(learner: &dyn Predict, features: &ArrayRef1<f64>) -> f64 {
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
    fn the_chapter_has_a_row_for_each_learner_and_the_shipped_features_win() {
        let run = RunConfig { epochs: 300, max_fail: 50, ..RunConfig::default() };
        let fit = FitConfig { run, repeats: 1, ..FitConfig::default() };
        let search = SearchConfig {
            generations: 1,
            population: 4,
            fit: fit.clone(),
            ..SearchConfig::default()
        };
        let config = LearnersConfig { fit, members: 2, search };
        let conditions = ["paper", "default"].map(|name| Condition::named(name).unwrap());
        let section = chapter(&conditions, 1, &config, &|_| {}).unwrap();
        let json = section.json();
        let tables = json["tables"].as_array().unwrap();
        let unseen = |table: usize, learner: &str| {
            let rows = tables[table]["rows"].as_array().unwrap();
            assert_eq!(rows.len(), count());
            let row = rows.iter().find(|row| row[0] == learner).unwrap();
            row[6].as_f64().unwrap()
        };
        for learner in ["net, tanh, lm", "net, tanh, scg", "support vector regression"] {
            let (paper, shipped) = (unseen(0, learner), unseen(1, learner));
            assert!(paper < 0.8 && shipped > 0.9, "{learner}: {paper} {shipped}");
        }
    }

    #[test]
    fn the_conditions_of_the_chapter_exist() {
        assert!(CONDITIONS.iter().all(|name| Condition::named(name).is_some()));
    }
}
