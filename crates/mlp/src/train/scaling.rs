//! Scaling of raw training values: limits and scaled values in double precision.

use super::column::{ColumnSpec, unit_of};
use super::file::FileColumn;
use super::topology::Topology;
use crate::model::{Column, Transform};

mlp_core::named! {
    "scaler",
    /// What training values become.
    #[derive(Default)]
    pub enum Method {
        /// Smallest to largest value becomes -1 to 1.
        #[default]
        MinMax = "min-max",
        /// Mean 0 and deviation 1. For columns with outliers, which min-max presses into a corner. The saved model has min-max
        /// limits all the same: the difference is taken up by the weights of the first and last layer ([`as_min_max`]).
        ZScore = "z-score",
    }
}

/// How a [`Column`] is scaled while training, in double precision.
///
/// With T the transform, min-max is `scaled = 2 (T(raw) - T(min)) / (T(max) - T(min)) - 1`, z-score
/// `scaled = (T(raw) - mean) / deviation` with mean and deviation of T(raw); a constant column becomes 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scaling {
    /// Transform and limits of the training values, as the saved model has them.
    pub column: Column,
    /// Mean and deviation (of the population) of the transformed values, for the z-score.
    pub moments: Option<[f64; 2]>,
}

impl Scaling {
    /// The limits of `values`.
    #[must_use]
    pub fn of(transform: Transform, values: impl IntoIterator<Item = f64>) -> Self {
        let (min, max) = values
            .into_iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(min, max), v| (min.min(v), max.max(v)));
        Column::new(transform, min, max).into()
    }

    /// The limits of `values`, scaled by `method`.
    #[must_use]
    pub fn by(
        method: Method,
        transform: Transform,
        values: &(impl Iterator<Item = f64> + Clone),
    ) -> Self {
        let limits = Self::of(transform, values.clone());
        if method == Method::MinMax {
            return limits;
        }
        let count = super::objective::count(values.clone().count());
        let transformed = || values.clone().map(|raw| transform.forward(raw));
        let mean = transformed().sum::<f64>() / count;
        let variance = transformed().map(|value| (value - mean).powi(2)).sum::<f64>() / count;
        Self { moments: Some([mean, variance.sqrt()]), ..limits }
    }

    /// Scales one raw value. Not finite when the transform does not accept it.
    #[must_use]
    pub fn scaled(&self, raw: f64) -> f64 {
        let (low, span) = self.low_and_span();
        let value = self.column.transform.forward(raw);
        match self.moments {
            _ if span == 0.0 => 0.0,
            None => 2.0 * (value - low) / span - 1.0,
            Some([mean, deviation]) => (value - mean) / deviation,
        }
    }

    /// Gain and offset that turn a value scaled to -1..1 into this scaling's.
    pub(super) fn over_min_max(&self) -> [f64; 2] {
        let (low, span) = self.low_and_span();
        match self.moments {
            None => [1.0, 0.0],
            _ if span == 0.0 => [0.0, 0.0],
            Some([mean, deviation]) => {
                [0.5 * span / deviation, (low + 0.5 * span - mean) / deviation]
            }
        }
    }

    /// Length of the transformed range: scaled errors are errors of the transformed value times two
    /// over it.
    #[must_use]
    pub fn span(&self) -> f64 {
        self.low_and_span().1
    }

    fn low_and_span(&self) -> (f64, f64) {
        let Column { transform, min, max, .. } = self.column;
        let low = transform.forward(min);
        (low, transform.forward(max) - low)
    }
}

impl From<Column> for Scaling {
    fn from(column: Column) -> Self {
        Self { column, moments: None }
    }
}

/// Rewrites `weights` (flat order), trained between `inputs` and `targets`, for the same columns scaled to -1..1. The
/// network's answers stay the same. Exact but for rounding where the last layer is linear, as
/// [`Topology::regression`] makes it; nothing changes under min-max.
#[must_use]
pub fn as_min_max(
    topology: &Topology,
    weights: &[f64],
    inputs: &[Scaling],
    targets: &[Scaling],
) -> Vec<f64> {
    let mut weights = weights.to_vec();
    if let Some(first) = topology.layers().next() {
        let (matrix, biases) =
            weights[first.start..first.end()].split_at_mut(first.from * first.to);
        for (row, bias) in matrix.chunks_exact_mut(first.from).zip(biases) {
            for (weight, [gain, offset]) in
                row.iter_mut().zip(inputs.iter().map(Scaling::over_min_max))
            {
                *bias += *weight * offset;
                *weight *= gain;
            }
        }
    }
    if let Some(last) = topology.layers().next_back() {
        let (matrix, biases) = weights[last.start..last.end()].split_at_mut(last.from * last.to);
        let rows = matrix.chunks_exact_mut(last.from).zip(biases);
        for ((row, bias), [gain, offset]) in rows.zip(targets.iter().map(Scaling::over_min_max)) {
            // A constant target is met by its limits alone.
            let inverse = if gain == 0.0 { 0.0 } else { 1.0 / gain };
            row.iter_mut().for_each(|weight| *weight *= inverse);
            *bias = (*bias - offset) * inverse;
        }
    }
    weights
}

/// Joins specs and limits to file columns; units come from the names.
#[must_use]
pub fn columns(specs: &[ColumnSpec], scalings: &[Scaling]) -> Vec<FileColumn> {
    specs
        .iter()
        .zip(scalings)
        .map(|(spec, scaling)| {
            let Column { transform, min, max, noise } = scaling.column;
            let unit = unit_of(&spec.name).to_owned();
            FileColumn { name: spec.name.clone(), unit, transform, min, max, noise }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Scaler;

    #[test]
    fn agrees_with_the_scaler_of_the_model() {
        for transform in Transform::ALL {
            let scaling = Scaling::of(transform, [0.5, 0.25, 8.0, 1.0]);
            assert_eq!(scaling.column, Column::new(transform, 0.25, 8.0));
            let scaler = Scaler::new(&[scaling.column]).unwrap();
            for raw in [0.1_f32, 0.25, 1.0, 7.5, 20.0] {
                let double = scaling.scaled(f64::from(raw));
                let single = f64::from(scaler.axes()[0].scaled(raw).unwrap());
                assert!((double - single).abs() < 1e-6, "{transform} {raw}: {double} {single}");
            }
        }
    }

    #[test]
    fn z_scores_have_mean_zero_and_deviation_one() {
        let values = [1.0, 2.0, 4.0, 8.0, 1000.0];
        for transform in Transform::ALL {
            let scaling = Scaling::by(Method::ZScore, transform, &values.into_iter());
            let scaled = values.map(|value| scaling.scaled(value));
            let square: f64 = scaled.iter().map(|z| z * z).sum();
            assert!(scaled.iter().sum::<f64>().abs() < 1e-12 && (square / 5.0 - 1.0).abs() < 1e-12);
            let limits = Scaling::by(Method::MinMax, transform, &values.into_iter());
            assert_eq!(limits, Scaling::of(transform, values));
            let [gain, offset] = scaling.over_min_max();
            for value in values {
                let folded = gain * limits.scaled(value) + offset;
                assert!((folded - scaling.scaled(value)).abs() < 1e-12, "{value}");
            }
        }
        let constant = Scaling::by(Method::ZScore, Transform::Identity, &[3.0, 3.0].into_iter());
        assert_eq!(constant.scaled(5.0), 0.0);
        assert_eq!("z-score".parse(), Ok(Method::ZScore));
        let error = "robust".parse::<Method>().unwrap_err();
        assert_eq!(error.to_string(), "unknown scaler (known: min-max, z-score)");
    }

    #[test]
    fn a_constant_column_becomes_zero() {
        let scaling = Scaling::of(Transform::Identity, [3.0, 3.0]);
        assert_eq!([scaling.scaled(3.0), scaling.scaled(9.0)].map(f64::to_bits), [0, 0]);
    }
}
