//! Raw training values in, limits and scaled values in double precision out.

use super::rounded;
use crate::scaler::{Column, Transform};

/// Double-precision twin of [`Column`], used while training.
///
/// `scaled = 2 (T(raw) - T(min)) / (T(max) - T(min)) - 1`; a constant column becomes 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scaling {
    /// Applied before scaling.
    pub transform: Transform,
    /// Smallest raw training value.
    pub min: f64,
    /// Largest raw training value.
    pub max: f64,
}

impl Scaling {
    /// The limits of `values`.
    #[must_use]
    pub fn of(transform: Transform, values: impl IntoIterator<Item = f64>) -> Self {
        let (min, max) = values
            .into_iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(min, max), v| (min.min(v), max.max(v)));
        Self { transform, min, max }
    }

    /// Scales one raw value. Not finite when the transform does not accept it.
    #[must_use]
    pub fn scaled(&self, raw: f64) -> f64 {
        let (low, span) = self.low_and_span();
        if span == 0.0 { 0.0 } else { 2.0 * (self.transformed(raw) - low) / span - 1.0 }
    }

    /// Length of the transformed range: scaled errors are errors of the transformed value times two
    /// over it.
    #[must_use]
    pub fn span(&self) -> f64 {
        self.low_and_span().1
    }

    /// The value after the transform.
    #[must_use]
    pub fn transformed(&self, raw: f64) -> f64 {
        match self.transform {
            Transform::Identity => raw,
            Transform::Ln => libm::log(raw),
        }
    }

    /// The column of the saved model, limits rounded to `f32`.
    #[must_use]
    pub fn column(&self) -> Column {
        Column { transform: self.transform, min: rounded(self.min), max: rounded(self.max) }
    }

    fn low_and_span(&self) -> (f64, f64) {
        let low = self.transformed(self.min);
        (low, self.transformed(self.max) - low)
    }
}

impl From<Column> for Scaling {
    fn from(column: Column) -> Self {
        Self { transform: column.transform, min: column.min.into(), max: column.max.into() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scaler::Scaler;

    #[test]
    fn agrees_with_the_scaler_of_the_model() {
        for transform in [Transform::Identity, Transform::Ln] {
            let scaling = Scaling::of(transform, [0.5, 0.25, 8.0, 1.0]);
            assert_eq!(scaling.column(), Column { transform, min: 0.25, max: 8.0 });
            let scaler = Scaler::new(&[scaling.column()]).unwrap();
            for raw in [0.1_f32, 0.25, 1.0, 7.5, 20.0] {
                let double = scaling.scaled(f64::from(raw));
                let single = f64::from(scaler.scaled(0, raw).unwrap());
                assert!((double - single).abs() < 1e-6, "{transform} {raw}: {double} {single}");
            }
        }
    }

    #[test]
    fn a_constant_column_becomes_zero() {
        let scaling = Scaling::of(Transform::Identity, [3.0, 3.0]);
        assert_eq!([scaling.scaled(3.0), scaling.scaled(9.0)].map(f64::to_bits), [0, 0]);
    }
}
