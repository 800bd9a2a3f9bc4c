//! Comparison of every learner side by side, on one set of training, validation and test rows.

use core::time::Duration;

use mlp::train::{DataSet, Scaling};
use serde::Serialize;

use super::learners::{Learner, LearnersConfig, learners};
use super::score::{OutlookError, Predict, Score, score};

/// Rows with the same columns. Every learner trains on `train`, decides on `validation`, and is judged on `test`, which it
/// never sees.
#[derive(Debug, Clone, Copy)]
pub struct Sets<'a> {
    /// Rows to train on.
    pub train: &'a DataSet,
    /// Rows that decide when training stops, which start is kept and which settings win.
    pub validation: &'a DataSet,
    /// Rows for the judgement.
    pub test: &'a DataSet,
}

/// How far the spread of an ensemble shows its error.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Uncertainty {
    /// Root mean square of the standard deviation of the members, in the raw unit of the target.
    pub spread: f64,
    /// Share of test values within two standard deviations of the mean; 0.95 if the spread were all the error there is.
    pub within_two: f64,
}

/// One learner.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Comparison {
    /// Its name.
    pub name: String,
    /// What was chosen: shape, settings.
    pub detail: String,
    /// Numbers it consists of: weights, or values of all support vectors.
    pub size: usize,
    /// On the training rows.
    pub train: Score,
    /// On the test rows.
    pub test: Score,
    /// Where it has a spread.
    pub uncertainty: Option<Uncertainty>,
    /// Time of training (s) by the caller's clock.
    pub seconds: f64,
}

/// How far the spread of `learner` shows its error on `test`; none where it has no spread.
///
/// # Errors
/// [`OutlookError::Predict`] for the first row without a prediction.
pub fn uncertainty(
    learner: &dyn Predict,
    test: &DataSet,
) -> Result<Option<Uncertainty>, OutlookError> {
    let (mut squares, mut within, mut values) = (0.0, 0.0, 0.0);
    for (at, (inputs, wanted)) in test.iter().enumerate() {
        let answers = learner.spread(&inputs).map_err(|source| OutlookError::Predict {
            file: test.file.clone(),
            row: at + 1,
            source,
        })?;
        for (answer, wanted) in answers.iter().zip(wanted) {
            squares += answer.deviation.powi(2);
            within += f64::from((answer.mean - wanted).abs() <= 2.0 * answer.deviation);
            values += 1.0;
        }
    }
    let found = Uncertainty { spread: (squares / values).sqrt(), within_two: within / values };
    Ok((values > 0.0).then_some(found))
}

/// Trains every learner on the same rows and scores it on the same rows; `elapsed` and `done` as in [`learners`].
///
/// # Errors
/// The first [`OutlookError`] of any learner.
pub fn compare(
    sets: Sets<'_>,
    config: &LearnersConfig,
    elapsed: &(dyn Fn() -> Duration + Sync),
    done: &(dyn Fn(&str) + Sync),
) -> Result<Vec<Comparison>, OutlookError> {
    let limits: Vec<Scaling> = sets.train.target_scalings();
    learners(sets.train, sets.validation, config, elapsed, done)?
        .into_iter()
        .map(|learner| {
            let Learner { name, detail, size, seconds, predict } = learner;
            let train = score(predict.as_ref(), sets.train, &limits)?;
            let test = score(predict.as_ref(), sets.test, &limits)?;
            let uncertainty = uncertainty(predict.as_ref(), sets.test)?;
            Ok(Comparison { name, detail, size, train, test, uncertainty, seconds })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::outlook::{SearchConfig, learners::count, testing};
    use core::sync::atomic::{AtomicUsize, Ordering};
    use mlp::train::{FitConfig, RunConfig};
    use std::collections::BTreeSet;

    #[test]
    fn every_learner_is_trained_and_none_beats_the_noise() {
        let [train, validation, test] =
            [(150, 1), (60, 2), (120, 3)].map(|(rows, seed)| testing::surface(rows, seed));
        let sets = Sets { train: &train, validation: &validation, test: &test };
        let run = RunConfig { epochs: 150, ..RunConfig::default() };
        let fit = FitConfig { run, repeats: 2, ..FitConfig::default() };
        let (own, few) = (fit.clone(), SearchConfig::default());
        let search = SearchConfig { generations: 2, population: 6, fit: own, ..few };
        let config = LearnersConfig { fit, members: 4, search };
        let ready = AtomicUsize::new(0);
        let counted = |_: &str| {
            ready.fetch_add(1, Ordering::Relaxed);
        };
        let rows = compare(sets, &config, &|| Duration::ZERO, &counted).unwrap();
        assert_eq!((rows.len(), ready.into_inner()), (count(), count()));
        let names: BTreeSet<&str> = rows.iter().map(|row| row.name.as_str()).collect();
        assert_eq!(names.len(), rows.len());
        for row in &rows {
            // The noise is 0.0025; 150 epochs of plain descent and polynomials are far from it, the others are near.
            let slow =
                ["gd", "gdm", "gdx", "line", "cubic"].iter().any(|rule| row.name.ends_with(rule));
            assert!(row.test.mse > 0.002 && (slow || row.test.mse < 0.02), "{row:?}");
            assert!(row.size > 0 && row.test.rows == 120, "{row:?}");
            let spread = row.name.starts_with("ensemble") || row.name == "Gaussian process";
            assert_eq!(row.uncertainty.is_some(), spread);
        }
    }
}
