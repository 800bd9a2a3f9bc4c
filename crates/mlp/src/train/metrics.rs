//! Errors of a model's predictions on a data set.

use super::data::DataSet;
use super::objective::count;
use super::scaling::Scaling;
use crate::model::{Coverage, Model, PredictError};
use crate::network::ShapeError;
use ndarray::{Array1, Array2, ArrayRef1, ArrayRef2};

/// Why there are no predictions for rows.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("row {row}: {source}")]
pub struct EvaluateError {
    /// Row of data, counted from 1.
    pub row: usize,
    /// Why there is no prediction for it.
    pub source: PredictError,
}

/// Errors of a model over the rows of a data set.
#[derive(Debug, Clone, PartialEq)]
pub struct Evaluation {
    /// Number of rows.
    pub rows: usize,
    /// Mean squared error over rows and targets in raw units squared.
    pub mse: f64,
    /// The same per target.
    pub mse_per_target: Array1<f64>,
    /// Mean squared error over rows and targets in the scaled units the training saw.
    pub scaled_mse: f64,
    /// Rows with a feature outside the training range.
    pub extrapolated: usize,
    /// `|prediction - target| / |target|` of each value, rows x targets; 0 for an exact prediction of 0, otherwise infinite
    /// where the target is 0.
    pub relative_errors: Array2<f64>,
    /// 1 less `mse_per_target` over the variance of the target in these rows, mean over the targets that vary: 1 for exact answers, 0
    /// for those of the mean, less for worse ones. `None` where none varies, and of classes.
    pub r2: Option<f64>,
    /// Of classes: targets and predictions are then probabilities.
    pub classes: Option<Classified>,
}

/// How well classes are distinguished.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Classified {
    /// Share of rows whose own class is the most probable, 0 to 1.
    pub accuracy: f64,
    /// Mean of `-ln p` of the row's own class.
    pub cross_entropy: f64,
}

impl Evaluation {
    /// Share of values predicted within `tolerance` times the target, 0 to 1.
    #[must_use]
    pub fn within_fraction(&self, tolerance: f64) -> f64 {
        let within = self.relative_errors.iter().filter(|error| **error <= tolerance).count();
        count(within) / count(self.relative_errors.len())
    }
}

/// What `model` predicts for raw feature rows (rows x inputs), scaled in double precision: raw predictions (rows x targets), and
/// how well the training covers each row. No rows give no predictions.
///
/// # Errors
/// [`EvaluateError`] for the first row without a prediction; that is row 1 where the number of columns is wrong.
pub fn predict<W: AsRef<[f32]>, const IO: usize, const WIDTH: usize>(
    model: &Model<W, IO, WIDTH>,
    rows: &ArrayRef2<f64>,
) -> Result<(Array2<f64>, Vec<Coverage>), EvaluateError> {
    let mut predicted = Array2::zeros((rows.nrows(), model.targets().axes().len()));
    let mut coverage = Vec::with_capacity(rows.nrows());
    let mut answer = vec![0.0; model.targets().axes().len()];
    for (at, (row, mut place)) in rows.rows().into_iter().zip(predicted.rows_mut()).enumerate() {
        let raw = row.to_vec();
        let covered = model
            .predict_double(&raw, &mut answer)
            .map_err(|source| EvaluateError { row: at + 1, source })?;
        place.iter_mut().zip(&answer).for_each(|(place, value)| *place = *value);
        coverage.push(covered);
    }
    Ok((predicted, coverage))
}

/// Lets `model` predict every row of `data`, whose columns must be in the model's order. Its answers about classes are scores, of
/// which [softmax] makes the probabilities that are judged.
///
/// # Errors
/// [`EvaluateError`] for the first row without a prediction, or with another number of targets than the model has.
pub fn evaluate<W: AsRef<[f32]>, const IO: usize, const WIDTH: usize>(
    model: &Model<W, IO, WIDTH>,
    data: &DataSet,
) -> Result<Evaluation, EvaluateError> {
    let scalings: Vec<Scaling> = model.targets().columns().map(Scaling::from).collect();
    let (needed, given) = (scalings.len(), data.target_values().ncols());
    if needed != given {
        let source = ShapeError::Outputs { needed, given }.into();
        return Err(EvaluateError { row: 1, source });
    }
    let (mut predicted, coverage) = predict(model, &data.input_values())?;
    let classes = data.classes.as_ref().map(|_| classified(&mut predicted, data));
    let mut squares = Array1::zeros(scalings.len());
    let mut scaled_squares = 0.0;
    let mut relative_errors = Array2::zeros(predicted.dim());
    let values = predicted.iter().zip(data.target_values()).zip(&mut relative_errors);
    for (at, ((&prediction, &target), relative)) in values.enumerate() {
        let column = at % scalings.len();
        let error = prediction - target;
        squares[column] += error * error;
        let scaled = scaled_error(&scalings[column], prediction, target);
        scaled_squares += scaled * scaled;
        *relative = if error == 0.0 { 0.0 } else { (error / target).abs() };
    }
    let rows = count(data.rows());
    let r2 = data.classes.is_none().then(|| r_squared(&(&squares / rows), data)).flatten();
    Ok(Evaluation {
        r2,
        rows: data.rows(),
        mse: squares.iter().sum::<f64>() / (rows * count(squares.len())),
        scaled_mse: scaled_squares / (rows * count(squares.len())),
        mse_per_target: squares / rows,
        extrapolated: coverage.iter().filter(|covered| **covered != Coverage::Inside).count(),
        relative_errors,
        classes,
    })
}

/// Makes probabilities of scores; returns the logarithm of the sum of their exponentials.
pub fn softmax(scores: &mut [f64]) -> f64 {
    let largest = scores.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let sum: f64 = scores.iter().map(|score| libm::exp(score - largest)).sum();
    let log_sum = largest + libm::log(sum);
    scores.iter_mut().for_each(|score| *score = libm::exp(*score - log_sum));
    log_sum
}

/// Makes probabilities of the scores of each row.
fn classified(scores: &mut Array2<f64>, data: &DataSet) -> Classified {
    let (mut right, mut entropy) = (0, 0.0);
    for (mut row, target) in scores.rows_mut().into_iter().zip(data.target_values().rows()) {
        let own = target.iter().position(|target| *target == 1.0).unwrap_or(0);
        let largest = row.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        right += usize::from(row.iter().position(|score| *score == largest) == Some(own));
        let (mut scores, score) = (row.to_vec(), row[own]);
        entropy += softmax(&mut scores) - score;
        row.iter_mut().zip(scores).for_each(|(place, probability)| *place = probability);
    }
    let rows = count(data.rows());
    Classified { accuracy: count(right) / rows, cross_entropy: entropy / rows }
}

/// What [`Evaluation::r2`] states, of mean squared errors `mse` of each target.
#[must_use]
pub fn r_squared(mse: &ArrayRef1<f64>, data: &DataSet) -> Option<f64> {
    let columns = data.target_values();
    let shares = mse.iter().zip(columns.columns()).filter_map(|(mse, column)| {
        let variance = column.var(0.0);
        (variance > 0.0).then_some(1.0 - mse / variance)
    });
    let (sum, varying) = shares.fold((0.0, 0.0), |(sum, n), share| (sum + share, n + 1.0));
    (varying > 0.0).then(|| sum / varying)
}

fn scaled_error(scaling: &Scaling, prediction: f64, target: f64) -> f64 {
    let span = scaling.span();
    if span == 0.0 {
        return 0.0;
    }
    let transformed = |raw: f64| scaling.column.transform.forward(raw);
    2.0 * (transformed(prediction) - transformed(target)) / span
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::activation::Activation;
    use crate::model::{Column, Scaler, Transform};
    use crate::network::Network;
    use ndarray::{Axis, arr2};

    /// Predicts `y = x` for 0..4.
    fn identity() -> Model<[f32; 2]> {
        let network = Network::new(&[1, 1], &[Activation::Linear], [1.0, 0.0]).unwrap();
        let scaler = Scaler::new(&[Column::new(Transform::Identity, 0.0, 4.0)]).unwrap();
        Model::new(network, scaler.clone(), scaler).unwrap()
    }

    fn data(csv: &str) -> DataSet {
        let spec = |text: &str| vec![text.parse().unwrap()];
        DataSet::from_csv("t.csv", csv.as_bytes(), &spec("x"), &spec("y")).unwrap()
    }

    #[test]
    fn hand_computed_errors() {
        let evaluation = evaluate(&identity(), &data("x,y\n1,1\n2,2.5\n3,2\n0,0\n8,8\n")).unwrap();
        assert_eq!((evaluation.rows, evaluation.extrapolated), (5, 1));
        assert!((evaluation.mse - 1.25 / 5.0).abs() < 1e-12, "{evaluation:?}");
        assert!((evaluation.scaled_mse - 1.25 / 4.0 / 5.0).abs() < 1e-12, "{evaluation:?}");
        assert!((evaluation.within_fraction(0.1) - 0.6).abs() < 1e-12);
        assert!((evaluation.within_fraction(0.25) - 0.8).abs() < 1e-12);
        // Targets 1, 2.5, 2, 0, 8 about 2.7: variance 7.76.
        assert!((evaluation.r2.unwrap() - (1.0 - 0.25 / 7.76)).abs() < 1e-12, "{evaluation:?}");
        assert_eq!(evaluate(&identity(), &data("x,y\n1,5\n2,5\n")).unwrap().r2, None);
    }

    #[test]
    fn rows_of_any_layout_are_predicted_like_one_after_the_other() {
        let model = identity();
        let rows = arr2(&[[1.0, 9.0], [2.0, 9.0], [5.0, 9.0]]);
        let (mut column, _) = rows.view().split_at(Axis(1), 1);
        column.invert_axis(Axis(0));
        let (predicted, coverage) = predict(&model, &column).unwrap();
        assert_eq!(predicted, arr2(&[[5.0], [2.0], [1.0]]));
        assert_eq!(coverage, [Coverage::Outside { column: 0 }, Coverage::Inside, Coverage::Inside]);
        assert_eq!(predict(&model, &Array2::zeros((0, 1))).unwrap().0.dim(), (0, 1));
        let wide = predict(&model, &rows).unwrap_err();
        assert_eq!(wide.to_string(), "row 1: 2 inputs where 1 are needed");
    }

    #[test]
    fn a_target_of_zero_counts_only_when_met() {
        let evaluation = evaluate(&identity(), &data("x,y\n1,0\n0,0\n")).unwrap();
        assert!((evaluation.within_fraction(0.1) - 0.5).abs() < 1e-12, "{evaluation:?}");
    }
}
