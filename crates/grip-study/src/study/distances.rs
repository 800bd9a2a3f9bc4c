//! Distance of each condition and definition of correct in a study from the published numbers.

use super::{ConditionResult, NETS, Study};
use crate::Tolerance;
use serde::Serialize;

/// How far a condition is from the published figures when answers count by one definition.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Distance {
    /// Name of the condition.
    pub condition: &'static str,
    /// The same in words.
    pub title: String,
    /// Key of the definition of a correct answer.
    pub tolerance: &'static str,
    /// The same in words.
    pub tolerance_title: &'static str,
    /// Mean absolute difference over the eight published figures (training and test rows of M1 to M4), percentage points.
    pub points: f64,
    /// Mean signed difference, this run minus the study.
    pub offset: f64,
}

/// Every condition and definition, the nearest first.
#[must_use]
pub fn distances(study: &Study) -> Vec<Distance> {
    let pairs = study.results.iter().flat_map(|result| Tolerance::ALL.map(|t| (result, t)));
    let mut all: Vec<Distance> =
        pairs.map(|(result, tolerance)| distance(result, tolerance)).collect();
    all.sort_by(|a, b| a.points.total_cmp(&b.points));
    all
}

fn distance(result: &ConditionResult, tolerance: Tolerance) -> Distance {
    let differences: Vec<f64> = NETS
        .iter()
        .zip(&result.nets)
        .filter_map(|(net, found)| Some((net.published?, found)))
        .flat_map(|([train, test], found)| {
            [
                found.mean(|scores| scores.train.share(tolerance)) - train,
                found.mean(|scores| scores.unseen.share(tolerance)) - test,
            ]
        })
        .collect();
    let mean = |of: fn(f64) -> f64| {
        100.0 * differences.iter().copied().map(of).sum::<f64>() / differences.len() as f64
    };
    Distance {
        condition: result.condition.name,
        title: result.condition.title(),
        tolerance: tolerance.key(),
        tolerance_title: tolerance.title(),
        points: mean(f64::abs),
        offset: mean(|difference| difference),
    }
}
