//! Raw features in, raw targets out, with a word on whether the training data covered them.

use crate::network::{MAX_WIDTH, Network, ShapeError};
use core::{fmt, str::FromStr};

/// Whether all features lay between the limits of the training rows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Coverage {
    /// All of them: the network interpolates.
    Inside,
    /// At least one lay outside: the network extrapolates and its answer is a guess.
    Outside {
        /// The first feature that lay outside.
        column: usize,
    },
}

/// The single target of a model with one output.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// Value in the raw unit of the target, finite.
    pub value: f32,
    /// Whether a feature lay outside the training range.
    pub extrapolated: bool,
}

/// Why there is no prediction.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum PredictError {
    /// Slices of the wrong length, or [`Model::estimate`] on a model with several targets.
    #[error(transparent)]
    Shape(#[from] ShapeError),
    /// A feature is NaN or infinite.
    #[error("feature {column} is not finite")]
    NotFinite {
        /// Its place.
        column: usize,
    },
    /// A logarithmic feature is zero or negative.
    #[error("feature {column} is {value}: the logarithm needs a value above 0")]
    OutOfDomain {
        /// Its place.
        column: usize,
        /// Its raw value.
        value: f32,
    },
    /// The answer overflows.
    #[error("the estimate of target {target} is not finite")]
    Overflow {
        /// Its place.
        target: usize,
    },
}

/// A network together with the ranges of its features and targets: up to `IO` of each, and layers of up to `WIDTH`.
#[derive(Debug, Clone, PartialEq)]
pub struct Model<W, const IO: usize = MAX_IO, const WIDTH: usize = MAX_WIDTH> {
    network: Network<W, WIDTH>,
    inputs: Scaler<IO>,
    targets: Scaler<IO>,
}

impl<W: AsRef<[f32]>, const IO: usize, const WIDTH: usize> Model<W, IO, WIDTH> {
    /// Joins the parts.
    ///
    /// # Errors
    /// [`ShapeError::Inputs`] or [`ShapeError::Outputs`] when the scalers have not as many columns as
    /// the network has inputs and outputs.
    pub fn new(
        network: Network<W, WIDTH>,
        inputs: Scaler<IO>,
        targets: Scaler<IO>,
    ) -> Result<Self, ShapeError> {
        if inputs.len() != network.inputs() {
            return Err(ShapeError::Inputs { needed: network.inputs(), given: inputs.len() });
        }
        if targets.len() != network.outputs() {
            return Err(ShapeError::Outputs { needed: network.outputs(), given: targets.len() });
        }
        Ok(Self { network, inputs, targets })
    }

    /// The network between the scalers.
    #[must_use]
    pub fn network(&self) -> &Network<W, WIDTH> {
        &self.network
    }

    /// The network alone.
    #[must_use]
    pub fn into_network(self) -> Network<W, WIDTH> {
        self.network
    }

    /// Ranges of the features.
    #[must_use]
    pub fn inputs(&self) -> &Scaler<IO> {
        &self.inputs
    }

    /// Ranges of the targets.
    #[must_use]
    pub fn targets(&self) -> &Scaler<IO> {
        &self.targets
    }

    /// Writes the estimated targets for the features `raw` to `out`, both in raw units and in the order
    /// of the columns. Features beyond the training range are used as they are and reported.
    ///
    /// # Errors
    /// Any [`PredictError`]; `out` is then not written, except for [`PredictError::Overflow`], where the
    /// targets before the named one are.
    pub fn predict(&self, raw: &[f32], out: &mut [f32]) -> Result<Coverage, PredictError> {
        self.predict_by(&self.network, raw, out)
    }

    fn predict_by(
        &self,
        network: &Network<W, WIDTH>,
        raw: &[f32],
        out: &mut [f32],
    ) -> Result<Coverage, PredictError> {
        let inputs = self.inputs.len();
        if raw.len() != inputs {
            return Err(ShapeError::Inputs { needed: inputs, given: raw.len() }.into());
        }
        let targets = self.targets.len();
        if out.len() != targets {
            return Err(ShapeError::Outputs { needed: targets, given: out.len() }.into());
        }
        let mut scaled = [0.0_f32; IO];
        let coverage = self.scale(raw, &mut scaled)?;
        let mut outputs = [0.0_f32; WIDTH];
        let scaled = scaled.get(..inputs).unwrap_or(&[]);
        network.forward(scaled, outputs.get_mut(..targets).unwrap_or(&mut []))?;
        for (target, (place, output)) in out.iter_mut().zip(outputs).enumerate() {
            *place = match self.targets.raw(target, output) {
                Some(value) if value.is_finite() => value,
                _ => return Err(PredictError::Overflow { target }),
            };
        }
        Ok(coverage)
    }

    /// The estimate of a model with one target, for the features `raw`.
    ///
    /// # Errors
    /// Any [`PredictError`]; [`ShapeError::Outputs`] when the model has several targets.
    pub fn estimate(&self, raw: &[f32]) -> Result<Estimate, PredictError> {
        self.estimate_by(&self.network, raw)
    }

    /// [`Model::estimate`] by another network behind the same ranges, such as the next one of an ensemble.
    ///
    /// # Errors
    /// As [`Model::estimate`]; [`PredictError::Shape`] too where `network` has other sizes outside.
    pub fn estimate_by(
        &self,
        network: &Network<W, WIDTH>,
        raw: &[f32],
    ) -> Result<Estimate, PredictError> {
        let mut out = [0.0];
        let coverage = self.predict_by(network, raw, &mut out)?;
        Ok(Estimate { value: out[0], extrapolated: coverage != Coverage::Inside })
    }

    fn scale(&self, raw: &[f32], scaled: &mut [f32]) -> Result<Coverage, PredictError> {
        let mut coverage = Coverage::Inside;
        for (column, (place, &value)) in scaled.iter_mut().zip(raw).enumerate() {
            if !value.is_finite() {
                return Err(PredictError::NotFinite { column });
            }
            *place = self
                .inputs
                .scaled(column, value)
                .ok_or(PredictError::OutOfDomain { column, value })?;
            if coverage == Coverage::Inside && !self.inputs.covers(column, value) {
                coverage = Coverage::Outside { column };
            }
        }
        Ok(coverage)
    }
}

// Raw values in, values in `[-1, 1]` out, and back.

/// Largest number of columns of a [`Scaler`] where no other is asked for.
pub const MAX_IO: usize = 16;

/// What is done to a raw value before it is scaled.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Transform {
    /// Nothing.
    #[default]
    Identity,
    /// Natural logarithm, for positive values that span decades.
    Ln,
}

impl Transform {
    /// The name used in model files and column specs: `identity` or `ln`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Identity => "identity",
            Self::Ln => "ln",
        }
    }

    fn forward(self, raw: f32) -> f32 {
        match self {
            Self::Identity => raw,
            Self::Ln => libm::logf(raw),
        }
    }

    fn inverse(self, transformed: f32) -> f32 {
        match self {
            Self::Identity => transformed,
            Self::Ln => libm::expf(transformed),
        }
    }

    /// Whether `raw` has an image: everything but NaN and the infinities, and only positive values
    /// under [`Ln`](Self::Ln).
    #[must_use]
    pub fn accepts(self, raw: f32) -> bool {
        raw.is_finite() && (self == Self::Identity || raw > 0.0)
    }
}

impl fmt::Display for Transform {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A text that names no transform.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("unknown transform (known: identity, ln)")]
pub struct UnknownTransform;

impl FromStr for Transform {
    type Err = UnknownTransform;

    fn from_str(text: &str) -> Result<Self, UnknownTransform> {
        [Self::Identity, Self::Ln]
            .into_iter()
            .find(|known| known.name() == text)
            .ok_or(UnknownTransform)
    }
}

/// Range of one feature or target over the training rows, in its raw unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Column {
    /// Applied before scaling; `min` and `max` are values before it.
    pub transform: Transform,
    /// Smallest raw value: becomes -1.
    pub min: f32,
    /// Largest raw value: becomes 1. A column with `max == min` is constant and becomes 0.
    pub max: f32,
}

/// Why a column can not be scaled.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum ScaleError {
    /// No columns, or too many.
    #[error("{given} columns: 1 to {limit} are possible")]
    Columns {
        /// Columns given.
        given: usize,
        /// Most columns.
        limit: usize,
    },
    /// The limits are not finite, are exchanged, or differ by more or less than a float can scale.
    #[error("column {column}: {min} to {max} is no range")]
    Limits {
        /// Its place.
        column: usize,
        /// Lower limit.
        min: f32,
        /// Upper limit.
        max: f32,
    },
    /// A logarithmic column that reaches down to zero or below.
    #[error("column {column}: the logarithm needs values above 0, the smallest is {min}")]
    LogOfNonPositive {
        /// Its place.
        column: usize,
        /// Lower limit.
        min: f32,
    },
}

/// One column with what scaling needs worked out: `scaled = (T(raw) - low) * gain - 1`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Axis {
    column: Column,
    low: f32,
    half_span: f32,
    gain: f32,
}

impl Axis {
    const EMPTY: Self = Self {
        column: Column { transform: Transform::Identity, min: 0.0, max: 0.0 },
        low: 0.0,
        half_span: 0.0,
        gain: 0.0,
    };

    fn new(place: usize, column: Column) -> Result<Self, ScaleError> {
        let Column { transform, min, max } = column;
        let limits = ScaleError::Limits { column: place, min, max };
        if !(min.is_finite() && max.is_finite() && min <= max) {
            return Err(limits);
        }
        if !transform.accepts(min) {
            return Err(ScaleError::LogOfNonPositive { column: place, min });
        }
        let low = transform.forward(min);
        let half_span = 0.5 * transform.forward(max) - 0.5 * low;
        if half_span == 0.0 {
            return Ok(Self { column, low, half_span, gain: 0.0 });
        }
        let gain = 1.0 / half_span;
        if !(gain.is_finite() && (2.0 * half_span).is_finite()) {
            return Err(limits);
        }
        Ok(Self { column, low, half_span, gain })
    }

    fn scaled(&self, raw: f32) -> Option<f32> {
        if !self.column.transform.accepts(raw) {
            return None;
        }
        if self.gain == 0.0 {
            return Some(0.0);
        }
        Some((self.column.transform.forward(raw) - self.low) * self.gain - 1.0)
    }

    fn raw(&self, scaled: f32) -> f32 {
        if self.gain == 0.0 {
            return self.column.min;
        }
        self.column.transform.inverse(self.low + (scaled + 1.0) * self.half_span)
    }
}

/// What exports write out.
impl Axis {
    /// Applied before scaling.
    #[must_use]
    pub fn transform(&self) -> Transform {
        self.column.transform
    }

    /// Whether everything is scaled to 0 and comes back as the minimum.
    #[must_use]
    pub fn is_constant(&self) -> bool {
        self.gain == 0.0
    }

    /// Smallest raw value.
    #[must_use]
    pub fn minimum(&self) -> f32 {
        self.column.min
    }

    /// The transformed minimum.
    #[must_use]
    pub fn low(&self) -> f32 {
        self.low
    }

    /// Half of the transformed range; 0 where the column is constant.
    #[must_use]
    pub fn half_span(&self) -> f32 {
        self.half_span
    }

    /// One over [`Axis::half_span`]; 0 where the column is constant.
    #[must_use]
    pub fn gain(&self) -> f32 {
        self.gain
    }
}

/// Linear maps of up to `IO` columns to `[-1, 1]` over the training range.
#[derive(Debug, Clone, PartialEq)]
pub struct Scaler<const IO: usize = MAX_IO> {
    axes: [Axis; IO],
    columns: usize,
}

impl Scaler {
    /// Checks the ranges of `columns`.
    ///
    /// # Errors
    /// The first [`ScaleError`] found.
    pub fn new(columns: &[Column]) -> Result<Self, ScaleError> {
        Self::within(columns)
    }
}

impl<const IO: usize> Scaler<IO> {
    /// As [`Scaler::new`], for up to `IO` columns.
    ///
    /// # Errors
    /// The first [`ScaleError`] found.
    pub fn within(columns: &[Column]) -> Result<Self, ScaleError> {
        if !(1..=IO).contains(&columns.len()) {
            return Err(ScaleError::Columns { given: columns.len(), limit: IO });
        }
        let mut scaler = Self { axes: [Axis::EMPTY; IO], columns: columns.len() };
        for (place, (axis, column)) in scaler.axes.iter_mut().zip(columns).enumerate() {
            *axis = Axis::new(place, *column)?;
        }
        Ok(scaler)
    }

    /// The columns with what scaling needs.
    #[must_use]
    pub fn axes(&self) -> &[Axis] {
        self.axes.get(..self.columns).unwrap_or(&self.axes)
    }

    /// Number of columns.
    #[must_use]
    pub fn len(&self) -> usize {
        self.columns
    }

    /// Never true: a scaler has at least one column.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.columns == 0
    }

    /// The ranges it was made from.
    #[must_use]
    pub fn columns(&self) -> impl ExactSizeIterator<Item = Column> + '_ {
        self.axes().iter().map(|axis| axis.column)
    }

    /// Whether `raw` lies between the training limits of `column`. Outside for NaN and for a column
    /// that does not exist.
    #[must_use]
    pub fn covers(&self, column: usize, raw: f32) -> bool {
        self.axes()
            .get(column)
            .is_some_and(|axis| (axis.column.min..=axis.column.max).contains(&raw))
    }

    /// Scales one raw value; the training range becomes `[-1, 1]`, values beyond it land outside.
    /// `None` when the transform does not accept it or the column does not exist.
    #[must_use]
    pub fn scaled(&self, column: usize, raw: f32) -> Option<f32> {
        self.axes().get(column)?.scaled(raw)
    }

    /// The raw value that [`scaled`](Self::scaled) maps to `scaled`. It may overflow to infinity far
    /// outside `[-1, 1]`. `None` when the column does not exist.
    #[must_use]
    pub fn raw(&self, column: usize, scaled: f32) -> Option<f32> {
        Some(self.axes().get(column)?.raw(scaled))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::activation::Activation;
    use crate::model::{Column, Transform};
    use proptest::prelude::*;

    /// Linear in ln(x0) and x1: scaled target = (scaled x0 + scaled x1) / 2.
    fn mean_model() -> Model<[f32; 3]> {
        let network = Network::new(&[2, 1], &[Activation::Linear], [0.5, 0.5, 0.0]).unwrap();
        let inputs = Scaler::new(&[
            Column { transform: Transform::Ln, min: 0.01, max: 1.0 },
            Column { transform: Transform::Identity, min: -2.0, max: 2.0 },
        ])
        .unwrap();
        let targets =
            Scaler::new(&[Column { transform: Transform::Identity, min: 0.0, max: 10.0 }]).unwrap();
        Model::new(network, inputs, targets).unwrap()
    }

    #[test]
    fn raw_features_give_a_raw_estimate() {
        let estimate = mean_model().estimate(&[0.1, 1.0]).unwrap();
        assert!((estimate.value - 6.25).abs() < 1e-5, "{estimate:?}");
        assert!(!estimate.extrapolated);
    }

    #[test]
    fn extrapolation_is_reported_and_not_clamped() {
        let model = mean_model();
        let mut out = [0.0];
        let coverage = model.predict(&[0.1, 4.0], &mut out).unwrap();
        assert_eq!(coverage, Coverage::Outside { column: 1 });
        assert!((out[0] - 10.0).abs() < 1e-5, "{out:?}");
        assert!(model.estimate(&[2.0, 0.0]).unwrap().extrapolated);
    }

    #[test]
    fn what_can_not_be_predicted_is_an_error() {
        let model = mean_model();
        let estimate = |raw: &[f32]| model.estimate(raw).unwrap_err();
        assert_eq!(estimate(&[f32::NAN, 0.0]), PredictError::NotFinite { column: 0 });
        assert_eq!(estimate(&[0.1, f32::INFINITY]), PredictError::NotFinite { column: 1 });
        assert_eq!(estimate(&[-1.0, 0.0]), PredictError::OutOfDomain { column: 0, value: -1.0 });
        assert_eq!(estimate(&[0.1]), ShapeError::Inputs { needed: 2, given: 1 }.into());
        assert_eq!(estimate(&[0.1, f32::MAX]), PredictError::Overflow { target: 0 });
    }

    #[test]
    fn estimate_wants_a_single_target() {
        let network = Network::new(&[1, 2], &[Activation::Linear], [1.0; 4]).unwrap();
        let column = Column { transform: Transform::Identity, min: 0.0, max: 1.0 };
        let (one, two) = (Scaler::new(&[column]).unwrap(), Scaler::new(&[column; 2]).unwrap());
        let model = Model::new(network.clone(), one.clone(), two).unwrap();
        assert_eq!(model.estimate(&[0.5]), Err(ShapeError::Outputs { needed: 2, given: 1 }.into()));
        assert_eq!(
            Model::new(network, one.clone(), one),
            Err(ShapeError::Outputs { needed: 2, given: 1 })
        );
    }

    proptest! {
        #[test]
        fn finite_weights_and_any_features_give_a_finite_estimate_or_an_error(
            weights in prop::collection::vec(prop::num::f32::NORMAL | prop::num::f32::ZERO, 9),
            raw in prop::collection::vec(prop::num::f32::ANY, 2),
        ) {
            let activations = [Activation::Tanh, Activation::Linear];
            let network = Network::new(&[2, 2, 1], &activations, weights).unwrap();
            let Model { inputs, targets, .. } = mean_model();
            let model = Model::new(network, inputs, targets).unwrap();
            if let Ok(estimate) = model.estimate(&raw) {
                prop_assert!(estimate.value.is_finite());
            }
        }
    }
}

#[cfg(test)]
mod scaler_tests {
    use super::*;
    use proptest::prelude::*;

    fn one(transform: Transform, min: f32, max: f32) -> Result<Scaler, ScaleError> {
        Scaler::new(&[Column { transform, min, max }])
    }

    #[test]
    fn limits_become_minus_one_and_one() {
        for (transform, min, max) in
            [(Transform::Identity, -3.0, 5.0), (Transform::Ln, 0.01_f32, 100.0)]
        {
            let scaler = one(transform, min, max).unwrap();
            assert_eq!(scaler.scaled(0, min), Some(-1.0));
            assert!((scaler.scaled(0, max).unwrap() - 1.0).abs() < 1e-6);
            assert!((scaler.raw(0, -1.0).unwrap() / min - 1.0).abs() < 1e-6);
            assert!((scaler.raw(0, 1.0).unwrap() / max - 1.0).abs() < 1e-6);
        }
        let decades = one(Transform::Ln, 0.01, 100.0).unwrap();
        assert!(decades.scaled(0, 1.0).unwrap().abs() < 1e-6, "the middle of four decades");
    }

    #[test]
    fn a_constant_column_becomes_zero_and_comes_back() {
        for transform in [Transform::Identity, Transform::Ln] {
            let scaler = one(transform, 0.3, 0.3).unwrap();
            assert_eq!(scaler.scaled(0, 17.0), Some(0.0));
            assert_eq!(scaler.raw(0, 0.7), Some(0.3));
            assert!(scaler.covers(0, 0.3) && !scaler.covers(0, 0.31));
        }
    }

    #[test]
    fn the_logarithm_of_what_is_not_positive_is_refused() {
        let scaler = one(Transform::Ln, 0.1, 1.0).unwrap();
        for raw in [0.0, -0.0, -1.0, f32::NAN, f32::INFINITY] {
            assert_eq!(scaler.scaled(0, raw), None, "{raw}");
        }
        assert!(matches!(
            one(Transform::Ln, 0.0, 1.0),
            Err(ScaleError::LogOfNonPositive { column: 0, .. })
        ));
    }

    #[test]
    fn ranges_a_float_can_not_scale_are_refused() {
        for (min, max) in [(1.0, 0.0), (f32::NAN, 1.0), (0.0, f32::INFINITY), (0.0, 1e-44)] {
            let error = one(Transform::Identity, min, max).unwrap_err();
            assert!(matches!(error, ScaleError::Limits { column: 0, .. }), "{min}..{max}: {error}");
        }
        assert!(one(Transform::Identity, f32::MIN, f32::MAX).is_err());
        assert_eq!(Scaler::new(&[]), Err(ScaleError::Columns { given: 0, limit: 16 }));
        let column = Column { transform: Transform::Identity, min: 0.0, max: 1.0 };
        assert_eq!(Scaler::new(&[column; 17]), Err(ScaleError::Columns { given: 17, limit: 16 }));
    }

    proptest! {
        #[test]
        fn scaling_and_back_returns_the_value(
            min in -1e6_f32..1e6,
            span in 1e-3_f32..1e6,
            place in 0.0_f32..1.0,
        ) {
            let max = min + span;
            prop_assume!(max > min);
            let scaler = one(Transform::Identity, min, max).unwrap();
            let raw = min + place * (max - min);
            let back = scaler.raw(0, scaler.scaled(0, raw).unwrap()).unwrap();
            // Two roundings at the size of the span, one at the size of the limits.
            let bound = 4.0 * f32::EPSILON * (min.abs().max(max.abs()) + (max - min));
            prop_assert!((back - raw).abs() <= bound, "{} -> {}", raw, back);
        }

        #[test]
        fn any_value_scales_to_a_number_or_none(
            min in prop::num::f32::ANY,
            max in prop::num::f32::ANY,
            raw in prop::num::f32::ANY,
        ) {
            for transform in [Transform::Identity, Transform::Ln] {
                if let Ok(scaler) = one(transform, min, max) {
                    prop_assert!(scaler.scaled(0, raw).is_none_or(|scaled| !scaled.is_nan()));
                }
            }
        }
    }
}
