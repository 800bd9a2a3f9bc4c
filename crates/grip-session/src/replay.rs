//! Replay of a recording: the steps the pipeline makes of it.

use crate::{config::HostConfig, model::HostEstimator};
use grip_record::{Channel, Recording, StylusKind, Taxels};
use slip_core::{
    ConfigError, Pipeline, PipelineConfig, Sample, Signal, StageCounters, Step,
    alarm::Method,
    detector::SlipDetector,
    health::{FORCE_MOST, HealthConfig, HealthCounters},
    units::Hertz,
};
use std::sync::Arc;

/// Longer than any recording (ms).
const NEVER_MS: f32 = 1e12;

/// A step of 50 us or more, rounded to 1 us, is off by at most this.
const RATE_TOLERANCE: f32 = 0.02;

/// The pipeline for a recording: that of the shipped defaults, or of `config`.
///
/// The stylus column decides what is believed of the stylus; without one its method is off. The controller runs where the recording
/// has a stylus and a normal force, as in a recording of a gripper; otherwise, or with `observe`, there is none.
#[must_use]
pub fn pipeline_config(
    recording: &Recording,
    config: &HostConfig,
    observe: bool,
) -> PipelineConfig {
    let rate = Hertz(sample_rate(recording, config));
    let kind = recording.channels.stylus;
    let base = stylus_config(kind, rate, config);
    let grips =
        !observe && kind != StylusKind::Absent && recording.channels.has(Channel::NormalForce);
    PipelineConfig { grip: base.grip.filter(|_| grips), ..base }
}

/// The pipeline of `config` for samples with such a stylus column at `rate`, with the controller; without a stylus its method is off.
#[must_use]
pub fn stylus_config(kind: StylusKind, rate: Hertz, config: &HostConfig) -> PipelineConfig {
    match kind {
        StylusKind::Displacement => config.pipeline(Signal::Displacement, rate),
        StylusKind::Vibration => config.pipeline(Signal::Vibration, rate),
        StylusKind::Absent => PipelineConfig {
            // What is not there cannot freeze.
            health: HealthConfig { frozen_ms: NEVER_MS, ..HealthConfig::default() },
            methods: config.methods().without(Method::Stylus),
            ..config.pipeline(Signal::Vibration, rate)
        },
    }
}

/// What a stream of such samples cannot show.
#[must_use]
pub const fn limits(kind: StylusKind, taxels: usize) -> Option<&'static str> {
    match kind {
        StylusKind::Displacement => None,
        StylusKind::Vibration => Some(
            "a vibration signal (signed or rectified): slips are found, heights and E_sc are not known",
        ),
        StylusKind::Absent if matches!(taxels, 1 | 2) => Some(
            "no stylus, and fewer than 3 taxels, whose distribution shows nothing: slips are found by a travel alone",
        ),
        StylusKind::Absent => {
            Some("no stylus: slips are found by taxels and travel, heights and E_sc are not known")
        }
    }
}

/// Times are recorded in whole microseconds, so the rate that they show may be off by some parts in a hundred, and with it
/// the bands. A gripper works at the configured rate: where the recording agrees with that, this is the rate it had.
fn sample_rate(recording: &Recording, config: &HostConfig) -> f32 {
    let configured = config.link.sample_rate_hz as f32;
    let agrees = (recording.rate_hz / configured - 1.0).abs() < RATE_TOLERANCE;
    let given = recording.notes.given_rate_hz.is_some();
    let gripper = recording.channels.stylus == StylusKind::Displacement
        && recording.channels.has(Channel::NormalForce);
    if gripper && agrees && !given { configured } else { recording.rate_hz }
}

/// What a recording that ends while its noise floor is still being learned does not show.
pub const LEARNING: &str = "ends before its noise floor is learned, so that the signal shows no slip; begin with stillness, 0.2 s of it, some seconds at low rates";

/// What to say of forces that were left out because no finger of the gripper meets them.
#[must_use]
pub fn forces(health: &HealthCounters) -> Option<String> {
    let forces = health.forces;
    (forces > 0).then(|| {
        format!(
            "{forces} normal forces of more than {FORCE_MOST} times grip.f_max_n were left out: are they in mN or in counts, or does the gripper press harder than grip.f_max_n?"
        )
    })
}

/// Every step of a recording, in order.
#[derive(Debug)]
pub struct Replay<'a> {
    samples: core::iter::Enumerate<core::slice::Iter<'a, Sample>>,
    taxels: Option<&'a Taxels>,
    pipeline: Pipeline<Arc<[f32]>>,
}

impl<'a> Replay<'a> {
    /// A replay from the first sample on.
    ///
    /// # Errors
    /// Where the configuration does not fit the recording, for example a band above its sample rate.
    pub fn new(
        recording: &'a Recording,
        config: PipelineConfig,
        estimator: Option<HostEstimator>,
    ) -> Result<Self, ConfigError> {
        let pipeline = Pipeline::new(config, estimator)?;
        let samples = recording.samples.iter().enumerate();
        Ok(Self { samples, taxels: recording.taxels.as_ref(), pipeline })
    }

    /// The detector of the stylus after the last step.
    #[must_use]
    pub fn detector(&self) -> &SlipDetector {
        self.pipeline.detector()
    }

    /// Whether the noise floor is still being learned: a stylus shows no slip before.
    #[must_use]
    pub fn is_learning(&self) -> bool {
        self.pipeline.is_learning()
    }

    /// How often each stage ran so far.
    #[must_use]
    pub fn stage_counters(&self) -> StageCounters {
        self.pipeline.stage_counters()
    }

    /// Unusable readings so far.
    #[must_use]
    pub fn health_counters(&self) -> HealthCounters {
        self.pipeline.health_counters()
    }
}

impl Iterator for Replay<'_> {
    type Item = Step;

    fn next(&mut self) -> Option<Step> {
        let (index, sample) = self.samples.next()?;
        let frame = self.taxels.map_or(&[] as &[f32], |taxels| taxels.frame(index));
        Some(self.pipeline.handle_with(sample, frame))
    }
}
