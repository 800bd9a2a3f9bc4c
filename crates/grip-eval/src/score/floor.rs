//! Noise of labelled stillness, as far as a detector may know it before it is scored.
//!
//! A recording is scored with what the rest of *other* materials reports; what a calibration or the configuration states goes before that. Where
//! there is no such rest the pipeline learns its floors as it does live, from the earlier samples of the same recording.

use super::{
    Detector, ScoreError,
    labelled::{Labelled, Recordings, rest_until},
};
use crate::taxels;
use grip_record::{Channel, LabelKind};
use slip_core::{
    PipelineConfig, Sample,
    alarm::Method,
    detector::{BANDS, KnownFloors, RestMeter, SlipDetector},
    isolated::Guard,
    pressure::{MAX_TAXELS, PatternRest},
};

/// Noise at rest.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct AtRest {
    /// Energy of each band (signal unit squared), and the rest it was measured on (s).
    pub(super) floor: Option<[f32; BANDS]>,
    pub(super) floor_s: f64,
    /// Energies of the quiet motion reference and of its slow part (unit squared).
    pub(super) reference: Option<[f32; 2]>,
    /// Noise of the taxels (rms).
    pub(super) taxel_rms: Option<f32>,
    /// Largest mean range of the taxels, where rest lasted long enough for one.
    pub(super) taxel_range: Option<f32>,
}

impl AtRest {
    /// Pooled over the labelled rest of `all`, recordings of the `folder`.
    pub(super) fn of<'a>(
        folder: &Recordings,
        all: impl Iterator<Item = &'a Labelled> + Clone,
        detector: Detector,
        config: &PipelineConfig,
        guard_ms: f64,
    ) -> Result<Self, ScoreError> {
        let mut rest = if config.methods.has(Method::Stylus) {
            match learned_live(folder, all.clone(), config, guard_ms)? {
                Some(learned) => learned,
                None => pooled_floor(folder, all.clone(), config, guard_ms)?,
            }
        } else {
            Self::default()
        };
        let taxels = pooled_taxels(folder, all, detector, config, guard_ms)?;
        rest.taxel_rms = taxels.rms(config.pressure.threshold);
        rest.taxel_range = taxels.range();
        Ok(rest)
    }

    /// `config` with this where it knows nothing yet.
    pub(super) fn known_to(&self, config: PipelineConfig) -> PipelineConfig {
        let mut config = config;
        config.known_floor = config.known_floor.or(self.floor);
        config.known_reference = config.known_reference.or(self.reference);
        let least = config.pressure.min_rms;
        let known_rms = self.taxel_rms.map(|rms| rms.max(least)).filter(|rms| *rms > 0.0);
        config.pressure.known_rms = config.pressure.known_rms.or(known_rms);
        config.pressure.known_range = config.pressure.known_range.or(self.taxel_range);
        config
    }
}

fn pooled_floor<'a>(
    folder: &Recordings,
    all: impl Iterator<Item = &'a Labelled>,
    config: &PipelineConfig,
    guard_ms: f64,
) -> Result<AtRest, ScoreError> {
    let mut meter = RestMeter::new(&config.detector, config.sample_rate.0)
        .map_err(|source| ScoreError::Config { recording: "all recordings".to_owned(), source })?;
    let mut guard = Guard::new(config.sample_rate);
    for one in all.filter(|one| one.label.kind != LabelKind::Steady) {
        let until = rest_until(&one.label, guard_ms);
        let contents = folder.open_rest(one)?;
        let recording = contents.recording(false);
        meter.start();
        guard.forget();
        for sample in recording.samples.iter().take_while(|s| s.t.as_seconds() < until) {
            let reading = sample.vibration();
            meter.push_vector(guard.step(reading).unwrap_or(reading));
        }
    }
    let seconds = meter.samples() as f64 / f64::from(config.sample_rate.0);
    let floor = meter.floor(config.floor);
    Ok(AtRest { floor, floor_s: floor.map_or(0.0, |_| seconds), ..AtRest::default() })
}

/// Where recordings show when the robot moves: what each of them would have learned by the end of its rest, as live,
/// and of that the median. Pooled motion would be no floor.
fn learned_live<'a>(
    folder: &Recordings,
    all: impl Iterator<Item = &'a Labelled>,
    config: &PipelineConfig,
    guard_ms: f64,
) -> Result<Option<AtRest>, ScoreError> {
    let (mut floors, mut references, mut floor_s) = (Vec::new(), Vec::new(), 0.0);
    for one in all.filter(|one| one.has(Channel::Reference) || one.has(Channel::Motion)) {
        let until = rest_until(&one.label, guard_ms);
        let contents = folder.open_rest(one)?;
        let recording = contents.recording(false);
        let known = KnownFloors { stylus: None, reference: config.known_reference };
        let mut detector =
            SlipDetector::new(&config.detector, config.floor, known, config.sample_rate.0)
                .map_err(|source| ScoreError::Config {
                    recording: recording.name.clone(),
                    source,
                })?;
        let mut guard = Guard::new(config.sample_rate);
        for sample in recording.samples.iter().take_while(|s| s.t.as_seconds() < until) {
            if !sample.stylus.is_finite() {
                continue;
            }
            let [stylus, y, z] = sample.vibration();
            let [stylus, y, z] = guard.step([stylus, y, z]).unwrap_or([stylus, y, z]);
            detector.step(&Sample { stylus, stylus_axes: [y, z], ..*sample });
            if !detector.is_moving() {
                floor_s += 1.0 / f64::from(config.sample_rate.0);
            }
        }
        floors.extend(detector.floor());
        references.extend(detector.reference_floor());
    }
    let Some(floor) = median(&floors) else { return Ok(None) };
    let reference = median(&references);
    Ok(Some(AtRest { floor: Some(floor), floor_s, reference, ..AtRest::default() }))
}

/// The median of each value; `None` of nothing.
fn median<const N: usize>(all: &[[f32; N]]) -> Option<[f32; N]> {
    let middle = all.len().checked_sub(1)? / 2;
    Some(core::array::from_fn(|place| {
        let mut values: Vec<f32> = all.iter().map(|values| values[place]).collect();
        values.sort_by(f32::total_cmp);
        values.get(middle).copied().unwrap_or(f32::INFINITY)
    }))
}

fn pooled_taxels<'a>(
    folder: &Recordings,
    all: impl Iterator<Item = &'a Labelled>,
    detector: Detector,
    config: &PipelineConfig,
    guard_ms: f64,
) -> Result<PatternRest<MAX_TAXELS>, ScoreError> {
    let mut meter = PatternRest::<MAX_TAXELS>::new(config.pressure.follow_ms);
    for one in all.filter(|one| one.has_taxels(detector.companions)) {
        let contents = folder.open_rest(one)?;
        let recording = contents.recording(detector.companions);
        let until = rest_until(&one.label, guard_ms);
        let rest = recording.samples.partition_point(|s| s.t.as_seconds() < until);
        taxels::push_rest(&mut meter, recording, |index| index < rest);
    }
    Ok(meter)
}
