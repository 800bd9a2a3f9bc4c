//! Features of a slip in, the adequate grasp force out: the network with its inputs by name.

pub mod friction;

use crate::features::{Feature, Features};
use mlp_core::{Model, Network, PredictError, scaler::MAX_IO};

/// Networks of an ensemble, at most.
pub const MAX_MEMBERS: usize = 4;
/// Friction over weight below which a free fall is not told from a slip.
const LEAST_FRICTION: f32 = 0.05;

/// An estimate with a larger deviation than this share of itself is no measure: whether it is a third too much or too little is not known.
const MOST_UNSURE: f32 = 0.5;

/// Adequate over needed force, as the networks were trained.
pub const KAPPA: f32 = 1.2;

/// Acceleration of gravity (m/s^2).
pub const G_M_S2: f32 = 9.806_65;

/// The network's answer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ForceEstimate {
    /// Adequate normal force of one finger (N).
    pub force_n: f32,
    /// Its standard deviation (N): what the networks of an ensemble differ by, what they missed by on rows they were not trained on, and the
    /// noise of the sensor of travel or speed, each taken as independent of the others.
    pub sigma_n: f32,
    /// Whether a feature lay outside the range the network was trained on.
    pub extrapolated: bool,
}

impl ForceEstimate {
    /// Whether it may move the fingers: made within the range that the network knows, with a deviation of at most half of itself. What may not is
    /// shown all the same.
    #[must_use]
    pub fn is_trusted(&self) -> bool {
        !self.extrapolated && self.sigma_n <= MOST_UNSURE * self.force_n
    }
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
    /// A network of an ensemble with other ranges than the first one.
    #[error("the networks of an ensemble have different ranges")]
    Ranges,
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
    /// Further networks of an ensemble, behind the same ranges.
    others: [Option<Network<W>>; MAX_MEMBERS - 1],
    /// Deviation of the answers on rows that the networks were not trained on: a share of them, and in newtons.
    relative: f32,
    absolute_n: f32,
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
        let (relative, absolute_n) = (0.0, 0.0);
        Ok(Self { model, others, relative, absolute_n, features: order, inputs, accelerated })
    }

    /// The same with the network of `model` as another one of an ensemble; the answer is the mean of all.
    ///
    /// # Errors
    /// Where it has other ranges than the first one, or [`MAX_MEMBERS`] are there already.
    pub fn with_member(mut self, model: Model<W>) -> Result<Self, EstimatorError> {
        if model.inputs() != self.model.inputs() || model.targets() != self.model.targets() {
            return Err(EstimatorError::Ranges);
        }
        let free = self.others.iter_mut().find(|place| place.is_none());
        *free.ok_or(EstimatorError::Members)? = Some(model.into_network());
        Ok(self)
    }

    /// The same where answers are known to be off by this share of them and by this many newtons (one standard deviation each); what is below
    /// 0 or not a number counts as 0.
    #[must_use]
    pub fn with_deviation(self, relative: f32, absolute_n: f32) -> Self {
        Self { relative: relative.max(0.0), absolute_n: absolute_n.max(0.0), ..self }
    }

    /// Whether its answers are sure enough on the whole to move the fingers; see [`ForceEstimate::is_trusted`].
    #[must_use]
    pub fn is_trustworthy(&self) -> bool {
        self.relative <= MOST_UNSURE
    }

    /// What answers are known to be off by: a share of them, and newtons.
    #[must_use]
    pub fn deviation(&self) -> (f32, f32) {
        (self.relative, self.absolute_n)
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
        let (mut off, mut squares, mut others) = (0.0_f32, 0.0_f32, 0.0_f32);
        for member in self.others.iter().flatten() {
            let other = self.model.estimate_by(member, input).map_err(NoEstimate::Refused)?;
            let apart = other.value - answer.value;
            off += apart;
            squares += apart * apart;
            others += 1.0;
        }
        let force_n = answer.value + off / (1.0 + others);
        if force_n > 0.0 {
            // About the mean, of as many less one.
            let between = (squares - off * off / (1.0 + others)).max(0.0) / others.max(1.0);
            let relative = squared(self.relative) + squared(self.noise(features));
            let variance = between + squared(force_n) * relative + squared(self.absolute_n);
            let sigma_n = libm::sqrtf(variance);
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

#[cfg(test)]
mod tests;
