//! Raw features in, raw targets out, with a word on whether the training data covered them.

use crate::network::{MAX_WIDTH, Network, ShapeError};
use crate::scaler::{MAX_IO, Scaler};

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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::activation::Activation;
    use crate::scaler::{Column, Transform};
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
