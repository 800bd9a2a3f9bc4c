//! Interval of an answer: the limits, by a width, that hold a stated share of the truths.

use serde::{Deserialize, Serialize};

use crate::{
    file::{FileColumn, FileError},
    model::{Transform, rounded},
};

/// The field `interval` of a model file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Interval {
    /// Share of the truths between the limits, above 0 and below 1.
    pub level: f64,
    /// For each target what is taken off the answer and added to it, in its unit (0 or more), or what the answer is divided and multiplied by
    /// where the target is logarithmic or reciprocal (1 or more).
    pub widths: Vec<f32>,
    /// The rows that showed it, in words.
    pub from: String,
}

impl Interval {
    /// The limits around `answer`, the lower one first. Rounded to `f32` they are those of one operation in `f32`.
    #[must_use]
    pub fn around(transform: Transform, width: f32, answer: f64) -> [f64; 2] {
        let width = f64::from(width);
        match transform.is_relative() {
            true => [answer / width, answer * width],
            false => [answer - width, answer + width],
        }
    }

    /// Whether there is a level, and a width for each of `targets`.
    ///
    /// # Errors
    /// [`FileError::Interval`].
    pub fn check(&self, targets: &[FileColumn]) -> Result<(), FileError> {
        let least = |target: &FileColumn| f32::from(u8::from(target.transform.is_relative()));
        let fits =
            |(width, target): (&f32, &FileColumn)| width.is_finite() && *width >= least(target);
        let fit = self.widths.len() == targets.len()
            && self.widths.iter().zip(targets).all(fits)
            && rounded(self.level) > 0.0
            && self.level < 1.0;
        if fit { Ok(()) } else { Err(FileError::Interval) }
    }
}
