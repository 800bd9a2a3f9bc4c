//! The labelled rest of all recordings in, the noise floor of the bands and of the taxels out.

use super::{
    Detector, ScoreError,
    labelled::{Labelled, rest_until},
};
use crate::config::HostConfig;
use slip_core::{
    PipelineConfig,
    detector::{BANDS, RestMeter},
    pressure::{MAX_TAXELS, PatternRest},
};

/// The calibrated floor with the rest it was measured on (s), or that of the labelled rest.
pub(super) fn floor(
    all: &[Labelled],
    config: &HostConfig,
    pipeline: &PipelineConfig,
    guard_ms: f64,
) -> Result<Option<([f32; BANDS], f64)>, ScoreError> {
    if let Some(floor) = pipeline.known_floor {
        return Ok(Some((floor, config.calibrated.map_or(0.0, |made| made.evidence.rest_s))));
    }
    let pooled = pooled_floor(all, pipeline, guard_ms)?;
    #[expect(clippy::cast_precision_loss, reason = "a count of samples")]
    let seconds = |samples: u64| samples as f64 / f64::from(pipeline.sample_rate.0);
    Ok(pooled.map(|(floor, samples)| (floor, seconds(samples))))
}

fn pooled_floor(
    all: &[Labelled],
    config: &PipelineConfig,
    guard_ms: f64,
) -> Result<Option<([f32; BANDS], u64)>, ScoreError> {
    let mut meter = RestMeter::new(&config.detector, config.sample_rate.0)
        .map_err(|source| ScoreError::Config { recording: "all recordings".to_owned(), source })?;
    for Labelled { label, recording, .. } in all {
        let until = rest_until(label, guard_ms);
        meter.start();
        for sample in recording.samples.iter().take_while(|s| s.t.as_seconds() < until) {
            meter.push(sample.stylus);
        }
    }
    Ok(meter.floor(config.floor).map(|energy| (energy, meter.samples())))
}

/// Noise of the taxels on the labelled rest of all recordings.
pub(super) fn pooled_taxels(
    detector: Detector,
    all: &[Labelled],
    config: &PipelineConfig,
    guard_ms: f64,
) -> Option<f32> {
    let mut meter = PatternRest::<MAX_TAXELS>::new(config.pressure.follow_ms);
    for one in all {
        let recording = one.recording(detector.companions);
        let Some(taxels) = &recording.taxels else { continue };
        let until = rest_until(&one.label, guard_ms);
        meter.start();
        let rest = recording.samples.iter().take_while(|s| s.t.as_seconds() < until);
        for (index, sample) in rest.enumerate() {
            meter.push(sample.t, taxels.frame(index));
        }
    }
    meter.rms()
}
