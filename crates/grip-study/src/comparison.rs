//! Scores of a learner in, one row of a table out, so that all learners are compared in the same columns.

use crate::{Cell, Scores, Tolerance};

/// Column heads of [`row`].
pub const COLUMNS: &[&str] = &[
    "learner",
    "MSE train (N²)",
    "MSE test (N²)",
    "MSE unseen (N²)",
    "± 10 % train",
    "± 10 % test",
    "± 10 % unseen",
    "± 5 % unseen",
    "± 20 % unseen",
    "1.0–1.4 × needed, unseen",
];

/// What `scores` states under the heads of [`COLUMNS`].
#[must_use]
pub fn row(learner: &str, scores: &Scores) -> Vec<Cell> {
    vec![
        Cell::text(learner),
        Cell::Number(scores.train.mse),
        Cell::Number(scores.test.mse),
        Cell::Number(scores.unseen.mse),
        Cell::Percent(scores.train.within_10pct()),
        Cell::Percent(scores.test.within_10pct()),
        Cell::Percent(scores.unseen.within_10pct()),
        Cell::Percent(scores.unseen.share(Tolerance::Relative5)),
        Cell::Percent(scores.unseen.share(Tolerance::Relative20)),
        Cell::Percent(scores.unseen.share(Tolerance::Holds)),
    ]
}
