//! Scores of labelled recordings: latency, misses and false alarms.
//!
//! An alarm is the first notice of a slip. For a recording with an onset:
//!
//! - *early*: a slip was noticed before onset - guard, which is a false alarm;
//! - *latency*: the first notice from onset - guard on, minus the onset; negative while the slip is incipient;
//! - *inside*: no such notice up to onset + [`LATE_S`], because an alarm of before is still going on: neither found nor
//!   missed;
//! - *missed*: no such notice, and no alarm of before.
//!
//! Several slips of a recording have an onset each, in rising order. A further one is found from its onset - guard on, up to that of
//! the next one; alarms between slips are not judged, because no label states when a slip is over.
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
pub use causes::{Alarm, CLOSING, CauseScore, MOVING, STILL, UNKNOWN};
pub use chance::Chance;
pub use curve::{APART_S, Point};
pub use detectors::{DETECTORS, Decides, Detector};
pub use error::ScoreError;
pub use esc_test::EscTest;
pub use materials::MaterialScore;
pub use network_test::{NetworkTest, Rows, SlipNetwork, UntrainedError};
pub use quantiles::Quantiles;
pub use totals::{FileNotes, FloorFrom, RecordingScore, Score, Total};

use causes::Causes;
use core::{
    sync::atomic::{AtomicUsize, Ordering},
    time::Duration,
};
use floor::AtRest;
use grip_record::{CsvOptions, StylusKind};
use grip_session::{config::HostConfig, replay};
use judge::{Fitted, judge};
use labelled::{Labelled, Memory, Recordings};
use rayon::iter::{IntoParallelIterator as _, ParallelIterator as _};
use slip_core::{
    PipelineConfig,
    alarm::{Method, Methods},
    esc::Reading,
};
use std::{
    collections::{BTreeMap, BTreeSet},
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
    scores.pop().unwrap_or_else(|| Err(ScoreError::Nothing { directory: directory.to_owned() }))
}

/// Time since some instant, where a program reads a clock.
pub type Clock<'a> = &'a (dyn Fn() -> Duration + Sync);

/// What a program may want beside the scores.
#[derive(Clone, Copy, Default)]
pub struct Watch<'a> {
    /// Measures the run time of each detector; `None` where that is not wanted.
    pub clock: Option<Clock<'a>>,
    /// Gets how many pairs of recording and detector are done, and of how many; from several threads.
    pub done: Option<&'a (dyn Fn(usize, usize) + Sync)>,
}

impl core::fmt::Debug for Watch<'_> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Watch").field("timed", &self.clock.is_some()).finish_non_exhaustive()
    }
}

/// Scores every labelled recording of `directory` with each of `detectors`, as [`score`] does with one. A detector that cannot
/// run on them has its reason in the place of its score. Where run times are measured recordings are judged one after the
/// other, else by all cores. A folder of any size takes some 800 MB of memory at most, or 270 MB more than its largest
/// recording; a network that is trained takes 24 bytes for each half millisecond of the other materials beside that.
///
/// # Errors
/// The first thing that keeps a recording from being used, or the reason of the first detector where none can run.
pub fn compare(
    directory: &Path,
    options: &CsvOptions,
    config: &HostConfig,
    rules: Rules,
    detectors: &[Detector],
    watch: Watch<'_>,
) -> Result<Vec<Result<Score, ScoreError>>, ScoreError> {
    compare_within(Memory::DEFAULT, directory, options, detectors, &Task { config, rules, watch })
}

/// What is asked of each detector.
struct Task<'a> {
    config: &'a HostConfig,
    rules: Rules,
    watch: Watch<'a>,
}

fn compare_within(
    memory: Memory,
    directory: &Path,
    options: &CsvOptions,
    detectors: &[Detector],
    task: &Task<'_>,
) -> Result<Vec<Result<Score, ScoreError>>, ScoreError> {
    let folder = Recordings::load(directory, options, detectors, task.rules.guard_ms, memory)?;
    let configure = |first: &Labelled| {
        let configured =
            replay::pipeline_config(folder.open_rest(first)?.recording(false), task.config, true);
        let vibration = first.stylus() == StylusKind::Vibration;
        task.config.check_signal(configured.sample_rate, vibration)?;
        Ok(configured)
    };
    let configured: Vec<PipelineConfig> =
        folder.kins().map(configure).collect::<Result<_, ScoreError>>()?;
    let mut scores = Vec::with_capacity(detectors.len());
    let (done, pairs) = (AtomicUsize::new(0), detectors.len() * folder.all.len());
    for (nth, detector) in detectors.iter().enumerate() {
        // One that is refused is done as well.
        done.store(nth * folder.all.len(), Ordering::Relaxed);
        let more = || {
            let done = done.fetch_add(1, Ordering::Relaxed) + 1;
            if let Some(report) = task.watch.done {
                report(done, pairs);
            }
        };
        let score = score_with(*detector, &folder, &configured, task, &more).and_then(|score| {
            let (directory, guard_ms) = (directory.to_owned(), task.rules.guard_ms);
            score.ok_or(ScoreError::NoRest { directory, guard_ms })
        });
        match score {
            Err(error) if !error.is_of_one_detector() => return Err(error),
            score => scores.push(score),
        }
    }
    if scores.iter().any(Result::is_ok) {
        return Ok(scores);
    }
    scores.into_iter().map(|score| score.map(Ok)).collect()
}

/// `None` where there is no rest at all to measure the noise on, and it should be. `configured` has a pipeline for each
/// kin.
fn score_with(
    detector: Detector,
    folder: &Recordings,
    configured: &[PipelineConfig],
    task: &Task<'_>,
    done: &(dyn Fn() + Sync),
) -> Result<Option<Score>, ScoreError> {
    let Rules { guard_ms, floors } = task.rules;
    let change = |(first, configured): (_, &PipelineConfig)| Folds {
        folder,
        first,
        detector,
        pipeline: (detector.change)(*configured),
        rules: task.rules,
    };
    let kins: Vec<Folds<'_>> = folder.kins().zip(configured).map(change).collect();
    check_input(detector, &kins, &folder.all)?;
    let pooled = in_order(kins.iter().collect(), |kin| kin.pooled(task.config))?;
    let floorless = pooled.iter().all(|p| p.floor.is_none() && p.taxel_rms.is_none());
    let travel_alone = kins.iter().all(|k| k.pipeline.methods == Methods::only(Method::Travel));
    if floorless && floors == Floors::Folds && !travel_alone {
        return Ok(None);
    }
    let groups: BTreeSet<(usize, &str)> = folder.all.iter().map(Labelled::group).collect();
    let fit = |group: (usize, _)| {
        let folds = kins.get(group.0).map(|folds| folds.fitted(group.1)).transpose()?;
        Ok(folds.map(|fitted| (group, fitted)))
    };
    let groups = groups.into_iter().collect();
    let fitted: Result<Vec<_>, ScoreError> = match detector.decides {
        // What one of them learns from fills memory enough.
        Decides::Network => Vec::into_iter(groups).map(fit).collect(),
        _ => in_order(groups, fit),
    };
    let fitted: BTreeMap<_, Fitted> = fitted?.into_iter().flatten().collect();
    let judged = |one: &Labelled| {
        let Some(fitted) = fitted.get(&one.group()) else { return Ok(None) };
        let contents = folder.open(one)?;
        let began = task.watch.clock.map(|now| now());
        let judged = judge(one, &contents, fitted.clone(), guard_ms)?;
        let took = task.watch.clock.zip(began).map(|(now, began)| now().saturating_sub(began));
        let samples = contents.recording(detector.companions).samples.len();
        done();
        Ok(Some((judged, took.and_then(|took| per_sample_ns(took, samples)))))
    };
    let judged = match task.watch.clock {
        // Beside others a run time would be that of both.
        Some(_) => folder.all.iter().map(judged).collect::<Result<Vec<_>, _>>(),
        None => in_order(folder.all.iter().collect(), judged),
    };
    let (mut recordings, mut traces, mut causes) = (Vec::new(), Vec::new(), Causes::default());
    let mut ns_per_sample: Option<f64> = None;
    for (one, took_ns) in judged?.into_iter().flatten() {
        causes.add(&one.causes);
        recordings.extend(one.scores);
        traces.extend(one.traces);
        ns_per_sample = took_ns.into_iter().chain(ns_per_sample).reduce(f64::min);
    }
    let most = pooled.into_iter().max_by(|a, b| a.floor_s.total_cmp(&b.floor_s));
    let AtRest { floor, floor_s, taxel_rms, taxel_range, .. } = most.unwrap_or_default();
    Ok(Some(Score {
        detector,
        recordings,
        rates_hz: folder.kins().map(|first| first.rate_hz).collect(),
        floor,
        floor_s,
        taxel_rms,
        taxel_range,
        ns_per_sample,
        traces,
        causes,
    }))
}

/// What `work` makes of each, by all cores; the first fault in the order of `all`.
fn in_order<T: Send, U: Send>(
    all: Vec<T>,
    work: impl Fn(T) -> Result<U, ScoreError> + Sync + Send,
) -> Result<Vec<U>, ScoreError> {
    let done: Vec<Result<U, ScoreError>> = all.into_par_iter().map(work).collect();
    done.into_iter().collect()
}

/// A detector none of whose methods has its channel in any recording is refused.
fn check_input(detector: Detector, kins: &[Folds<'_>], all: &[Labelled]) -> Result<(), ScoreError> {
    if detector.decides == Decides::Own && all.iter().all(|one| one.own.is_none()) {
        let needs = "alarms.csv beside labels.csv (recording,begin_s,end_s)";
        return Err(ScoreError::NoInput { detector: detector.name, needs });
    }
    let has = |method| kins.iter().any(|kin| kin.pipeline.methods.has(method));
    let used = METHODS.into_iter().filter(|(method, _)| has(*method));
    let (mut missing, mut found) = (None, false);
    for (method, needs) in used {
        found |= all.iter().any(|one| one.serves(method, detector.companions));
        missing = missing.or(Some(needs));
    }
    match missing.filter(|_| !found) {
        Some(needs) => Err(ScoreError::NoInput { detector: detector.name, needs }),
        None => Ok(()),
    }
}

/// What each method looks at.
const METHODS: [(Method, &str); 3] = [
    (Method::Stylus, "a column `stylus` or `vibration`"),
    (Method::Travel, "a column `travel_m` or `travel_mm`, or NAME_pose.csv beside a recording"),
    (
        Method::Pressure,
        "taxels (columns `pressure_0`, `pressure_1`, .., or NAME_taxels.csv or NAME_electrodes.csv beside a recording)",
    ),
];

/// Time for a sample (ns); `None` of none.
fn per_sample_ns(took: Duration, samples: usize) -> Option<f64> {
    (samples > 0).then(|| 1e9 * took.as_secs_f64() / samples as f64)
}

/// Labelled recordings and a detector that is to judge those like `first` of each material by the others.
struct Folds<'a> {
    folder: &'a Recordings,
    first: &'a Labelled,
    detector: Detector,
    pipeline: PipelineConfig,
    rules: Rules,
}

impl<'a> Folds<'a> {
    /// What the rest of all that are alike shows, or what is known beforehand.
    fn pooled(&self, config: &HostConfig) -> Result<AtRest, ScoreError> {
        let Self { folder, detector, pipeline, rules, .. } = self;
        match (pipeline.known_floor, config.stylus_calibration(), rules.floors) {
            (Some(floor), Some(made), _) => {
                let floor_s = made.evidence.rest_s;
                Ok(AtRest { floor: Some(floor), floor_s, ..AtRest::default() })
            }
            (_, _, Floors::Live) => Ok(AtRest::default()),
            _ => AtRest::of(folder, self.alike(), *detector, pipeline, rules.guard_ms),
        }
    }

    /// The detector for the recordings of `material`, with floors and network of the others.
    fn fitted(&self, material: &str) -> Result<Fitted, ScoreError> {
        let Self { folder, detector, pipeline, rules, .. } = *self;
        let known = match rules.floors {
            Floors::Live => AtRest::default(),
            Floors::Folds => {
                AtRest::of(folder, self.others(material), detector, &pipeline, rules.guard_ms)?
            }
        };
        let config = known.known_to(pipeline);
        let test = match detector.decides {
            Decides::Pipeline | Decides::Own => None,
            Decides::Esc(reading) => Some(self.esc(reading)?),
            Decides::Network => Some(self.network(material, config)?),
        };
        let beside = test.map(|test| Beside::new(test, &config.detector));
        Ok(Fitted { detector, config, beside })
    }

    fn others(&self, material: &str) -> impl Iterator<Item = &'a Labelled> + Clone {
        self.alike().filter(move |other| other.label.material != material)
    }

    fn alike(&self) -> impl Iterator<Item = &'a Labelled> + Clone {
        let first = self.first;
        self.folder.all.iter().filter(|other| other.shares_rest(first))
    }

    fn esc(&self, reading: Reading) -> Result<Test, ScoreError> {
        let PipelineConfig { detector, sample_rate, .. } = &self.pipeline;
        let test = EscTest::new(reading, detector, sample_rate.0).map_err(|source| {
            ScoreError::Config { recording: "all recordings".to_owned(), source }
        })?;
        Ok(Test::Esc(Box::new(test)))
    }

    fn network(&self, material: &str, config: PipelineConfig) -> Result<Test, ScoreError> {
        let rows = training::rows(self.folder, self.others(material), config, self.rules.guard_ms)?;
        let network = SlipNetwork::train(&rows).map_err(|source| ScoreError::Untrained {
            material: material.to_owned(),
            detector: self.detector.name,
            source: Box::new(source),
        })?;
        Ok(Test::Network(NetworkTest::new(network)))
    }
}
