//! A model and a data set in, errors of its predictions out.

use super::data::DataSet;
use super::objective::count;
use super::rounded;
use super::scaling::Scaling;
use crate::model::{Coverage, Model, PredictError};

/// Why a data set can not be evaluated.
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
    pub mse_per_target: Vec<f64>,
    /// Mean squared error over rows and targets in the scaled units the training saw.
    pub scaled_mse: f64,
    /// Rows with a feature outside the training range.
    pub extrapolated: usize,
    /// `|prediction - target| / |target|` of each value; 0 for an exact prediction of 0, otherwise infinite
    /// where the target is 0.
    pub relative_errors: Vec<f64>,
}

impl Evaluation {
    /// Share of values predicted within `tolerance` times the target, 0 to 1.
    #[must_use]
    pub fn within_fraction(&self, tolerance: f64) -> f64 {
        let within = self.relative_errors.iter().filter(|error| **error <= tolerance).count();
        count(within) / count(self.relative_errors.len())
    }
}

/// Lets `model` predict every row of `data`, whose columns must be in the model's order.
///
/// # Errors
/// [`EvaluateError`] for the first row without a prediction.
pub fn evaluate<W: AsRef<[f32]>>(
    model: &Model<W>,
    data: &DataSet,
) -> Result<Evaluation, EvaluateError> {
    let scalings: Vec<Scaling> = model.targets().columns().map(Scaling::from).collect();
    let mut squares = vec![0.0; scalings.len()];
    let mut scaled_squares = 0.0;
    let mut extrapolated = 0;
    let mut relative_errors = Vec::with_capacity(data.rows() * scalings.len());
    let mut predicted = vec![0.0_f32; scalings.len()];
    for (at, (inputs, targets)) in data.iter().enumerate() {
        let raw: Vec<f32> = inputs.iter().map(|&value| rounded(value)).collect();
        let coverage = model
            .predict(&raw, &mut predicted)
            .map_err(|source| EvaluateError { row: at + 1, source })?;
        extrapolated += usize::from(coverage != Coverage::Inside);
        for (column, (&prediction, &target)) in predicted.iter().zip(targets).enumerate() {
            let prediction = f64::from(prediction);
            let error = prediction - target;
            squares[column] += error * error;
            let scaled = scaled_error(&scalings[column], prediction, target);
            scaled_squares += scaled * scaled;
            relative_errors.push(if error == 0.0 { 0.0 } else { (error / target).abs() });
        }
    }
    let rows = count(data.rows());
    let mse_per_target: Vec<f64> = squares.iter().map(|sum| sum / rows).collect();
    Ok(Evaluation {
        rows: data.rows(),
        mse: squares.iter().sum::<f64>() / (rows * count(squares.len())),
        mse_per_target,
        scaled_mse: scaled_squares / (rows * count(squares.len())),
        extrapolated,
        relative_errors,
    })
}

fn scaled_error(scaling: &Scaling, prediction: f64, target: f64) -> f64 {
    let span = scaling.span();
    if span == 0.0 {
        return 0.0;
    }
    2.0 * (scaling.transformed(prediction) - scaling.transformed(target)) / span
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::activation::Activation;
    use crate::network::Network;
    use crate::scaler::{Column, Scaler, Transform};

    /// Predicts `y = x` for 0..4.
    fn identity() -> Model<[f32; 2]> {
        let network = Network::new(&[1, 1], &[Activation::Linear], [1.0, 0.0]).unwrap();
        let scaler =
            Scaler::new(&[Column { transform: Transform::Identity, min: 0.0, max: 4.0 }]).unwrap();
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
    }

    #[test]
    fn a_target_of_zero_counts_only_when_met() {
        let evaluation = evaluate(&identity(), &data("x,y\n1,0\n0,0\n")).unwrap();
        assert!((evaluation.within_fraction(0.1) - 0.5).abs() < 1e-12, "{evaluation:?}");
    }
}
