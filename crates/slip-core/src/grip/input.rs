//! The input of the controller with each sample, and the names of what it does.

use crate::load::Forecast;

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
    /// What the posterior says of the slip, where there is one.
    pub forecast: Option<Forecast>,
    /// Force that is on its way (N), dead time and lag of the drive (s).
    pub predicted_n: f32,
    /// Dead time of the drive (s).
    pub dead_s: f32,
    /// Its lag (s).
    pub lag_s: f32,
    /// Time for which the force may rise (s), by the clock of the computer; `None` where that is `dt_s`.
    pub rise_s: Option<f32>,
    /// Whether the sample is too old to raise the force on it.
    pub stale: bool,
    /// How late samples arrive of late (s); 0 where that is not known.
    pub late_s: f32,
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
