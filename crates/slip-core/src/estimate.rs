//! Features of a slip in, the adequate grasp force out: the network with its inputs by name.

use crate::features::{Feature, Features};
use mlp::{Model, PredictError, scaler::MAX_IO};

/// Networks of an ensemble, at most.
pub const MAX_MEMBERS: usize = 4;
/// Friction over weight below which a free fall is not told from a slip.
const LEAST_FRICTION: f32 = 0.05;

/// Acceleration of gravity (m/s^2).
pub const G_M_S2: f32 = 9.806_65;

/// The network's answer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ForceEstimate {
    /// Adequate normal force of one finger (N).
    pub force_n: f32,
    /// Its standard deviation (N): what the models of an ensemble differ by, what they missed by on rows they were not trained on, and the
    /// noise of the travel sensor, each taken as independent of the others.
    pub sigma_n: f32,
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
    /// More networks than an ensemble may have.
    #[error("an ensemble has at most {MAX_MEMBERS} networks")]
    Members,
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
    /// Further networks of an ensemble.
    others: [Option<Model<W>>; MAX_MEMBERS - 1],
    /// Relative deviation of the answers on rows that the networks were not trained on.
    spread: f32,
    features: [Feature; MAX_IO],
    inputs: usize,
    /// Whether the acceleration of the slip is an input.
    accelerated: bool,
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
        let accelerated = features.contains(&Feature::SlipAcceleration);
        let others = core::array::from_fn(|_| None);
        Ok(Self { model, others, spread: 0.0, features: order, inputs, accelerated })
    }

    /// The same with another network of an ensemble; the answer is the mean of all.
    ///
    /// # Errors
    /// Where it has other inputs or outputs than the first one, or [`MAX_MEMBERS`] are there already.
    pub fn with_member(mut self, model: Model<W>) -> Result<Self, EstimatorError> {
        let (inputs, outputs) = (model.inputs().len(), model.targets().len());
        if inputs != self.inputs {
            return Err(EstimatorError::Inputs { inputs, named: self.inputs });
        }
        if outputs != 1 {
            return Err(EstimatorError::Outputs { outputs });
        }
        let free = self.others.iter_mut().find(|place| place.is_none());
        *free.ok_or(EstimatorError::Members)? = Some(model);
        Ok(self)
    }

    /// The same where the answers are known to deviate by this much, relative to the truth; below 0 or not a number counts as 0.
    #[must_use]
    pub fn with_spread(self, spread: f32) -> Self {
        Self { spread: if spread > 0.0 { spread } else { 0.0 }, ..self }
    }

    /// Networks that are asked.
    #[must_use]
    pub fn members(&self) -> usize {
        1 + self.others.iter().flatten().count()
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
        let (mut sum, mut squares, mut count) = (answer.value, 0.0_f32, 1.0_f32);
        for member in self.others.iter().flatten() {
            let other = member.estimate(input).map_err(NoEstimate::Refused)?.value - answer.value;
            sum += answer.value + other;
            squares += other * other;
            count += 1.0;
        }
        let force_n = sum / count;
        if force_n > 0.0 {
            let off = force_n - answer.value;
            let between = (squares / count - off * off).max(0.0);
            let relative = squared(self.spread) + squared(self.noise(features));
            let sigma_n = libm::sqrtf(between + squared(force_n) * relative);
            Ok(ForceEstimate { force_n, sigma_n, extrapolated: answer.extrapolated })
        } else {
            Err(NoEstimate::NotPositive(force_n))
        }
    }

    /// Relative deviation of the answer by the noise of the acceleration: the force is F / (1 - a/g).
    fn noise(&self, features: &Features) -> f32 {
        let sigma = features.slip_acceleration_sigma_m_s2.filter(|_| self.accelerated);
        let left = (G_M_S2 - features.slip_acceleration_m_s2).max(LEAST_FRICTION * G_M_S2);
        sigma.map_or(0.0, |sigma| sigma / left)
    }
}

fn squared(x: f32) -> f32 {
    x * x
}
