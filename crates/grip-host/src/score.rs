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

mod companions;
mod curve;
mod detectors;
pub mod interval;
mod materials;

pub use curve::{APART_S, Point};
pub use detectors::{DETECTORS, Detector};
pub use materials::MaterialScore;

use crate::{
    config::HostConfig,
    replay::{self, Replay},
};
use curve::Trace;
use grip_record::{
    CsvError, CsvOptions, Label, LabelError, LabelKind, Recording, StylusKind, Travel, read_csv,
    read_labels,
};
use interval::{Interval, QuantileIntervals};
use serde::Serialize;
use slip_core::{
    ConfigError, PipelineConfig, SlipEvent,
    detector::{BANDS, RestMeter},
    pressure::{MAX_TAXELS, PatternRest},
    units::Micros,
};
use std::path::{Path, PathBuf};

/// An alarm later than this after the onset does not count as found (s).
pub const LATE_S: f64 = 0.5;

/// Why a folder cannot be scored.
#[derive(Debug, thiserror::Error)]
pub enum ScoreError {
    /// The labels cannot be used.
    #[error(transparent)]
    Labels(#[from] LabelError),
    /// A recording cannot be used.
    #[error(transparent)]
    Recording(#[from] CsvError),
    /// The folder has no labelled recording.
    #[error("{}: no recording is labelled; labels.csv needs a row for each", directory.display())]
    Nothing {
        /// The folder.
        directory: PathBuf,
    },
    /// The labels are an empty file.
    #[error("{}: is empty; the first line must be recording,kind,material,onset_s", file.display())]
    Unlabelled {
        /// The file of the labels.
        file: PathBuf,
    },
    /// An onset that the recording does not reach.
    #[error(
        "labels.csv: {recording}: the onset at {onset_s} s lies outside the recording ({first_s} to {last_s} s); correct onset_s"
    )]
    OnsetOutside {
        /// The recording.
        recording: String,
        /// The onset (s).
        onset_s: f64,
        /// Time of the first sample (s).
        first_s: f64,
        /// Time of the last sample (s).
        last_s: f64,
    },
    /// The settings do not fit a recording.
    #[error("{recording}: {source}")]
    Config {
        /// The recording.
        recording: String,
        /// What does not fit.
        source: ConfigError,
    },
    /// The calibration was made for another rate or stylus.
    #[error(transparent)]
    Calibration(#[from] crate::config::HostConfigError),
    /// The recordings differ in what a pooled floor needs to be equal.
    #[error(
        "{recording} is sampled at {rate_hz} Hz or in other units than {first} ({first_hz} Hz): their rest cannot be pooled"
    )]
    Mixed {
        /// The recording.
        recording: String,
        /// Its rate.
        rate_hz: f32,
        /// The first recording.
        first: String,
        /// Its rate.
        first_hz: f32,
    },
    /// No labelled rest to measure the floor on.
    #[error(
        "{}: no labelled rest to measure the noise floor on: no `rest` recording, and every onset lies within {guard_ms} ms of its start",
        directory.display()
    )]
    NoRest {
        /// The folder.
        directory: PathBuf,
        /// The guard before each onset.
        guard_ms: f64,
    },
}

/// One recording's result.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RecordingScore {
    /// The detector.
    pub detector: &'static str,
    /// Its name.
    pub recording: String,
    /// `onset`, `steady` or `rest`.
    pub kind: &'static str,
    /// What the surface was.
    pub material: String,
    /// Labelled onset (s).
    pub onset_s: Option<f64>,
    /// The first alarm of all (s).
    pub alarm_s: Option<f64>,
    /// From the onset, or from the start of a steady recording, to the alarm that counts (ms).
    pub latency_ms: Option<f64>,
    /// A slip that was not found.
    pub missed: bool,
    /// An alarm before onset - guard.
    pub early: bool,
    /// Travel at the alarm that counts (mm), where a companion tells it.
    pub travel_mm: Option<f64>,
    /// Alarms in all.
    pub alarms: u32,
    /// Length (s).
    pub length_s: f64,
}

/// The results of a folder with one detector.
#[derive(Clone, Debug)]
pub struct Score {
    /// The detector.
    pub detector: Detector,
    /// One per recording, in the order of the labels.
    pub recordings: Vec<RecordingScore>,
    /// The floor that was used: energy of each band (signal unit squared).
    pub floor: [f32; BANDS],
    /// Rest it was measured on (s).
    pub floor_s: f64,
    /// Noise of the taxels that was used (rms), where there is an array.
    pub taxel_rms: Option<f32>,
    traces: Vec<Trace>,
}

/// The total line.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "type", rename = "total")]
pub struct Total {
    /// The detector.
    pub detector: &'static str,
    /// Recordings with an onset.
    pub onsets: usize,
    /// Of these not found.
    pub missed: usize,
    /// Of these with an alarm too early.
    pub early: usize,
    /// Interval of the share missed.
    pub missed_ci: Interval,
    /// Interval of the share with an alarm too early.
    pub early_ci: Interval,
    /// Latency from the onset.
    pub latency_ms: Quantiles,
    /// Its intervals.
    pub latency_ms_ci: QuantileIntervals,
    /// Travel at the alarm, where known (mm).
    pub travel_mm: Quantiles,
    /// Recordings that slip all the time.
    pub steady: usize,
    /// Of these without any alarm.
    pub steady_missed: usize,
    /// Delay of the first alarm in these.
    pub steady_ms: Quantiles,
    /// Length of the recordings that never slip (s).
    pub rest_s: f64,
    /// Alarms in these.
    pub rest_alarms: u32,
    /// Interval of their rate (1/h).
    pub rest_alarms_per_hour_ci: Interval,
    /// Rest the floor was measured on (s).
    pub floor_s: f64,
    /// Guard before each onset (ms).
    pub guard_ms: f64,
}

/// Median and 95 % quantile; `null` of nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Quantiles {
    /// Median.
    pub p50: Option<f64>,
    /// 95 % quantile.
    pub p95: Option<f64>,
}

impl Quantiles {
    /// Of `values`, interpolated linearly between the ordered values.
    #[must_use]
    pub fn of(mut values: Vec<f64>) -> Self {
        values.sort_by(f64::total_cmp);
        Self { p50: quantile(&values, 0.5), p95: quantile(&values, 0.95) }
    }
}

#[expect(
    clippy::cast_precision_loss,
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a place in a list"
)]
fn quantile(ordered: &[f64], q: f64) -> Option<f64> {
    let place = q * (ordered.len().checked_sub(1)? as f64);
    let (low, high) = (*ordered.get(place.floor() as usize)?, *ordered.get(place.ceil() as usize)?);
    Some(low + (high - low) * place.fract())
}

struct Labelled {
    label: Label,
    recording: Recording,
    /// The same with what lies beside it as further channels.
    joined: Option<Recording>,
    travel: Option<Travel>,
}

impl Labelled {
    fn recording(&self, companions: bool) -> &Recording {
        self.joined.as_ref().filter(|_| companions).unwrap_or(&self.recording)
    }
}

/// Scores every labelled recording of `directory` with the settings of `config`.
///
/// The floor is measured on the labelled rest of all recordings: the `rest` recordings and what lies
/// before onset - guard.
///
/// # Errors
/// The first thing that keeps a recording from being used.
pub fn score(
    directory: &Path,
    options: &CsvOptions,
    config: &HostConfig,
    guard_ms: f64,
) -> Result<Score, ScoreError> {
    let mut scores = compare(directory, options, config, guard_ms, &[Detector::DEFAULT])?;
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
    guard_ms: f64,
    detectors: &[Detector],
) -> Result<Vec<Score>, ScoreError> {
    let companions = detectors.iter().any(|detector| detector.companions);
    let all = load(directory, options, companions)?;
    let scored = detectors.iter().map(|detector| {
        score_with(*detector, &all, config, guard_ms)?
            .ok_or_else(|| ScoreError::NoRest { directory: directory.to_owned(), guard_ms })
    });
    scored.collect()
}

fn load(
    directory: &Path,
    options: &CsvOptions,
    companions: bool,
) -> Result<Vec<Labelled>, ScoreError> {
    let mut all = Vec::new();
    let labels = directory.join("labels.csv");
    for label in read_labels(&labels).map_err(|error| labels_error(&labels, error))? {
        let file = label.file(directory);
        let recording = read_csv(&file, options)?;
        check_onset(&label, &recording)?;
        let travel = Travel::read_beside(&file)?;
        let joined =
            companions.then(|| companions::join(&file, &recording, travel.as_ref())).transpose()?;
        all.push(Labelled { label, recording, joined, travel });
    }
    let first =
        all.first().ok_or_else(|| ScoreError::Nothing { directory: directory.to_owned() })?;
    check_alike(first, &all)?;
    Ok(all)
}

/// `None` where there is no rest to measure the floor on.
fn score_with(
    detector: Detector,
    all: &[Labelled],
    config: &HostConfig,
    guard_ms: f64,
) -> Result<Option<Score>, ScoreError> {
    let Some(first) = all.first() else { return Ok(None) };
    let configured = replay::pipeline_config(&first.recording, config, true);
    let vibration = first.recording.channels.stylus == StylusKind::Vibration;
    config.check_signal(configured.sample_rate, vibration)?;
    let mut pipeline = (detector.change)(configured);
    let Some((floor, floor_s)) = floor(all, config, &pipeline, guard_ms)? else { return Ok(None) };
    pipeline.known_floor = Some(floor);
    let taxel_rms = pooled_taxels(detector, all, &pipeline, guard_ms);
    let known_rms = taxel_rms.map(|rms| rms.max(pipeline.pressure.min_rms));
    pipeline.pressure.known_rms = pipeline.pressure.known_rms.or(known_rms);
    let (mut recordings, mut traces) = (Vec::new(), Vec::new());
    for one in all {
        let (score, trace) = judge(one, detector, pipeline, guard_ms)?;
        recordings.push(score);
        traces.push(trace);
    }
    Ok(Some(Score { detector, recordings, floor, floor_s, taxel_rms, traces }))
}

/// What a recording would be told to put on its first line is wrong advice for labels.
fn labels_error(file: &Path, error: LabelError) -> ScoreError {
    match error {
        LabelError::Table(CsvError::Empty { .. }) => {
            ScoreError::Unlabelled { file: file.to_owned() }
        }
        LabelError::Table(CsvError::NoRows { .. }) => {
            ScoreError::Nothing { directory: file.parent().unwrap_or(file).to_owned() }
        }
        error => error.into(),
    }
}

fn check_onset(label: &Label, recording: &Recording) -> Result<(), ScoreError> {
    let (Some(onset), Some(first), Some(last)) =
        (label.onset(), recording.samples.first(), recording.samples.last())
    else {
        return Ok(());
    };
    if (first.t..=last.t).contains(&onset) {
        return Ok(());
    }
    Err(ScoreError::OnsetOutside {
        recording: label.recording.clone(),
        onset_s: onset.as_seconds(),
        first_s: first.t.as_seconds(),
        last_s: last.t.as_seconds(),
    })
}

fn check_alike(first: &Labelled, all: &[Labelled]) -> Result<(), ScoreError> {
    let reference = &first.recording;
    for Labelled { recording, .. } in all {
        let same_rate = (recording.rate_hz / reference.rate_hz - 1.0).abs() < 0.01;
        if !same_rate || recording.channels.stylus != reference.channels.stylus {
            return Err(ScoreError::Mixed {
                recording: recording.name.clone(),
                rate_hz: recording.rate_hz,
                first: reference.name.clone(),
                first_hz: reference.rate_hz,
            });
        }
    }
    Ok(())
}

/// Time up to which a recording is labelled as rest (s).
fn rest_until(label: &Label, guard_ms: f64) -> f64 {
    match label.kind {
        LabelKind::Onset { at } => at.as_seconds() - 1e-3 * guard_ms,
        LabelKind::Rest => f64::INFINITY,
        LabelKind::Steady => f64::NEG_INFINITY,
    }
}

/// The calibrated floor with the rest it was measured on (s), or that of the labelled rest.
fn floor(
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
    Ok(meter.energy().map(|energy| (energy, meter.samples())))
}

/// Noise of the taxels on the labelled rest of all recordings.
fn pooled_taxels(
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

fn judge(
    one: &Labelled,
    detector: Detector,
    config: PipelineConfig,
    guard_ms: f64,
) -> Result<(RecordingScore, Trace), ScoreError> {
    let Labelled { label, travel, .. } = one;
    let recording = one.recording(detector.companions);
    let (spans, statistics) = slips(recording, config)?;
    let trace = Trace::new(label.kind, rest_until(label, guard_ms), &statistics);
    let first_s = recording.samples.first().map_or(0.0, |s| s.t.as_seconds());
    let last_s = recording.samples.last().map_or(0.0, |s| s.t.as_seconds());
    let mut score = RecordingScore {
        detector: detector.name,
        recording: label.recording.clone(),
        kind: label.kind.word(),
        material: label.material.clone(),
        onset_s: None,
        alarm_s: spans.first().map(|span| span.0.as_seconds()),
        latency_ms: None,
        missed: false,
        early: false,
        travel_mm: None,
        alarms: u32::try_from(spans.len()).unwrap_or(u32::MAX),
        length_s: last_s - first_s,
    };
    let mut counts = None;
    match label.kind {
        LabelKind::Rest => {}
        LabelKind::Steady => {
            counts = spans.first().map(|span| span.0);
            score.missed = counts.is_none();
            score.latency_ms = counts.map(|t| 1e3 * (t.as_seconds() - first_s));
        }
        LabelKind::Onset { at } => {
            let onset = at.as_seconds();
            let from = onset - 1e-3 * guard_ms;
            let in_time = |t: f64| (from..=onset + LATE_S).contains(&t);
            counts = spans.iter().map(|span| span.0).find(|t| in_time(t.as_seconds()));
            let going_on =
                spans.iter().any(|(a, b)| a.as_seconds() < from && b.as_seconds() >= from);
            score.onset_s = Some(onset);
            score.early = spans.first().is_some_and(|span| span.0.as_seconds() < from);
            score.missed = counts.is_none() && !going_on;
            score.latency_ms = counts.map(|t| 1e3 * (t.as_seconds() - onset));
        }
    }
    score.travel_mm = counts.and_then(|t| travel.as_ref()?.travel_at(t));
    Ok((score, trace))
}

type Spans = Vec<(Micros, Micros)>;

/// First notice and end of every slip in the recording, and the statistic at every time (s).
fn slips(
    recording: &Recording,
    config: PipelineConfig,
) -> Result<(Spans, Vec<(f64, f32)>), ScoreError> {
    let steps = Replay::new(recording, config, None)
        .map_err(|source| ScoreError::Config { recording: recording.name.clone(), source })?;
    let mut spans: Spans = Vec::new();
    let mut statistics = Vec::with_capacity(recording.samples.len());
    for step in steps {
        statistics.push((step.t.as_seconds(), step.statistic));
        match (step.event, spans.last_mut()) {
            (Some(SlipEvent::Slip { first: true, .. }), _) => {
                spans.push((step.t, Micros(u64::MAX)))
            }
            (Some(SlipEvent::Ended { .. }), Some(span)) => span.1 = step.t,
            _ => {}
        }
    }
    Ok((spans, statistics))
}

impl Score {
    /// False alarms, misses and latency at thresholds from 1/8 to 32 times the configured ones.
    #[must_use]
    pub fn curve(&self) -> Vec<Point> {
        curve::curve(&self.traces)
    }

    /// The sums over all recordings.
    #[must_use]
    pub fn total(&self, guard_ms: f64) -> Total {
        let of = |kind: &'static str| self.recordings.iter().filter(move |r| r.kind == kind);
        let latencies = |kind| Quantiles::of(of(kind).filter_map(|r| r.latency_ms).collect());
        let onsets = of("onset").count();
        let missed = of("onset").filter(|r| r.missed).count();
        let early = of("onset").filter(|r| r.early).count();
        let found = of("onset").filter_map(|r| Some((r.material.as_str(), r.latency_ms?)));
        // The sum of nothing is -0.
        let rest_s = of("rest").map(|r| r.length_s).sum::<f64>() + 0.0;
        let rest_alarms = of("rest").map(|r| r.alarms).sum();
        Total {
            detector: self.detector.name,
            onsets,
            missed,
            early,
            missed_ci: interval::share(missed, onsets),
            early_ci: interval::share(early, onsets),
            latency_ms: latencies("onset"),
            latency_ms_ci: interval::quantiles(&found.collect::<Vec<_>>()),
            travel_mm: Quantiles::of(of("onset").filter_map(|r| r.travel_mm).collect()),
            steady: of("steady").count(),
            steady_missed: of("steady").filter(|r| r.missed).count(),
            steady_ms: latencies("steady"),
            rest_s,
            rest_alarms,
            rest_alarms_per_hour_ci: interval::rate(rest_alarms, rest_s / 3600.0),
            floor_s: self.floor_s,
            guard_ms,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Quantiles, ScoreError, score};
    use crate::config::HostConfig;
    use core::fmt::Write as _;
    use grip_record::CsvOptions;
    use std::{fs, path::Path};

    /// 300 ms of rest, then 300 ms of a 150 Hz tone; times in the file start at 0.
    fn recording(slip_from_ms: u32, amplitude: f64, seed: u32) -> String {
        let mut state = seed;
        let mut text = String::from("t_s,vibration\n");
        for i in 0..1320_u32 {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let noise = f64::from(state >> 8) / f64::from(1 << 24) * 10.0 - 5.0;
            let t = f64::from(i) / 2200.0;
            let tone = if t * 1e3 >= f64::from(slip_from_ms) {
                amplitude * (942.0 * t).sin()
            } else {
                0.0
            };
            let _ = writeln!(text, "{t:.6},{}", (noise + tone).round());
        }
        text
    }

    fn folder(labels: &str) -> tempfile::TempDir {
        let dir = tempfile::tempdir().unwrap();
        fs::write(dir.path().join("labels.csv"), labels).unwrap();
        fs::write(dir.path().join("a.csv"), recording(300, 200.0, 1)).unwrap();
        fs::write(dir.path().join("b.csv"), recording(225, 60.0, 2)).unwrap();
        fs::write(dir.path().join("s.csv"), recording(0, 200.0, 3)).unwrap();
        fs::write(dir.path().join("r.csv"), recording(1000, 0.0, 4)).unwrap();
        dir
    }

    fn run(dir: &Path) -> Result<super::Score, ScoreError> {
        score(dir, &CsvOptions::default(), &HostConfig::default(), 60.0)
    }

    #[test]
    fn finds_what_is_labelled_and_counts_what_is_not() {
        let dir = folder(
            "recording,kind,material,onset_s\na,onset,x,0.3\nb,onset,x,0.3\ns,steady,y,\nr,rest,y,\n",
        );
        // b slips 75 ms before its label, which is outside the guard.
        let result = run(dir.path()).unwrap();
        let [a, b, s, r] = result.recordings.as_slice() else { panic!() };
        assert!(!a.early && !a.missed && (0.0..10.0).contains(&a.latency_ms.unwrap()), "{a:?}");
        assert!(b.early && !b.missed && b.latency_ms.is_none(), "{b:?}");
        assert!(!s.missed && s.latency_ms.unwrap() < 20.0, "{s:?}");
        assert_eq!((r.alarms, r.alarm_s), (0, None));
        let total = result.total(60.0);
        assert_eq!((total.onsets, total.missed, total.early), (2, 0, 1));
        assert_eq!((total.steady, total.steady_missed, total.rest_alarms), (1, 0, 0));
        assert!((total.rest_s - 0.6).abs() < 0.01);
    }

    #[test]
    fn a_quiet_recording_with_an_onset_is_missed() {
        let dir = folder("recording,kind,material,onset_s\nr,onset,x,0.3\n");
        let result = run(dir.path()).unwrap();
        assert!(result.recordings[0].missed);
        assert_eq!(result.total(60.0).latency_ms, Quantiles::default());
    }

    #[test]
    fn without_rest_there_is_no_floor() {
        let dir = folder("recording,kind,material,onset_s\na,onset,x,0.05\ns,steady,x,\n");
        assert!(matches!(run(dir.path()), Err(ScoreError::NoRest { .. })));
    }

    #[test]
    fn quantiles_interpolate() {
        let q = Quantiles::of((0..=10).rev().map(f64::from).collect());
        assert_eq!((q.p50, q.p95), (Some(5.0), Some(9.5)));
    }
}
