//! What the pipeline has to say about a sample.

use crate::{
    detector::FloorHealth,
    esc::Esc,
    estimate::ForceEstimate,
    features::Features,
    grip::GripEvent,
    units::{Micros, Newtons},
    velocity::Velocity,
};
use slip_msg::{
    EXTRAPOLATED, GripState, INFORMATIVE, PipelineState, Reading, Scene, SensorHealth, SlipReport,
};

/// Everything one sample led to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// Device time of the sample.
    pub t: Micros,
    /// The scene the sample was handled in.
    pub scene: Scene,
    /// Slip statistic over its threshold: 1 and above is a slip. 0 where the bands were not needed.
    pub statistic: f32,
    /// A change in the slip state: what is known of it at once. Features, velocity and estimate come with the steps of the slip.
    pub event: Option<SlipReport>,
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
    /// State of stylus, travel, pressure and reference; of all but the stylus while an object was last held.
    pub sensors: [SensorHealth; 4],
    /// State of the noise floor of the stylus.
    pub floor_health: FloorHealth,
}

impl Step {
    /// The state after this step with the last E_sc and the last estimate; what the daemon knows besides is added by it.
    #[must_use]
    pub fn state(
        &self,
        grip: Option<GripState>,
        esc: Option<Esc>,
        estimate: Option<ForceEstimate>,
    ) -> PipelineState {
        let note = |bit, applies| if applies { bit } else { 0 };
        #[expect(clippy::cast_possible_truncation, reason = "shown with seven digits")]
        let value = |esc: Esc| esc.value as f32;
        PipelineState {
            t: self.t,
            scene: self.scene,
            grip: grip.unwrap_or_default(),
            sensors: self.sensors,
            notes: note(INFORMATIVE, esc.is_some_and(|esc| esc.informative()))
                | note(EXTRAPOLATED, estimate.is_some_and(|estimate| estimate.extrapolated)),
            esc_flags: esc.map_or(0, |esc| esc.flags.bits()),
            esc_kind: esc.map_or(Reading::None, |esc| esc.reading),
            statistic: Some(self.statistic),
            command_n: self.command.map(|command| command.0),
            esc: esc.map(value),
            estimate_n: estimate.map(|estimate| estimate.force_n),
            ..PipelineState::UNKNOWN
        }
    }
}
