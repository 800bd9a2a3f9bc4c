//! What the pipeline has to report about a sample, and how often each stage ran.

use crate::{
    detector::FloorHealth,
    esc::Esc,
    estimate::{Features, ForceEstimate},
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

// How often each stage of the pipeline ran.

/// Counts since the pipeline was made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StageCounters {
    /// Samples handled.
    pub samples: u64,
    /// Samples that went through the filter bank and the detector.
    pub bands: u64,
    /// Samples that also went through the bands of the motion reference and the gate.
    pub gate: u64,
    /// Travel readings and taxel frames that were looked at.
    pub methods: u64,
    /// Samples of slips, measured for speed, irregularities and E_sc.
    pub observation: u64,
    /// Answers asked of the network.
    pub inferences: u64,
    /// Answers the network could not give.
    pub refused_estimates: u64,
    /// Times a quieter second has lowered the noise floor.
    pub floor_lowered: u64,
}
