//! Errors of the predictions of any learner on a data set.

use mlp::train::{DataSet, DataSetError, FileError, FitError, Scaling, SettingError};
use mlp::train::{metrics::r_squared, split::SplitError};
use mlp::{Model, PredictError};
use ndarray::{Array1, Array2, ArrayRef1};

/// What turns the raw features of a row into raw targets.
pub trait Predict {
    /// Writes the prediction for `inputs` (raw, in the order of the training columns) to `outputs`.
    ///
    /// # Errors
    /// [`PredictError`] where inputs or outputs have the wrong length, or a feature or the answer is not finite.
    fn predict(&self, inputs: &ArrayRef1<f64>, outputs: &mut [f64]) -> Result<(), PredictError>;

    /// Mean and spread of each target; empty for a learner that has no spread.
    ///
    /// # Errors
    /// As [`Predict::predict`].
    fn spread(&self, _inputs: &ArrayRef1<f64>) -> Result<Vec<Spread>, PredictError> {
        Ok(Vec::new())
    }
}

/// A mean and the standard deviation of several answers around it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spread {
    /// Mean, in the raw unit of the target.
    pub mean: f64,
    /// Standard deviation (with one answer less in the denominator).
    pub deviation: f64,
}

impl<W: AsRef<[f32]>, const IO: usize, const WIDTH: usize> Predict for Model<W, IO, WIDTH> {
    fn predict(&self, inputs: &ArrayRef1<f64>, outputs: &mut [f64]) -> Result<(), PredictError> {
        self.predict_double(&inputs.to_vec(), outputs).map(|_| ())
    }
}

/// Errors of a learner over the rows of a data set.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Score {
    /// Number of rows.
    pub rows: usize,
    /// Mean squared error over rows and targets in raw units squared.
    pub mse: f64,
    /// The same in units scaled to [-1, 1] over the training rows, after the transform of the target.
    pub scaled_mse: f64,
    /// Share of values predicted within 10 % of the target, 0 to 1.
    pub within_10pct: f64,
    /// As [`mlp::train::Evaluation::r2`].
    pub r2: Option<f64>,
}

/// Why there is no learner or no score.
#[derive(Debug, thiserror::Error)]
pub enum OutlookError {
    /// Nets can not be trained on these rows or with these settings.
    #[error(transparent)]
    Fit(#[from] FitError),
    /// Rows that do not fit.
    #[error(transparent)]
    Data(#[from] DataSetError),
    /// A setting out of its range.
    #[error(transparent)]
    Setting(#[from] SettingError),
    /// Rows that can not be split.
    #[error(transparent)]
    Split(#[from] SplitError),
    /// Text of a file that is none of its kind.
    #[error(transparent)]
    File(#[from] FileError),
    /// Data with other columns than the training rows.
    #[error("{file} has other columns than the training rows")]
    OtherColumns {
        /// Name of the file.
        file: String,
    },
    /// No prediction for a row.
    #[error("{file}, row {row}: {source}")]
    Predict {
        /// Name of the file.
        file: String,
        /// Row of data, counted from 1.
        row: usize,
        /// Why.
        source: PredictError,
    },
    /// A number of something that is too small or too large.
    #[error("{given} {what}: {range} are possible")]
    Count {
        /// What is counted.
        what: &'static str,
        /// Number asked for.
        given: usize,
        /// What is possible.
        range: &'static str,
    },
    /// Equations of a polynomial or of a Gaussian process without a solution.
    #[error("the rows leave the equations without a solution")]
    Singular,
    /// The support vector machine gave up.
    #[error("support vector regression: {message}")]
    Svr {
        /// What it said.
        message: String,
    },
    /// The genetic algorithm refused its settings.
    #[error("search: {message}")]
    Search {
        /// What it said.
        message: String,
    },
    /// No candidate of a search trained to a finite error.
    #[error("none of {candidates} candidates reached a finite validation error")]
    NoCandidate {
        /// Candidates tried.
        candidates: usize,
    },
}

/// What `learner` predicts for the rows of `data`: rows x targets, raw.
///
/// # Errors
/// [`OutlookError::Predict`] for the first row without a prediction.
pub fn answers(learner: &dyn Predict, data: &DataSet) -> Result<Array2<f64>, OutlookError> {
    let mut answers = Array2::zeros(data.target_values().dim());
    let mut row = vec![0.0; answers.ncols()];
    for (at, ((inputs, _), mut place)) in data.iter().zip(answers.rows_mut()).enumerate() {
        learner.predict(&inputs, &mut row).map_err(|source| OutlookError::Predict {
            file: data.file.clone(),
            row: at + 1,
            source,
        })?;
        place.iter_mut().zip(&row).for_each(|(place, answer)| *place = *answer);
    }
    Ok(answers)
}

/// Lets `learner` predict every row of `data`; `targets` are the limits of the training rows.
///
/// # Errors
/// [`OutlookError::OtherColumns`] where the numbers of targets differ; [`OutlookError::Predict`] for the first row without
/// a prediction.
pub fn score(
    learner: &dyn Predict,
    data: &DataSet,
    targets: &[Scaling],
) -> Result<Score, OutlookError> {
    if targets.len() != data.targets.len() {
        return Err(OutlookError::OtherColumns { file: data.file.clone() });
    }
    let mut squares = Array1::<f64>::zeros(targets.len());
    let (mut scaled_squares, mut within) = (0.0, 0.0);
    let (predicted, wanted) = (answers(learner, data)?, data.target_values());
    for (predicted, wanted) in predicted.rows().into_iter().zip(wanted.rows()) {
        let values = predicted.iter().zip(wanted).zip(targets).zip(&mut squares);
        for (((&predicted, &wanted), scaling), squares) in values {
            *squares += (predicted - wanted).powi(2);
            scaled_squares += (scaling.scaled(predicted) - scaling.scaled(wanted)).powi(2);
            within += f64::from((predicted - wanted).abs() <= 0.1 * wanted.abs());
        }
    }
    let values = (data.rows() * targets.len()) as f64;
    Ok(Score {
        rows: data.rows(),
        mse: squares.sum() / values,
        r2: r_squared(&(&squares / data.rows() as f64), data),
        scaled_mse: scaled_squares / values,
        within_10pct: within / values,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use mlp::train::{FitConfig, fit};

    struct Constant(f64);

    impl Predict for Constant {
        fn predict(&self, _: &ArrayRef1<f64>, outputs: &mut [f64]) -> Result<(), PredictError> {
            outputs.fill(self.0);
            Ok(())
        }
    }

    fn data(csv: &str) -> DataSet {
        let spec = |text: &str| vec![text.parse().unwrap()];
        DataSet::from_csv("t.csv", csv.as_bytes(), &spec("x"), &spec("y:ln")).unwrap()
    }

    #[test]
    fn hand_computed_errors() {
        let rows = data("x,y\n1,1\n2,2\n3,4\n");
        let got = score(&Constant(2.0), &rows, &rows.target_scalings()).unwrap();
        // Raw errors 1, 0, 2; scaled by ln over 1 to 4: 1, 0, 1.
        assert!((got.mse - 5.0 / 3.0).abs() < 1e-12 && (got.scaled_mse - 2.0 / 3.0).abs() < 1e-12);
        assert!((got.within_10pct - 1.0 / 3.0).abs() < 1e-12, "{got:?}");
        // The mean would be better: variance 14 / 9.
        assert!((got.r2.unwrap() + 1.0 / 14.0).abs() < 1e-12, "{got:?}");
        let none = score(&Constant(2.0), &rows, &[]);
        assert!(matches!(none, Err(OutlookError::OtherColumns { .. })));
    }

    /// The same errors as the evaluation of model files.
    #[test]
    fn a_model_scores_as_it_evaluates() {
        let rows = data("x,y\n1,1\n2,2\n3,4\n4,3\n5,2.5\n");
        let fit = fit(&rows, None, None, &FitConfig::default()).unwrap();
        let got = score(&*fit.model, &rows, &rows.target_scalings()).unwrap();
        assert!((got.mse / fit.train.mse - 1.0).abs() < 1e-9);
        assert!((got.scaled_mse / fit.train.scaled_mse - 1.0).abs() < 1e-6);
        assert!((got.within_10pct - fit.train.within_fraction(0.1)).abs() < 1e-12);
    }
}
