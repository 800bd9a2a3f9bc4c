//! Interval of the model of all rows, from rows and answers of models that had not seen them.
//!
//! Cross-conformal: each part of the rows is held out once, and a model of the other parts answers for it. The width is the quantile of what
//! those answers missed by, in the unit of the target or in its logarithm. It takes no bell curve for granted, and is a little too wide for
//! few rows, since the model of all rows has seen more than those of the parts.
//!
//! Rows with labels (an object, a world) stay together. The width then holds `level` of the rows of a new group, where each group counts the same
//! (Lee, Barber, Willett 2023), or `level` of the rows in the worst group there is, whichever is less: that of a few worlds.

use ndarray::{Array2, Axis};

pub use mlp_core::interval::Interval;

use super::column::ColumnSpec;
use super::data::DataSet;
use super::file::rounded;
use super::metrics::r_squared;
use super::objective::count;
use super::setting::{self, SettingError};
use super::split::{Split, SplitError, groups};
use crate::model::Transform;

/// Parts that are held out, one after the other.
pub const PARTS: usize = 10;
/// Fewest groups of which the worst says something of a new one.
const FEWEST: usize = 3;

/// Why there is no interval.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum IntervalError {
    /// A level outside 0 to 1.
    #[error(transparent)]
    Level(#[from] SettingError),
    /// Of so few rows even the farthest is no limit.
    #[error("{rows} rows: an interval of {} % needs at least {needed}", 100.0 * level)]
    TooFewRows {
        /// Rows there are.
        rows: usize,
        /// Least number of rows.
        needed: usize,
        /// The level.
        level: f64,
    },
    /// Few groups that do not show either how far a new group may be off or how far the rows of one are.
    #[error(
        "{groups} groups, {small} of fewer than {needed} rows: an interval of {} % needs {needed} groups, or at least {FEWEST} of {needed} rows each",
        100.0 * level
    )]
    TooFewGroups {
        /// Groups there are.
        groups: usize,
        /// Those with fewer rows than `needed`.
        small: usize,
        /// Least number of groups, or of rows in each.
        needed: usize,
        /// The level.
        level: f64,
    },
    /// Classes have probabilities.
    #[error("classes have probabilities and no interval")]
    Classes,
    /// Answers of held-out rows that are not finite, or not as many as rows.
    #[error(
        "target {target} has no finite answer for so many held-out rows that nothing limits it"
    )]
    NoLimit {
        /// Its place.
        target: usize,
    },
    /// Rows that can not be split.
    #[error(transparent)]
    Split(#[from] SplitError),
}

/// The parts of the rows, each held out once.
#[derive(Debug, Clone)]
pub struct HeldOut<'a> {
    data: &'a DataSet,
    level: f64,
    groups: Vec<Vec<usize>>,
    splits: Vec<Split>,
}

/// What the answers for held-out rows show.
#[derive(Debug, Clone, PartialEq)]
pub struct Shown {
    /// The interval of the model of all rows.
    pub interval: Interval,
    /// As [`Evaluation::r2`](super::Evaluation::r2), of the held-out rows.
    pub r2: Option<f64>,
}

impl<'a> HeldOut<'a> {
    /// Deals the rows, or the groups of equal label, out to [`PARTS`] parts; fewer groups make a part each.
    ///
    /// # Errors
    /// Any [`IntervalError`] but [`IntervalError::NoLimit`].
    pub fn new(data: &'a DataSet, level: f64, seed: u64) -> Result<Self, IntervalError> {
        setting::share("level", level)?;
        if data.classes.is_some() {
            return Err(IntervalError::Classes);
        }
        let groups = groups(data.rows(), data.labels());
        let (rows, needed) = (data.rows(), rank(level / (1.0 - level)));
        if data.labels().is_empty() && rows < needed {
            return Err(IntervalError::TooFewRows { rows, needed, level });
        }
        let small = groups.iter().filter(|group| group.len() < needed).count();
        if groups.len() < needed && (groups.len() < FEWEST || small > 0) {
            return Err(IntervalError::TooFewGroups { groups: groups.len(), small, needed, level });
        }
        let splits = Split::folds(data, groups.len().min(PARTS), seed)?;
        Ok(Self { data, level, groups, splits })
    }

    /// The parts: a model of the training rows of each answers for those held out.
    #[must_use]
    pub fn splits(&self) -> &[Split] {
        &self.splits
    }

    /// What `answers` (held-out rows x targets, raw, in the order of the parts and of their rows) show.
    ///
    /// # Errors
    /// [`IntervalError::NoLimit`].
    pub fn shown(&self, answers: &[Array2<f64>]) -> Result<Shown, IntervalError> {
        let truths = self.data.target_values();
        let mut all = Array2::from_elem(truths.dim(), f64::NAN);
        for (split, answers) in self.splits.iter().zip(answers) {
            for (&row, answers) in split.held_out.iter().zip(answers.rows()) {
                all.row_mut(row).assign(&answers);
            }
        }
        let of = |(target, spec): (usize, &ColumnSpec)| {
            let missed =
                |&row: &usize| missed(spec.transform, truths[[row, target]], all[[row, target]]);
            let groups = self.groups.iter().map(|group| group.iter().map(missed).collect());
            let width = width(groups.collect(), self.level);
            let width = rounded(if spec.transform.is_relative() { width.exp() } else { width });
            if width.is_finite() { Ok(width) } else { Err(IntervalError::NoLimit { target }) }
        };
        let widths = self.data.targets.iter().enumerate().map(of).collect::<Result<_, _>>()?;
        let (parts, rows) = (self.splits.len(), self.data.rows());
        let groups = match self.groups.len() {
            groups if groups == rows => String::new(),
            groups => format!("{groups} groups, "),
        };
        let from = format!("{parts} parts of {groups}{rows} rows, each held out once");
        let mse = (&all - &truths).mapv(|error| error * error).sum_axis(Axis(0)) / count(rows);
        let interval = Interval { level: self.level, widths, from };
        Ok(Shown { interval, r2: r_squared(&mse, self.data) })
    }
}

/// How far an answer misses the truth, in the unit of the target or in its logarithm; infinite without an answer.
fn missed(transform: Transform, truth: f64, answer: f64) -> f64 {
    let off = if transform.is_relative() { (truth / answer).ln() } else { truth - answer };
    if off.is_nan() { f64::INFINITY } else { off.abs() }
}

/// The distance within which `level` of the values of one more group lie, each group counting the same, or of those in the worst group.
fn width(groups: Vec<Vec<f64>>, level: f64) -> f64 {
    let (mut all, mut worst) = (Vec::new(), 0.0_f64);
    let wanted = level * count(groups.len() + 1) - 1e-9;
    for mut group in groups {
        group.sort_unstable_by(f64::total_cmp);
        let (size, place) = (count(group.len()), rank(level * count(group.len())));
        worst = worst.max(group.get(place.saturating_sub(1)).copied().unwrap_or(0.0));
        all.extend(group.into_iter().map(|value| (value, 1.0 / size)));
    }
    all.sort_unstable_by(|left, right| left.0.total_cmp(&right.0));
    let mut sum = 0.0;
    let place = all.iter().find(|(_, share)| {
        sum += share;
        sum >= wanted
    });
    place.map_or(worst, |(value, _)| value.min(worst))
}

/// The next whole number, but for what rounding adds.
fn rank(x: f64) -> usize {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "saturates")]
    let whole = (x - 1e-9).ceil() as usize;
    whole
}

/// The share of the targets of `data` that lie in `interval` around their `answers` (rows x targets, raw).
#[must_use]
pub fn coverage(interval: &Interval, data: &DataSet, answers: &Array2<f64>) -> f64 {
    let truths = data.target_values();
    let mut held = 0;
    for (truths, answers) in truths.rows().into_iter().zip(answers.rows()) {
        let values = truths.iter().zip(answers).zip(&data.targets).zip(&interval.widths);
        for (((truth, &answer), spec), &width) in values {
            let [low, high] = Interval::around(spec.transform, width, answer);
            held += usize::from((low..=high).contains(truth));
        }
    }
    count(held) / count(truths.len())
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::Array2;

    /// Rows y = 1, 2, .. 10 n with labels of `groups`, where there are some.
    fn rows(n: usize, target: &str, groups: usize) -> DataSet {
        let values = Array2::from_shape_fn((n, 1), |(row, _)| (row + 1) as f64);
        let specs = |text: &str| [text.parse().unwrap()];
        let data = DataSet::from_values("t", &specs("x"), &specs(target), values.clone(), values);
        let labels = (0..n).map(|row| (row % groups.max(1)).to_string()).collect();
        if groups == 0 { data.unwrap() } else { data.unwrap().with_labels(labels).unwrap() }
    }

    /// What a model would answer that misses row r by `missed(r)`.
    fn answers(held: &HeldOut<'_>, missed: impl Fn(usize) -> f64) -> Vec<Array2<f64>> {
        let of = |split: &Split| {
            let answer = |(at, _): (usize, usize)| {
                let row = split.held_out[at];
                (row + 1) as f64 + missed(row)
            };
            Array2::from_shape_fn((split.held_out.len(), 1), answer)
        };
        held.splits().iter().map(of).collect()
    }

    #[test]
    fn the_width_is_what_so_many_of_one_more_row_are_missed_by() {
        let data = rows(99, "y", 0);
        let held = HeldOut::new(&data, 0.9, 7).unwrap();
        // Missed by 1 to 99, in both directions: 90 of 100 are at most 90 away.
        let sign = |row: usize| if row.is_multiple_of(2) { 1.0 } else { -1.0 };
        let shown = held.shown(&answers(&held, |row| sign(row) * (row + 1) as f64)).unwrap();
        assert_eq!(shown.interval.widths, [90.0]);
        assert_eq!(shown.interval.from, "10 parts of 99 rows, each held out once");
        assert!(shown.r2.unwrap() < 0.0, "{shown:?}");
        let exact = held.shown(&answers(&held, |_| 0.0)).unwrap();
        assert_eq!((exact.interval.widths, exact.r2), (vec![0.0], Some(1.0)));
        let all = data.target_values().to_owned() + 90.0;
        assert!((coverage(&shown.interval, &data, &all) - 1.0).abs() < 1e-12);
        assert_eq!(coverage(&shown.interval, &data, &(all + 0.1)), 0.0);
    }

    #[test]
    fn a_logarithmic_target_is_missed_by_a_factor() {
        let data = rows(20, "y:ln", 0);
        let held = HeldOut::new(&data, 0.8, 1).unwrap();
        let shown = held.shown(&answers(&held, |row| 0.25 * (row + 1) as f64)).unwrap();
        assert!((shown.interval.widths[0] - 1.25).abs() < 1e-6, "{shown:?}");
    }

    #[test]
    fn groups_stay_together_and_the_worst_of_few_counts() {
        let data = rows(60, "y", 3);
        let held = HeldOut::new(&data, 0.9, 1).unwrap();
        assert_eq!(held.splits().len(), 3);
        for split in held.splits() {
            assert!(split.held_out.iter().all(|row| row % 3 == split.held_out[0] % 3));
        }
        let shown = held.shown(&answers(&held, |row| (row % 3) as f64)).unwrap();
        assert_eq!(shown.interval.widths, [2.0]);
        assert_eq!(shown.interval.from, "3 parts of 3 groups, 60 rows, each held out once");
    }

    #[test]
    fn of_many_groups_each_counts_the_same() {
        // Groups of one, two or three rows that are missed by their number: 90 of 100 groups.
        let groups = |n: usize| -> Vec<Vec<f64>> {
            (1..=n).map(|group| vec![group as f64; 1 + group % 3]).collect()
        };
        assert_eq!(width(groups(99), 0.9), 90.0);
        assert_eq!(width(groups(9), 0.9), 9.0);
        assert_eq!(width(groups(8), 0.9), 8.0, "the worst of a few");
        // The nine tenths of the worst group.
        let ten: Vec<f64> = (1..=10).map(f64::from).collect();
        assert_eq!(width(vec![ten.clone(), vec![2.0; 5], vec![0.0; 50]], 0.9), 9.0);
    }

    #[test]
    fn what_can_not_be_stated_is_refused() {
        let [few, enough] = [8, 9].map(|n| rows(n, "y", 0));
        let error = HeldOut::new(&few, 0.9, 1).unwrap_err();
        assert_eq!(error.to_string(), "8 rows: an interval of 90 % needs at least 9");
        assert!(HeldOut::new(&few, 1.0, 1).is_err() && HeldOut::new(&few, f64::NAN, 1).is_err());
        let held = HeldOut::new(&enough, 0.9, 1).unwrap();
        let error = held.shown(&answers(&held, |_| f64::NAN)).unwrap_err();
        assert_eq!(error, IntervalError::NoLimit { target: 0 });
    }

    #[test]
    fn few_groups_must_be_large_and_small_ones_many() {
        let refused = |n, groups| HeldOut::new(&rows(n, "y", groups), 0.9, 1).map(|_| ());
        for (n, groups) in [(9, 9), (27, 3), (60, 6)] {
            assert_eq!(refused(n, groups), Ok(()), "{n} rows, {groups} groups");
        }
        for (n, groups) in [(8, 8), (26, 3), (30, 2), (30, 1)] {
            assert!(refused(n, groups).is_err(), "{n} rows, {groups} groups");
        }
        assert_eq!(
            refused(8, 8).unwrap_err().to_string(),
            "8 groups, 8 of fewer than 9 rows: an interval of 90 % needs 9 groups, or at least 3 of 9 rows each"
        );
    }
}
