//! Estimator of the adequate grasp force from features of a slip: the network with its inputs by name, and the formula.

use crate::esc::Esc;
use mlp_core::{Model, Network, PredictError, model::MAX_IO};

/// Networks of an ensemble, at most.
pub const MAX_MEMBERS: usize = 4;
/// Friction over weight below which a free fall is not distinguished from a slip.
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
    /// Its standard deviation in the physics that the network was trained on (N), which the margin covers: what the networks of an ensemble
    /// differ by, what they missed by on rows they were not trained on, and the noise of the sensor of travel or speed, each taken as independent.
    pub sigma_n: f32,
    /// The interval that the model states, widened by the noise of that sensor (N): for the built-in one of 90 %, also in other physics. It moves
    /// nothing. `None` where the model states none, and beyond the range that it knows.
    pub limits_n: Option<[f32; 2]>,
    /// Whether a feature lay outside the range the network was trained on.
    pub extrapolated: bool,
}

impl ForceEstimate {
    /// A force (N) with its deviation (N) as all that is known of its error.
    #[must_use]
    pub const fn new(force_n: f32, sigma_n: f32) -> Self {
        Self { force_n, sigma_n, limits_n: None, extrapolated: false }
    }

    /// Whether it may move the fingers: made within the range that the network knows, with a deviation of at most half of itself. What may not
    /// is shown all the same.
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
    /// How far the truth may be from an answer within the stated interval, and how many deviations of the sensor's noise that is.
    interval: Option<(Reach, f32)>,
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
        let (inputs, outputs) = (model.inputs().axes().len(), model.targets().axes().len());
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
        let (relative, absolute_n, interval, features) = (0.0, 0.0, None, order);
        Ok(Self { model, others, relative, absolute_n, interval, features, inputs, accelerated })
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

    /// The same with an interval: `width` is taken off the answer and added to it (N), or divides and multiplies it where the target is
    /// logarithmic; `sigmas` deviations of the sensor's noise widen it, as many as hold the same share of a bell curve. It is stated and moves nothing: a
    /// margin for it would raise every force. A width that is no width states nothing.
    #[must_use]
    pub fn with_interval(self, width: f32, sigmas: f32) -> Self {
        let reach = match self.model.targets().columns().next().map(|column| column.transform) {
            Some(transform) if transform.is_relative() => Reach::Logarithm(libm::logf(width)),
            _ => Reach::Newtons(width),
        };
        let (Reach::Logarithm(size) | Reach::Newtons(size)) = reach;
        let known = size >= 0.0 && size.is_finite() && sigmas >= 0.0;
        Self { interval: known.then_some((reach, sigmas)), ..self }
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
            let (noise, extrapolated) = (self.noise(features), answer.extrapolated);
            let relative = squared(self.relative) + squared(noise);
            let variance = between + squared(force_n) * relative + squared(self.absolute_n);
            let known = self.interval.filter(|_| !extrapolated);
            let limits_n = known.map(|(reach, sigmas)| reach.around(force_n, sigmas * noise));
            Ok(ForceEstimate { force_n, sigma_n: libm::sqrtf(variance), limits_n, extrapolated })
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

/// How far the truth may be from an answer.
#[derive(Clone, Copy, Debug)]
enum Reach {
    /// As a logarithm of the force.
    Logarithm(f32),
    /// In newtons.
    Newtons(f32),
}

impl Reach {
    /// The limits around `force_n` (N) where a sensor adds `noise` of it, taken as independent.
    fn around(self, force_n: f32, noise: f32) -> [f32; 2] {
        match self {
            Self::Logarithm(size) => {
                let factor = libm::expf(libm::hypotf(size, noise));
                [force_n / factor, force_n * factor]
            }
            Self::Newtons(size) => {
                let size_n = libm::hypotf(size, noise * force_n);
                [(force_n - size_n).max(0.0), force_n + size_n]
            }
        }
    }
}

fn squared(x: f32) -> f32 {
    x * x
}

// What a slip shows, in the names and units the network was trained with.

/// The measured properties of a slip that is going on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Features {
    /// Slip speed v (m/s).
    pub slip_speed_m_s: f32,
    /// Length of the stretch the other figures were taken over (s).
    pub contact_time_s: f32,
    /// Mean slip acceleration over that stretch (m/s^2); negative while friction wins.
    pub slip_acceleration_m_s2: f32,
    /// Standard deviation of that acceleration by the noise of what measures travel or speed (m/s^2); `None` where the speed is configured.
    pub slip_acceleration_sigma_m_s2: Option<f32>,
    /// Distance moved since the slip was noticed (m).
    pub micro_displacement_m: f32,
    /// Mean normal force of one finger over the stretch, the trial force F (N).
    pub trial_force_n: f32,
    /// Irregularities the stylus passed since the slip was noticed.
    pub irregularities: u32,
    /// Mean of delta/s over these.
    pub mean_slope: Option<f32>,
    /// E_sc as printed, with its figures of trust.
    pub esc: Option<Esc>,
    /// The chosen reading of E_sc; the same as `esc` unless another one was asked for.
    pub esc_chosen: Option<Esc>,
}

slip_msg::named! {
    /// A feature by name: what a model file may ask for.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum Feature {
        fn name: "Its name in model files and training data.";
    }
    SlipSpeed: "`slip_speed_m_s`", "slip_speed_m_s";
    ContactTime: "`contact_time_s`", "contact_time_s";
    SlipAcceleration: "`slip_acceleration_m_s2`", "slip_acceleration_m_s2";
    MicroDisplacement: "`micro_displacement_m`", "micro_displacement_m";
    TrialForce: "`trial_force_n`", "trial_force_n";
    Irregularities: "`irregularities`", "irregularities";
    MeanSlope: "`mean_slope`", "mean_slope";
    EscLiteral: "`esc_literal_w`", "esc_literal_w";
}

impl Feature {
    /// The feature of that name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|feature| feature.name() == name)
    }

    /// Its value in `features`; `None` where the slip did not show it (yet).
    #[must_use]
    pub fn value(self, features: &Features) -> Option<f32> {
        match self {
            Self::SlipSpeed => Some(features.slip_speed_m_s),
            Self::ContactTime => Some(features.contact_time_s),
            Self::SlipAcceleration => Some(features.slip_acceleration_m_s2),
            Self::MicroDisplacement => Some(features.micro_displacement_m),
            Self::TrialForce => Some(features.trial_force_n),
            Self::Irregularities => Some(features.irregularities as f32),
            Self::MeanSlope => features.mean_slope,
            #[expect(clippy::cast_possible_truncation, reason = "a network input is f32")]
            Self::EscLiteral => features.esc.map(|esc| esc.value as f32),
        }
    }
}

// Friction meter: the force that is adequate, from tangential and normal force of a slip.

/// Blocks that are averaged, and compared, the first with the last.
const BLOCKS: usize = 4;
/// Blocks in which a ratio that is too large fades to 1/e of what it is too large by: where the present one may be that of sliding, and where it is
/// below [`SLIDING`] of it.
const FADE_BLOCKS: [f32; 2] = [10.0, 60.0];
/// Friction of sliding over that at break-away is hardly below this.
const SLIDING: f32 = 0.8;
/// Growth of the normal force over the blocks (relative) from which it shows whether the object stands: the tangential force then grows by less than
/// the stated share of that.
const GROWTH: f32 = 0.03;
const STANDS: f32 = 0.35;
/// Deviation of mu (relative): where between static and kinetic friction the largest ratio lies.
const MU_SIGMA: f32 = 0.1;
/// Forces below this (N) show nothing.
const LEAST_N: f32 = 0.05;

/// Means over a block.
#[derive(Clone, Copy, Debug, Default)]
struct Block {
    normal_n: f32,
    tangential_n: f32,
}

/// Friction and load of one slip; O(1) state and cost.
///
/// The tangential force of a finger is `F_t = mu F` while the object slides, and half of the load once it stands, whatever F is. So
///
/// ```text
/// f = kappa F_t / mu,    mu = the largest F_t / F of this slip
/// ```
///
/// is kappa times the force there is while the object slides, which is not yet enough, and kappa times what the load needs once it stands. The
/// largest ratio is friction itself where the object slid, and less than that where it never did: then more force follows, never less. A wrong
/// scale of the tangential sensor cancels. [`KAPPA`] is that of the networks.
///
/// Friction at break-away is above that of sliding (by a fifth at most in the scenes), and a contact may get wet. So the largest ratio fades
/// towards the present one with `FADE_BLOCKS`, while a stylus feels the slip and F_t does not show that the object stands: where it does, F grows and
/// F_t takes no part in it.
///
/// Forces are means over blocks of a millisecond, taken over four of them: the estimate is 2 ms old.
#[derive(Clone, Copy, Debug)]
pub struct FrictionMeter {
    per_block: u32,
    sum: Block,
    count: u32,
    /// The last blocks, oldest first.
    blocks: [Block; BLOCKS],
    filled: usize,
    /// Means over the blocks; none where they show nothing.
    mean: Option<Block>,
    /// 0 before there is any.
    mu: f32,
    /// That of the slips before, of the same object.
    known: f32,
}

impl FrictionMeter {
    /// A meter for samples at `rate_hz`.
    #[must_use]
    pub fn new(rate_hz: f32) -> Self {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "clamped; the cast saturates"
        )]
        let per_block = (1e-3 * rate_hz).clamp(1.0, 1e6) as u32;
        Self {
            per_block,
            sum: Block::default(),
            count: 0,
            blocks: [Block::default(); BLOCKS],
            filled: 0,
            mean: None,
            mu: 0.0,
            known: 0.0,
        }
    }

    /// A slip begins with the next sample.
    pub fn begin(&mut self) {
        let (per_block, known) = (self.per_block, if self.mu > 0.0 { self.mu } else { self.known });
        *self = Self { per_block, known, ..Self::new(0.0) };
    }

    /// Another object is taken: nothing is known of its friction.
    pub fn prime(&mut self) {
        self.begin();
        self.known = 0.0;
    }

    /// Takes the forces of the next sample (N, finite) without a slip sensor: the load is followed, the friction stays.
    #[inline]
    pub fn watch(&mut self, normal_n: f32, tangential_n: f32) {
        self.add(normal_n, tangential_n);
        if self.count >= self.per_block {
            self.close_block();
        }
    }

    /// The force that is adequate for the load that was watched, by the friction of the last slips of this object; `None` where no slip has shown it.
    #[must_use]
    pub fn loaded_n(&self) -> Option<f32> {
        let mu = if self.mu > 0.0 { self.mu } else { self.known };
        let force_n = KAPPA * self.mean?.tangential_n / mu;
        (mu > 0.0 && force_n.is_finite()).then_some(force_n)
    }

    /// Takes the forces of the next sample of the slip (N, finite), and whether the slip is felt right now. The sign of the tangential force depends
    /// on how its sensor is mounted.
    #[inline]
    pub fn push(&mut self, normal_n: f32, tangential_n: f32, felt: bool) {
        self.add(normal_n, tangential_n);
        if self.count >= self.per_block {
            self.close_block();
            if let Some(mean) = self.mean {
                self.learn(mean.tangential_n / mean.normal_n, felt);
            }
        }
    }

    #[inline]
    fn add(&mut self, normal_n: f32, tangential_n: f32) {
        self.sum.normal_n += normal_n;
        self.sum.tangential_n += tangential_n;
        self.count += 1;
    }

    fn close_block(&mut self) {
        let share = 1.0 / self.count as f32;
        let block = Block {
            normal_n: share * self.sum.normal_n,
            tangential_n: (share * self.sum.tangential_n).abs(),
        };
        (self.sum, self.count) = (Block::default(), 0);
        self.blocks.rotate_left(1);
        self.blocks[BLOCKS - 1] = block;
        self.filled = (self.filled + 1).min(BLOCKS);
        self.mean = self.usable_mean();
    }

    /// Takes the ratio of the last blocks.
    fn learn(&mut self, ratio: f32, felt: bool) {
        if ratio > self.mu {
            self.mu = ratio;
        } else if felt && !self.stands() {
            let [near, far] = FADE_BLOCKS;
            let blocks = if ratio > SLIDING * self.mu { near } else { far };
            self.mu += (ratio - self.mu) / blocks;
        }
    }

    /// Not of a sensor that shows the same for all of them: nothing that is alive does.
    fn usable_mean(&self) -> Option<Block> {
        let sum = |part: fn(&Block) -> f32| self.blocks.iter().map(part).sum::<f32>();
        let mean = Block {
            normal_n: 0.25 * sum(|block| block.normal_n),
            tangential_n: 0.25 * sum(|block| block.tangential_n),
        };
        let enough = mean.normal_n >= LEAST_N && mean.tangential_n >= LEAST_N;
        let [first, others @ ..] = self.blocks;
        let alive = others.iter().any(|block| block.tangential_n != first.tangential_n);
        (self.filled == BLOCKS && enough && alive).then_some(mean)
    }

    /// Whether the normal force has just grown alone.
    fn stands(&self) -> bool {
        let [first, .., last] = self.blocks;
        let grown = last.normal_n - first.normal_n;
        let followed = last.tangential_n - first.tangential_n;
        grown > GROWTH * first.normal_n
            && followed * first.normal_n < STANDS * grown * first.tangential_n
    }

    /// What is known of the friction of this slip; `None` before there is anything.
    #[must_use]
    pub fn friction(&self) -> Option<f32> {
        (self.mu > 0.0).then_some(self.mu)
    }

    /// The adequate force for the load so far; `None` before the forces state anything.
    #[must_use]
    pub fn estimate(&self) -> Option<ForceEstimate> {
        let force_n = KAPPA * self.mean?.tangential_n / self.friction()?;
        force_n.is_finite().then_some(ForceEstimate::new(force_n, MU_SIGMA * force_n))
    }
}

#[cfg(test)]
mod tests;

#[cfg(test)]
mod features_tests {
    use super::Feature;

    #[test]
    fn names_lead_back_to_their_feature() {
        for feature in Feature::ALL {
            assert_eq!(Feature::from_name(feature.name()), Some(feature));
        }
        assert_eq!(Feature::from_name("slip_speed"), None);
    }
}

#[cfg(test)]
mod friction_tests;
