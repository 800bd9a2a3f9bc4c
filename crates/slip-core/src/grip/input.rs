//! The input of the controller with each sample, and the names of what it does.

use crate::{
    course::{Motion, Passing},
    estimate::ForceEstimate,
    need::Felt,
};

/// A slip as the controller sees it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SlipNow {
    /// There is none.
    #[default]
    No,
    /// The signal is back below the threshold, the release time runs.
    Fading,
    /// The signal is above the threshold.
    Evident,
}

/// How the object slid over the last milliseconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sliding {
    /// Mean normal force of one finger (N).
    pub force_n: f32,
    /// Acceleration over that of gravity.
    pub acceleration_g: f32,
}

/// What the controller is given with each sample.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[expect(clippy::struct_excessive_bools, reason = "states of sensors that change one by one")]
pub struct GripInput {
    /// Time since the sample before (s).
    pub dt_s: f32,
    /// The slip as of this sample.
    pub slip: SlipNow,
    /// Distance moved since the slip began (m); `None` where no sensor shows.
    pub moved_m: Option<f32>,
    /// A new estimate of the force that is needed, one that may move the fingers.
    pub estimate: Option<ForceEstimate>,
    /// How the object slides, where the moved distance shows it.
    pub sliding: Option<Sliding>,
    /// How the object moved over the last milliseconds, by a coarse but robust measure; `None` where the moved distance is not measured.
    pub motion: Option<Motion>,
    /// What the stylus shows of the needed force; `None` where another sensor shows how the object moves.
    pub felt: Option<Felt>,
    /// Peaks and valleys that the stylus passes; `None` where they cannot be counted.
    pub passing: Option<Passing>,
    /// Deviation of one reading of the moved distance (m).
    pub travel_sigma_m: f32,
    /// Whether the stylus shows a slip that the moved distance, good so far, does not confirm.
    pub undecided: bool,
    /// Force (N) from which on only the moved distance shows the slip, until it is known whether that answers to the force.
    pub alone_n: Option<f32>,
    /// Whether it did not: what it shows is no movement.
    pub drifts: bool,
    /// Time for which the force may rise (s), by the clock of the computer; `None` where that is `dt_s`.
    pub rise_s: Option<f32>,
    /// Whether the sample is too old to raise the force on it.
    pub stale: bool,
    /// How old this sample was when it arrived (s); 0 where that is not known.
    pub age_s: f32,
    /// Whether the moved distance is measured.
    pub travel: bool,
    /// Measured normal force (N).
    pub applied_n: Option<f32>,
    /// Whether the fingers touch anything, as far as that is measured; always where it is not.
    pub touching: bool,
    /// Measured normal force that counts as touch (N), for the noise of this sensor; 0 where it is not measured.
    pub touch_n: f32,
    /// Whether any slip sensor is usable.
    pub healthy: bool,
    /// The force that the load on the fingers needs (N), where no slip sensor is usable and the tangential force shows it.
    pub loaded_n: Option<f32>,
    /// Whether a slip sensor is not: then no less is held.
    pub impaired: bool,
}

/// How an object was tried until it was held.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Trials {
    /// Forces that were tried: the trial force and one for each slip that was answered.
    pub trials: u32,
    /// What the object moved while slips were answered (m), as far as that is measured.
    pub moved_m: f32,
}
