//! Labelled recordings in; latency, misses and false alarms out.
//!
//! An alarm is the first notice of a slip. For a recording with an onset:
//!
//! - *early*: a slip was noticed before onset - guard, which is a false alarm;
//! - *latency*: the first notice from onset - guard on, minus the onset; negative while the slip is incipient;
//! - *missed*: no such notice up to onset + [`LATE_S`], and no earlier one still going on.
//!
//! A `steady` recording slips all the time and is missed where no alarm comes at all; a `rest` recording never
//! slips, so each notice is false.

mod causes;
mod chance;
mod companions;
mod curve;
mod detectors;
mod error;
mod floor;
pub mod interval;
mod judge;
mod labelled;
mod materials;
mod quantiles;
#[cfg(test)]
mod tests;
mod totals;

pub use causes::{Alarm, CLOSING, CauseScore, MOVING, STILL};
pub use chance::Chance;
pub use curve::{APART_S, Point};
pub use detectors::{DETECTORS, Detector};
pub use error::ScoreError;
pub use materials::MaterialScore;
pub use quantiles::Quantiles;
pub use totals::{RecordingScore, Score, Total};

use causes::Causes;
use floor::AtRest;
use grip_record::{CsvOptions, StylusKind};
use grip_session::{config::HostConfig, replay};
use judge::judge;
use labelled::{Labelled, load};
use std::{
    collections::{BTreeMap, btree_map::Entry},
    path::Path,
};

/// An alarm later than this after the onset does not count as found (s).
pub const LATE_S: f64 = 0.5;

/// Where the noise floors of a recording come from: never from its own labels or later samples.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Floors {
    /// From the labelled rest of the other materials; where there is none, as live.
    #[default]
    Folds,
    /// From its own earlier samples alone, as live.
    Live,
}

/// What an alarm is judged by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rules {
    /// An alarm may come this much before the labelled onset (ms).
    pub guard_ms: f64,
    /// Where the floors come from.
    pub floors: Floors,
}

/// Scores every labelled recording of `directory` with the settings of `config`.
///
/// The floors of a recording are measured on the labelled rest of the other materials: their `rest` recordings and what lies
/// before onset - guard. Where there is none, they are learned from its own first samples, as live.
///
/// # Errors
/// The first thing that keeps a recording from being used.
pub fn score(
    directory: &Path,
    options: &CsvOptions,
    config: &HostConfig,
    rules: Rules,
) -> Result<Score, ScoreError> {
    let mut scores = compare(directory, options, config, rules, &[Detector::DEFAULT])?;
    scores.pop().ok_or_else(|| ScoreError::Nothing { directory: directory.to_owned() })
}

/// Scores every labelled recording of `directory` with each of `detectors`, as [`score`] does with one.
///
/// # Errors
/// The first thing that keeps a recording from being used.
pub fn compare(
    directory: &Path,
    options: &CsvOptions,
    config: &HostConfig,
    rules: Rules,
    detectors: &[Detector],
) -> Result<Vec<Score>, ScoreError> {
    let companions = detectors.iter().any(|detector| detector.companions);
    let all = load(directory, options, companions)?;
    let scored = detectors.iter().map(|detector| {
        score_with(*detector, &all, config, rules)?.ok_or_else(|| ScoreError::NoRest {
            directory: directory.to_owned(),
            guard_ms: rules.guard_ms,
        })
    });
    scored.collect()
}

/// `None` where there is no rest at all to measure the noise on, and it should be.
fn score_with(
    detector: Detector,
    all: &[Labelled],
    config: &HostConfig,
    Rules { guard_ms, floors }: Rules,
) -> Result<Option<Score>, ScoreError> {
    let Some(first) = all.first() else { return Ok(None) };
    let configured = replay::pipeline_config(&first.recording, config, true);
    let vibration = first.recording.channels.stylus == StylusKind::Vibration;
    config.check_signal(configured.sample_rate, vibration)?;
    let pipeline = (detector.change)(configured);
    let pooled = match (pipeline.known_floor, config.stylus_calibration(), floors) {
        (Some(floor), Some(made), _) => {
            AtRest { floor: Some(floor), floor_s: made.evidence.rest_s, ..AtRest::default() }
        }
        (_, _, Floors::Live) => AtRest::default(),
        _ => AtRest::of(all.iter(), detector, &pipeline, guard_ms)?,
    };
    if pooled.floor.is_none() && pooled.taxel_rms.is_none() && floors == Floors::Folds {
        return Ok(None);
    }
    let mut others: BTreeMap<&str, AtRest> = BTreeMap::new();
    let (mut recordings, mut traces, mut causes) = (Vec::new(), Vec::new(), Causes::default());
    for one in all {
        let material = one.label.material.as_str();
        let known = match others.entry(material) {
            Entry::Occupied(known) => *known.get(),
            Entry::Vacant(place) if floors == Floors::Live => *place.insert(AtRest::default()),
            Entry::Vacant(place) => {
                let others = all.iter().filter(|other| other.label.material != material);
                *place.insert(AtRest::of(others, detector, &pipeline, guard_ms)?)
            }
        };
        let judged = judge(one, detector, known.known_to(pipeline), guard_ms)?;
        causes.add(&judged.causes);
        recordings.push(judged.score);
        traces.push(judged.trace);
    }
    let AtRest { floor, floor_s, taxel_rms, taxel_range, .. } = pooled;
    let score =
        Score { detector, recordings, floor, floor_s, taxel_rms, taxel_range, traces, causes };
    Ok(Some(score))
}
