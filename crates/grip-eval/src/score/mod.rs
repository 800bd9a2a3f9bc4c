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

mod beside;
mod causes;
mod chance;
mod companions;
mod curve;
mod detectors;
mod error;
mod esc_test;
mod floor;
pub mod interval;
mod judge;
mod labelled;
mod materials;
mod network_test;
mod quantiles;
#[cfg(test)]
mod study_tests;
#[cfg(test)]
mod tests;
mod totals;
mod training;

pub use beside::{Beside, Change, Test};
pub use causes::{Alarm, CLOSING, CauseScore, MOVING, STILL};
pub use chance::Chance;
pub use curve::{APART_S, Point};
pub use detectors::{DETECTORS, Decides, Detector};
pub use error::ScoreError;
pub use esc_test::EscTest;
pub use materials::MaterialScore;
pub use network_test::{NetworkTest, Rows, SlipNetwork, UntrainedError};
pub use quantiles::Quantiles;
pub use totals::{RecordingScore, Score, Total};

use causes::Causes;
use core::time::Duration;
use floor::AtRest;
use grip_record::{CsvOptions, StylusKind};
use grip_session::{config::HostConfig, replay};
use judge::{Fitted, judge};
use labelled::{Labelled, load};
use slip_core::{PipelineConfig, esc::Reading};
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
    let mut scores =
        compare(directory, options, config, rules, &[Detector::DEFAULT], Watch::default())?;
    scores.pop().ok_or_else(|| ScoreError::Nothing { directory: directory.to_owned() })
}

/// Time since some instant, where a program reads a clock.
pub type Clock<'a> = &'a dyn Fn() -> Duration;

/// What a program may want beside the scores.
#[derive(Clone, Copy, Default)]
pub struct Watch<'a> {
    /// Measures the run time of each detector; `None` where that is not wanted.
    pub clock: Option<Clock<'a>>,
    /// Gets how many pairs of recording and detector are done, and of how many.
    pub done: Option<&'a dyn Fn(usize, usize)>,
}

impl core::fmt::Debug for Watch<'_> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Watch").field("timed", &self.clock.is_some()).finish_non_exhaustive()
    }
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
    watch: Watch<'_>,
) -> Result<Vec<Score>, ScoreError> {
    let companions = detectors.iter().any(|detector| detector.companions);
    let all = load(directory, options, companions)?;
    let scored = detectors.iter().enumerate().map(|(nth, detector)| {
        let done = |recordings| {
            if let Some(done) = watch.done {
                done(nth * all.len() + recordings, detectors.len() * all.len());
            }
        };
        score_with(*detector, &all, config, rules, watch.clock, &done)?.ok_or_else(|| {
            ScoreError::NoRest { directory: directory.to_owned(), guard_ms: rules.guard_ms }
        })
    });
    scored.collect()
}

/// `None` where there is no rest at all to measure the noise on, and it should be.
fn score_with(
    detector: Detector,
    all: &[Labelled],
    config: &HostConfig,
    rules: Rules,
    clock: Option<Clock<'_>>,
    done: &dyn Fn(usize),
) -> Result<Option<Score>, ScoreError> {
    let Rules { guard_ms, floors } = rules;
    let Some(first) = all.first() else { return Ok(None) };
    let configured = replay::pipeline_config(&first.recording, config, true);
    if detector.decides != Decides::Pipeline
        && first.recording.channels.stylus == StylusKind::Absent
    {
        let recording = first.recording.name.clone();
        return Err(ScoreError::NoStylus { recording, detector: detector.name });
    }
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
    let folder = Folder { all, detector, pipeline, rules };
    let mut folds: BTreeMap<&str, Fitted> = BTreeMap::new();
    let mut run_time: Vec<f64> = Vec::new();
    let (mut recordings, mut traces, mut causes) = (Vec::new(), Vec::new(), Causes::default());
    for one in all {
        let fitted = match folds.entry(&one.label.material) {
            Entry::Occupied(known) => known.into_mut(),
            Entry::Vacant(place) => {
                let fitted = folder.fitted(place.key())?;
                place.insert(fitted)
            }
        };
        let began = clock.map(|now| now());
        let judged = judge(one, fitted.clone(), guard_ms)?;
        let took = clock.zip(began).map(|(now, began)| now().saturating_sub(began));
        run_time.extend(took.and_then(|took| per_sample_ns(took, one.recording.samples.len())));
        causes.add(&judged.causes);
        recordings.push(judged.score);
        traces.push(judged.trace);
        done(traces.len());
    }
    let AtRest { floor, floor_s, taxel_rms, taxel_range, .. } = pooled;
    let ns_per_sample = run_time.into_iter().reduce(f64::min);
    Ok(Some(Score {
        detector,
        recordings,
        floor,
        floor_s,
        taxel_rms,
        taxel_range,
        ns_per_sample,
        traces,
        causes,
    }))
}

/// Time for a sample (ns); `None` of none.
#[expect(clippy::cast_precision_loss, reason = "a count of samples")]
fn per_sample_ns(took: Duration, samples: usize) -> Option<f64> {
    (samples > 0).then(|| 1e9 * took.as_secs_f64() / samples as f64)
}

/// Labelled recordings and a detector that is to judge them.
struct Folder<'a> {
    all: &'a [Labelled],
    detector: Detector,
    pipeline: PipelineConfig,
    rules: Rules,
}

impl<'a> Folder<'a> {
    /// The detector for the recordings of `material`, with floors and network of the others.
    fn fitted(&self, material: &str) -> Result<Fitted, ScoreError> {
        let Self { detector, pipeline, rules, .. } = *self;
        let known = match rules.floors {
            Floors::Live => AtRest::default(),
            Floors::Folds => {
                AtRest::of(self.others(material), detector, &pipeline, rules.guard_ms)?
            }
        };
        let config = known.known_to(pipeline);
        let test = match detector.decides {
            Decides::Pipeline => None,
            Decides::Esc(reading) => Some(self.esc(reading)?),
            Decides::Network => Some(self.network(material, config)?),
        };
        let beside = test.map(|test| Beside::new(test, &config.detector));
        Ok(Fitted { detector, config, beside })
    }

    fn others(&self, material: &str) -> impl Iterator<Item = &'a Labelled> + Clone {
        self.all.iter().filter(move |other| other.label.material != material)
    }

    fn esc(&self, reading: Reading) -> Result<Test, ScoreError> {
        let PipelineConfig { detector, sample_rate, .. } = &self.pipeline;
        let test = EscTest::new(reading, detector, sample_rate.0).map_err(|source| {
            ScoreError::Config { recording: "all recordings".to_owned(), source }
        })?;
        Ok(Test::Esc(Box::new(test)))
    }

    fn network(&self, material: &str, config: PipelineConfig) -> Result<Test, ScoreError> {
        let rows = training::rows(self.others(material), config, self.rules.guard_ms)?;
        let network = SlipNetwork::train(&rows).map_err(|source| ScoreError::Untrained {
            material: material.to_owned(),
            detector: self.detector.name,
            source: Box::new(source),
        })?;
        Ok(Test::Network(NetworkTest::new(network)))
    }
}
