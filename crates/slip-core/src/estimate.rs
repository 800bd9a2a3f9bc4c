//! Features of a slip in, the adequate grasp force out: the network with its inputs by name.

use crate::features::{Feature, Features};
use mlp::{Model, PredictError, scaler::MAX_IO};

/// The network's answer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ForceEstimate {
    /// Adequate normal force of one finger (N).
    pub force_n: f32,
    /// Whether a feature lay outside the range the network was trained on.
    pub extrapolated: bool,
}

/// Why a network cannot serve as estimator.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum EstimatorError {
    /// The list of features is not as long as the network's input.
    #[error("the model has {inputs} inputs but {named} features are named")]
    Inputs {
        /// Inputs of the network.
        inputs: usize,
        /// Features named.
        named: usize,
    },
    /// The network has not exactly one output.
    #[error("the model has {outputs} outputs; a force estimate is one number")]
    Outputs {
        /// Outputs of the network.
        outputs: usize,
    },
}

/// Why there is no estimate for a slip.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum NoEstimate {
    /// The slip did not show this feature.
    #[error("the feature {} is missing", .0.name())]
    Missing(Feature),
    /// The network cannot take the values.
    #[error("the model refused the features: {0}")]
    Refused(PredictError),
    /// The network's answer is no force.
    #[error("the model answered {0} N")]
    NotPositive(f32),
}

/// A network whose inputs are features of a slip. `W` holds the weights: `&'static [f32]` in firmware, `Box<[f32]>` on a host.
#[derive(Clone, Debug)]
pub struct Estimator<W> {
    model: Model<W>,
    features: [Feature; MAX_IO],
    inputs: usize,
}

impl<W: AsRef<[f32]>> Estimator<W> {
    /// The estimator that feeds `features`, in this order, into `model`.
    ///
    /// # Errors
    /// Where the numbers of inputs or outputs do not fit.
    pub fn new(model: Model<W>, features: &[Feature]) -> Result<Self, EstimatorError> {
        let (inputs, outputs) = (model.inputs().len(), model.targets().len());
        if inputs != features.len() || inputs > MAX_IO {
            return Err(EstimatorError::Inputs { inputs, named: features.len() });
        }
        if outputs != 1 {
            return Err(EstimatorError::Outputs { outputs });
        }
        let mut order = [Feature::SlipSpeed; MAX_IO];
        for (slot, feature) in order.iter_mut().zip(features) {
            *slot = *feature;
        }
        Ok(Self { model, features: order, inputs })
    }

    /// The force for a slip.
    ///
    /// # Errors
    /// Where a feature is missing, the network cannot take the values, or it answers with anything but a positive force.
    pub fn estimate(&self, features: &Features) -> Result<ForceEstimate, NoEstimate> {
        let mut input = [0.0; MAX_IO];
        for (slot, feature) in input.iter_mut().zip(&self.features).take(self.inputs) {
            *slot = feature.value(features).ok_or(NoEstimate::Missing(*feature))?;
        }
        let input = input.get(..self.inputs).unwrap_or(&[]);
        let answer = self.model.estimate(input).map_err(NoEstimate::Refused)?;
        if answer.value > 0.0 {
            Ok(ForceEstimate { force_n: answer.value, extrapolated: answer.extrapolated })
        } else {
            Err(NoEstimate::NotPositive(answer.value))
        }
    }
}
