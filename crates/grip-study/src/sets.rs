//! Rows to train and test on, by condition and seed, and the scores of a learner on them.

use crate::{Condition, Score, StudyError, score};
use grip_sim::generator::{Row, rows};
use mlp::train::{ColumnSpec, DataSet};
use ndarray::{Array2, ArrayRef1};
use serde::Serialize;

/// Rows of the large test set that no learner trains on.
pub const UNSEEN_ROWS: usize = 2000;

/// The rows of one draw of a condition. All objects are different ones.
#[derive(Clone, Debug, PartialEq)]
pub struct Sets {
    /// Rows to train on, 100 as in the study or more.
    pub train: DataSet,
    /// The small test set, 60 rows as in the study or more.
    pub test: DataSet,
    /// A large test set ([`UNSEEN_ROWS`]): 60 rows leave six percentage points of doubt, these one.
    pub unseen: DataSet,
}

/// What a learner reached on each set of rows.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Scores {
    /// On the rows it trained on.
    pub train: Score,
    /// On the small test set.
    pub test: Score,
    /// On the large test set.
    pub unseen: Score,
}

impl Sets {
    /// Scores a learner that answers the raw features of a row with an adequate force (N).
    pub fn score(&self, answer: impl Fn(&ArrayRef1<f64>) -> f64) -> Scores {
        let of = |data: &DataSet| {
            let pairs: Vec<(f64, f64)> =
                data.iter().map(|(features, target)| (answer(&features), target[0])).collect();
            score(&pairs)
        };
        Scores { train: of(&self.train), test: of(&self.test), unseen: of(&self.unseen) }
    }
}

impl Condition {
    /// The rows of draw `draw` under `seed`. Draws are independent; conditions with the same kind of trial force see the
    /// same objects.
    ///
    /// # Errors
    /// [`StudyError`] where the condition is none the generator knows; never for those of
    /// [`crate::condition::ALL`].
    pub fn sets(&self, seed: u64, draw: u64) -> Result<Sets, StudyError> {
        let rows =
            self.rows(draw_seed(seed, draw), self.train_rows + self.test_rows + UNSEEN_ROWS)?;
        let (train, rest) = rows.split_at(self.train_rows);
        let (test, unseen) = rest.split_at(self.test_rows);
        Ok(Sets {
            train: self.data("train", train)?,
            test: self.data("test", test)?,
            unseen: self.data("unseen", unseen)?,
        })
    }

    /// `count` trial grasps.
    ///
    /// # Errors
    /// As [`Condition::sets`].
    pub(crate) fn rows(&self, seed: u64, count: usize) -> Result<Vec<Row>, StudyError> {
        let count = u32::try_from(count).unwrap_or(u32::MAX);
        Ok(rows(self.generator(), seed, count)?.collect())
    }

    /// What a learner sees of `rows`.
    ///
    /// # Errors
    /// As [`Condition::sets`].
    pub(crate) fn data(&self, name: &str, rows: &[Row]) -> Result<DataSet, StudyError> {
        let inputs: Vec<ColumnSpec> =
            self.features.inputs.iter().map(|spec| spec.parse()).collect::<Result<_, _>>()?;
        let target: ColumnSpec = self.features.target.parse()?;
        let mut features = Array2::zeros((rows.len(), inputs.len()));
        for (spec, mut place) in inputs.iter().zip(features.columns_mut()) {
            for (value, row) in place.iter_mut().zip(rows) {
                *value = column(row, &spec.name)?;
            }
        }
        let mut targets = Array2::zeros((rows.len(), 1));
        for (value, row) in targets.iter_mut().zip(rows) {
            *value = column(row, &target.name)?;
        }
        let name = format!("{} ({name})", self.name);
        Ok(DataSet::from_values(&name, &inputs, &[target], features, targets)?)
    }
}

/// A seed for each draw that no other draw nor the plain seed shares.
pub(crate) fn draw_seed(seed: u64, draw: u64) -> u64 {
    seed ^ draw.wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15)
}

fn column(row: &Row, name: &str) -> Result<f64, StudyError> {
    // E is proportional to the force.
    let of_adequate = row.adequate_force_n / row.trial_force_n;
    match name {
        "adequate_force_n" => Ok(row.adequate_force_n),
        "eq1_literal_w" => Ok(row.esc_literal_w * of_adequate),
        "eq1_slope_w" => Ok(row.readings.slope_power_w * of_adequate),
        "eq1_surface_w" => Ok(row.slip_speed_m_s * row.adequate_force_n),
        "slip_speed_m_s" => Ok(row.slip_speed_m_s),
        "contact_time_s" => Ok(row.contact_time_s),
        "slip_acceleration_m_s2" => Ok(row.slip_acceleration_m_s2),
        "trial_force_n" => Ok(row.trial_force_n),
        "esc_literal_w" => Ok(row.esc_literal_w),
        "esc_arc_cot_w" => Ok(row.readings.arc_cot_w),
        "esc_slope_power_w" => Ok(row.readings.slope_power_w),
        "esc_lift_work_j" => Ok(row.readings.lift_work_j),
        "esc_viscous_work_j" => Ok(row.readings.viscous_work_j),
        _ => Err(StudyError::NoColumn(name.to_owned())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::condition::{ALL, PAPER};

    #[test]
    fn every_condition_gives_its_rows_and_draws_differ() {
        for condition in ALL {
            let sets = condition.sets(3, 0).unwrap();
            assert_eq!(
                [sets.train.rows(), sets.test.rows(), sets.unseen.rows()],
                [condition.train_rows, condition.test_rows, UNSEEN_ROWS],
                "{}",
                condition.name
            );
        }
        let of = |seed, draw| PAPER.sets(seed, draw).unwrap();
        assert_eq!(of(3, 0), of(3, 0));
        assert!(of(3, 0).train != of(3, 1).train && of(3, 0).train != of(4, 0).train);
    }

    #[test]
    fn no_object_stands_in_two_sets() {
        let sets = PAPER.sets(3, 0).unwrap();
        let all: std::collections::BTreeSet<u64> = [&sets.train, &sets.test, &sets.unseen]
            .into_iter()
            .flat_map(|data| data.iter().map(|(_, target)| target[0].to_bits()))
            .collect();
        assert_eq!(all.len(), 160 + UNSEEN_ROWS);
    }

    #[test]
    fn a_learner_that_knows_the_physics_is_always_right() {
        let sets = Condition::named("v-f").unwrap().sets(3, 0).unwrap();
        let scores = sets.score(|features| {
            let gained = features[0] * features[0] / (2.0 * 2e-3);
            1.2 * features[1] / (1.0 - gained / grip_sim::GRAVITY_M_S2)
        });
        assert!(scores.unseen.mse < 1e-12 && scores.train.correct == [1.0; 7], "{scores:?}");
    }

    /// Eq. 1 solved for F gives back the force that E was made with.
    #[test]
    fn the_equation_gives_its_force_back() {
        type Factor = fn(&Row) -> f64;
        let cases: [(&str, Factor); 4] = [
            ("eq1", |row| row.esc_literal_w / row.trial_force_n),
            ("eq1-slope", |row| row.readings.slope_power_w / row.trial_force_n),
            ("eq1-surface", |row| row.slip_speed_m_s),
            ("eq1-trial", |row| row.esc_literal_w / row.trial_force_n),
        ];
        for (name, inverted) in cases {
            let condition = Condition::named(name).unwrap();
            let rows = condition.rows(5, 50).unwrap();
            let data = condition.data("rows", &rows).unwrap();
            for ((features, target), row) in data.iter().zip(&rows) {
                let force = features[1] / inverted(row);
                assert!((force / target[0] - 1.0).abs() < 1e-9, "{name}: {force} {target}");
            }
        }
    }

    #[test]
    fn unknown_columns_are_refused() {
        let features = crate::Features { inputs: &["colour"], ..PAPER.features };
        let error = Condition { features, ..PAPER }.sets(1, 0).unwrap_err();
        assert_eq!(error.to_string(), "a trial grasp has no column \"colour\"");
    }
}
