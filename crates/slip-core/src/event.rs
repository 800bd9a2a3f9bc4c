//! What the pipeline has to say about a sample.

use crate::{
    causes::Causes,
    detector::{FloorHealth, ReferenceHealth},
    distance::TravelHealth,
    estimate::ForceEstimate,
    features::Features,
    grip::GripEvent,
    health::Health,
    methods::Method,
    pressure::PressureHealth,
    scene::Scene,
    units::{Micros, Newtons},
    velocity::Velocity,
};

/// How far a slip has gone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// Shear and first movements, before the object slides.
    Incipient,
    /// The object slides.
    Gross,
}

impl Phase {
    /// The name used in output lines.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Incipient => "incipient",
            Self::Gross => "gross",
        }
    }
}

/// A change in the slip state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SlipEvent {
    /// A slip has been noticed, has become gross, or has been certified.
    Slip {
        /// How far it has gone.
        phase: Phase,
        /// Whether this is the first notice of the slip, not its turn from incipient to gross or its certificate.
        first: bool,
        /// Which method spoke.
        method: Method,
        /// Probability that noise alone would not reach this statistic within the stated false-alarm interval; see
        /// [`confidence`](crate::confidence).
        confidence: f32,
        /// The interval (s) that the slip is certified with: false alarms of that kind are at least so far apart on
        /// average, at 95 % confidence over the calibration. `None` where only the fast trigger has spoken so far.
        certified_s: Option<f32>,
        /// Which causes other than a slip were ruled out.
        causes: Causes,
    },
    /// The slip has ended.
    Ended {
        /// How long it lasted.
        duration: Micros,
        /// The interval (s) that it was certified with, where it was.
        certified_s: Option<f32>,
    },
}

/// Everything one sample led to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// Device time of the sample.
    pub t: Micros,
    /// The scene the sample was handled in.
    pub scene: Scene,
    /// Slip statistic over its threshold: 1 and above is a slip. 0 where the bands were not needed.
    pub statistic: f32,
    /// A change in the slip state.
    pub event: Option<SlipEvent>,
    /// Features of the slip, when there is new evidence.
    pub features: Option<Features>,
    /// Slip speed with its uncertainty, when there is new evidence.
    pub velocity: Option<Velocity>,
    /// The network's answer to these features.
    pub estimate: Option<ForceEstimate>,
    /// The commanded force; `None` in a pipeline that only observes.
    pub command: Option<Newtons>,
    /// What the controller found out about the object in hand.
    pub grip: Option<GripEvent>,
    /// State of the stylus.
    pub health: Health,
    /// State of the noise floor of the stylus.
    pub floor_health: FloorHealth,
    /// State of the motion reference while an object was last held.
    pub reference_health: ReferenceHealth,
    /// State of the travel channel while an object was last held.
    pub travel_health: TravelHealth,
    /// State of the taxel array while an object was last held.
    pub pressure_health: PressureHealth,
}
