//! Model from raw features to raw targets; reports whether the training data covered the features.

use crate::activation::Number;
use crate::network::{MAX_WIDTH, Network, ShapeError};

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
    /// A logarithmic or reciprocal feature is zero or negative.
    #[error("feature {column} is {value}: its logarithm or reciprocal needs a value above 0")]
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
        let (needed, given) = (network.inputs(), inputs.axes().len());
        if needed != given {
            return Err(ShapeError::Inputs { needed, given });
        }
        let (needed, given) = (network.outputs(), targets.axes().len());
        if needed != given {
            return Err(ShapeError::Outputs { needed, given });
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
    /// Any [`PredictError`]; `out` is then not written, except for [`PredictError::Overflow`], where it
    /// holds nothing of use.
    pub fn predict(&self, raw: &[f32], out: &mut [f32]) -> Result<Coverage, PredictError> {
        self.predict_by(&self.network, raw, out)
    }

    fn predict_by(
        &self,
        network: &Network<W, WIDTH>,
        raw: &[f32],
        out: &mut [f32],
    ) -> Result<Coverage, PredictError> {
        self.check_lengths(raw.len(), out.len())?;
        let mut scaled = [0.0_f32; IO];
        let one = |axis: &Axis, value| (axis.scaled(value), axis.covers(value));
        let coverage = self.scale(raw, &mut scaled, |value| value, one)?;
        network.forward(scaled.get(..raw.len()).unwrap_or(&[]), out)?;
        for (target, (place, axis)) in out.iter_mut().zip(self.targets.axes()).enumerate() {
            *place = axis.raw(*place);
            if !place.is_finite() {
                return Err(PredictError::Overflow { target });
            }
        }
        Ok(coverage)
    }

    /// [`Model::predict`] for rows in double precision: features are scaled before they are rounded to `f32`, answers after, so
    /// that a column may be large against its range (a pressure in Pa, ticks, an epoch).
    ///
    /// # Errors
    /// As [`Model::predict`].
    pub fn predict_double(&self, raw: &[f64], out: &mut [f64]) -> Result<Coverage, PredictError> {
        self.check_lengths(raw.len(), out.len())?;
        let mut scaled = [0.0_f32; IO];
        let one = |axis: &Axis, value| (axis.column.scaled(value), axis.column.covers(value));
        let coverage = self.scale(raw, &mut scaled, rounded, one)?;
        let mut outputs = [0.0_f32; WIDTH];
        let (scaled, answers) = (scaled.get(..raw.len()), outputs.get_mut(..out.len()));
        self.network.forward(scaled.unwrap_or(&[]), answers.unwrap_or(&mut []))?;
        let places = out.iter_mut().zip(outputs).zip(self.targets.axes());
        for (target, ((place, output), axis)) in places.enumerate() {
            *place = axis.column.raw(output.into());
            if !rounded(*place).is_finite() {
                return Err(PredictError::Overflow { target });
            }
        }
        Ok(coverage)
    }

    fn check_lengths(&self, raw: usize, out: usize) -> Result<(), ShapeError> {
        let (inputs, targets) = (self.inputs.axes().len(), self.targets.axes().len());
        if raw != inputs {
            return Err(ShapeError::Inputs { needed: inputs, given: raw });
        }
        if out != targets {
            return Err(ShapeError::Outputs { needed: targets, given: out });
        }
        Ok(())
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

    /// `one` scales a value and states whether it lies in its range.
    fn scale<N: Number>(
        &self,
        raw: &[N],
        scaled: &mut [f32],
        single: impl Fn(N) -> f32,
        one: impl Fn(&Axis, N) -> (Option<f32>, bool),
    ) -> Result<Coverage, PredictError> {
        let mut coverage = Coverage::Inside;
        let places = scaled.iter_mut().zip(raw).zip(self.inputs.axes());
        for (column, ((place, &raw), axis)) in places.enumerate() {
            let value = single(raw);
            if !value.is_finite() {
                return Err(PredictError::NotFinite { column });
            }
            let (at, covered) = one(axis, raw);
            *place = at.ok_or(PredictError::OutOfDomain { column, value })?;
            if coverage == Coverage::Inside && !covered {
                coverage = Coverage::Outside { column };
            }
        }
        Ok(coverage)
    }
}

// Scaler of raw values to values in `[-1, 1]`, and back.

/// Largest number of columns of a [`Scaler`] where no other is asked for.
pub const MAX_IO: usize = 16;

/// Nearest `f32`; what is too large becomes infinite and is caught where finite values are required.
#[must_use]
#[expect(
    clippy::cast_possible_truncation,
    reason = "rounding to the precision of the model is meant"
)]
pub fn rounded(value: f64) -> f32 {
    value as f32
}

crate::named! {
    "transform",
    /// What is done to a raw value before it is scaled: the powers 1, 0 and -1 of Box and Cox, but for constants. Others would need `pow`.
    #[derive(Default)]
    #[cfg_attr(feature = "file", derive(serde::Serialize, serde::Deserialize))]
    #[cfg_attr(feature = "file", serde(rename_all = "lowercase"))]
    pub enum Transform {
        /// Nothing.
        #[default]
        Identity = "identity",
        /// Natural logarithm, for positive values that span decades.
        Ln = "ln",
        /// `-1 / value`, for positive values whose noise grows with their square, such as a force `F / (1 - a/g)` by a noisy `a`.
        ///
        /// The way back knows the noise: if 1 / value is normal about `u` with the deviation `s`, the answer of least relative error,
        /// `E[1/value] / E[1/value^2]`, is `u / (u^2 + s^2)`. It is greatest at `u = s` and stays there below.
        Reciprocal = "reciprocal",
    }
}

impl Transform {
    /// What becomes of a raw value; not finite where it is not [accepted](Self::accepts).
    #[must_use]
    pub fn forward<N: Number>(self, raw: N) -> N {
        match self {
            Self::Identity => raw,
            Self::Ln => raw.ln(),
            Self::Reciprocal => -N::ONE / raw,
        }
    }

    /// By how much the transformed value grows with the raw one, there.
    #[must_use]
    pub fn slope(self, raw: f64) -> f64 {
        match self {
            Self::Identity => 1.0,
            Self::Ln => 1.0 / raw,
            Self::Reciprocal => 1.0 / (raw * raw),
        }
    }

    /// [`Transform::forward`] back, of a value with this deviation; not finite where a reciprocal without noise is not negative.
    #[must_use]
    pub fn inverse<N: Number>(self, transformed: N, noise: f32) -> N {
        match self {
            Self::Identity => transformed,
            Self::Ln => transformed.exp(),
            Self::Reciprocal => {
                let noise = N::from_single(noise);
                let most = if transformed > -noise { -noise } else { transformed };
                -N::ONE / (most + noise * (noise / most))
            }
        }
    }

    /// Whether errors are shares of the value rather than of one size.
    #[must_use]
    pub fn is_relative(self) -> bool {
        self != Self::Identity
    }

    /// Whether `raw` has an image: everything but NaN and the infinities, and only positive values
    /// under all but [`Identity`](Self::Identity).
    #[must_use]
    pub fn accepts(self, raw: f32) -> bool {
        raw.is_finite() && (self == Self::Identity || raw > 0.0)
    }
}

/// Range of one feature or target over the training rows, in its raw unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Column {
    /// Applied before scaling; `min` and `max` are values before it.
    pub transform: Transform,
    /// Smallest raw value: becomes -1.
    pub min: f64,
    /// Largest raw value: becomes 1. A column with `max == min` is constant and becomes 0.
    pub max: f64,
    /// Deviation of the noise of a transformed target, 0 where it is not known: a reciprocal answers by it.
    pub noise: f32,
}

impl Column {
    /// A column without known noise.
    #[must_use]
    pub const fn new(transform: Transform, min: f64, max: f64) -> Self {
        Self { transform, min, max, noise: 0.0 }
    }

    /// Whether the limits differ, but not as `f32`: rows in `f64` are scaled, samples in `f32` and exports see a constant.
    #[must_use]
    pub fn is_constant_in_single(&self) -> bool {
        self.min < self.max && rounded(self.min) == rounded(self.max)
    }

    fn low_and_half_span(&self) -> (f64, f64) {
        let low = self.transform.forward(self.min);
        (low, 0.5 * self.transform.forward(self.max) - 0.5 * low)
    }

    /// `raw` scaled in double precision, then rounded.
    fn scaled(&self, raw: f64) -> Option<f32> {
        let (low, half_span) = self.low_and_half_span();
        match self.transform {
            Transform::Ln | Transform::Reciprocal if raw <= 0.0 => None,
            _ if half_span == 0.0 => Some(0.0),
            _ => Some(rounded((self.transform.forward(raw) - low) / half_span - 1.0)),
        }
    }

    /// The raw value of a scaled one.
    #[must_use]
    pub fn raw(&self, scaled: f64) -> f64 {
        let (low, half_span) = self.low_and_half_span();
        match half_span == 0.0 {
            true => self.min,
            false => self.transform.inverse(low + (scaled + 1.0) * half_span, self.noise),
        }
    }

    /// Limits of files before this precision are rounded to `f32`: a millionth of the range is no excess.
    fn covers(&self, raw: f64) -> bool {
        let slack = 1e-6 * (self.max - self.min);
        (rounded(self.min)..=rounded(self.max)).contains(&rounded(raw))
            && (self.min - slack..=self.max + slack).contains(&raw)
    }
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
        min: f64,
        /// Upper limit.
        max: f64,
    },
    /// A noise that is no deviation.
    #[error("column {column}: its noise is {noise}: it must be 0 or a positive number")]
    Noise {
        /// Its place.
        column: usize,
        /// The noise given.
        noise: f32,
    },
    /// A logarithmic or reciprocal column that reaches down to zero or below.
    #[error("column {column}: logarithm and reciprocal need values above 0, the smallest is {min}")]
    LogOfNonPositive {
        /// Its place.
        column: usize,
        /// Lower limit.
        min: f64,
    },
}

/// One column with what scaling needs worked out: `scaled = (T(raw) - low) * gain - 1`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Axis {
    /// The column as it was given.
    pub column: Column,
    /// The transformed minimum.
    pub low: f32,
    /// Half of the transformed range; 0 where the column is constant.
    pub half_span: f32,
    /// One over it; 0 where the column is constant.
    pub gain: f32,
}

impl Axis {
    const EMPTY: Self = Self {
        column: Column::new(Transform::Identity, 0.0, 0.0),
        low: 0.0,
        half_span: 0.0,
        gain: 0.0,
    };

    fn new(place: usize, column: Column) -> Result<Self, ScaleError> {
        let Column { transform, min, max, noise } = column;
        let limits = ScaleError::Limits { column: place, min, max };
        let (low, high) = (rounded(min), rounded(max));
        if !(low.is_finite() && high.is_finite() && min <= max) {
            return Err(limits);
        }
        if !(noise >= 0.0 && noise.is_finite()) {
            return Err(ScaleError::Noise { column: place, noise });
        }
        if !transform.accepts(low) {
            return Err(ScaleError::LogOfNonPositive { column: place, min });
        }
        let low = transform.forward(low);
        let half_span = 0.5 * transform.forward(high) - 0.5 * low;
        if half_span == 0.0 {
            return Ok(Self { column, low, half_span, gain: 0.0 });
        }
        let gain = 1.0 / half_span;
        if !(gain.is_finite() && (2.0 * half_span).is_finite()) {
            return Err(limits);
        }
        Ok(Self { column, low, half_span, gain })
    }

    /// Smallest raw value.
    #[must_use]
    pub fn minimum(&self) -> f32 {
        rounded(self.column.min)
    }

    /// Whether everything is scaled to 0 and comes back as the minimum.
    #[must_use]
    pub fn is_constant(&self) -> bool {
        self.gain == 0.0
    }

    /// Whether `raw` lies between the training limits. NaN does not.
    #[must_use]
    pub fn covers(&self, raw: f32) -> bool {
        (self.minimum()..=rounded(self.column.max)).contains(&raw)
    }

    /// Scales one raw value; the training range becomes `[-1, 1]`, values beyond it land outside. `None` when the transform does
    /// not accept it.
    #[must_use]
    pub fn scaled(&self, raw: f32) -> Option<f32> {
        if !self.column.transform.accepts(raw) {
            return None;
        }
        if self.is_constant() {
            return Some(0.0);
        }
        Some((self.column.transform.forward(raw) - self.low) * self.gain - 1.0)
    }

    /// The raw value that [`scaled`](Self::scaled) maps to `scaled`. It may overflow to infinity far outside `[-1, 1]`.
    #[must_use]
    pub fn raw(&self, scaled: f32) -> f32 {
        if self.is_constant() {
            return self.minimum();
        }
        let transformed = self.low + (scaled + 1.0) * self.half_span;
        self.column.transform.inverse(transformed, self.column.noise)
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

    /// The ranges it was made from.
    #[must_use]
    pub fn columns(&self) -> impl ExactSizeIterator<Item = Column> + '_ {
        self.axes().iter().map(|axis| axis.column)
    }
}

#[cfg(test)]
mod tests;
