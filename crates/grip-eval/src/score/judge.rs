//! One labelled recording in, its alarms held against its label out.

use super::{
    Alarm, Detector, LATE_S, RecordingScore, ScoreError,
    beside::{Beside, Change},
    causes::{CLOSING, Causes, MOVING, STILL},
    curve::Trace,
    labelled::{Labelled, rest_until},
};
use grip_record::{LabelKind, Recording};
use grip_session::replay::Replay;
use slip_core::{
    Phase, PipelineConfig, SlipReport, Step, detector::FloorHealth, pressure::Standing,
    sample::Scene, units::Micros,
};

/// A longer step, in periods, is a gap.
const LONGEST_STEP: f64 = 1.5;

/// A detector with what it may know of the recording that is judged.
#[derive(Clone, Debug)]
pub(super) struct Fitted {
    pub(super) detector: Detector,
    pub(super) config: PipelineConfig,
    /// What decides instead of the pipeline.
    pub(super) beside: Option<Beside>,
}

/// What one recording showed.
pub(super) struct Judged {
    pub(super) score: RecordingScore,
    pub(super) trace: Trace,
    pub(super) causes: Causes,
}

/// What became of the recording, the statistic it showed, and its false alarms by cause.
pub(super) fn judge(one: &Labelled, fitted: Fitted, guard_ms: f64) -> Result<Judged, ScoreError> {
    let Labelled { label, travel, .. } = one;
    let detector = fitted.detector;
    let recording = one.recording(detector.companions);
    let Played { spans, statistics, causes, length_s, reported_s } =
        play(one, recording, fitted, guard_ms)?;
    let rest_until_s = rest_until(label, guard_ms);
    let trace = Trace::new(label.kind, rest_until_s, &statistics);
    let first_s = recording.samples.first().map_or(0.0, |s| s.t.as_seconds());
    let alarms = spans.iter().map(|span| Alarm {
        t_s: span.from.as_seconds(),
        end_s: span.to.map(Micros::as_seconds),
        cause: span.cause.clone(),
        is_false: span.from.as_seconds() < rest_until_s,
    });
    let mut score = RecordingScore {
        detector: detector.name,
        recording: label.recording.clone(),
        kind: label.kind.word(),
        material: label.material.clone(),
        onset_s: None,
        alarm_s: spans.first().map(|span| span.from.as_seconds()),
        latency_ms: None,
        missed: false,
        early: false,
        travel_mm: None,
        alarms: u32::try_from(spans.len()).unwrap_or(u32::MAX),
        alarms_at: alarms.collect(),
        window_s: 0.0,
        reported_s,
        length_s,
    };
    let mut counts = None;
    match label.kind {
        LabelKind::Rest => {}
        LabelKind::Steady => {
            counts = spans.first().map(|span| span.from);
            score.missed = counts.is_none();
            score.latency_ms = counts.map(|t| 1e3 * (t.as_seconds() - first_s));
            score.window_s = length_s;
        }
        LabelKind::Onset { at } => {
            let onset = at.as_seconds();
            let in_time = |t: f64| (rest_until_s..=onset + LATE_S).contains(&t);
            counts = spans.iter().map(|span| span.from).find(|t| in_time(t.as_seconds()));
            let going_on = spans.iter().any(|span| {
                let ends = span.to.is_none_or(|to| to.as_seconds() >= rest_until_s);
                span.from.as_seconds() < rest_until_s && ends
            });
            let last_s = recording.samples.last().map_or(0.0, |s| s.t.as_seconds());
            score.window_s = (onset + LATE_S).min(last_s) - rest_until_s.max(first_s);
            score.onset_s = Some(onset);
            score.early = spans.first().is_some_and(|span| span.from.as_seconds() < rest_until_s);
            score.missed = counts.is_none() && !going_on;
            score.latency_ms = counts.map(|t| 1e3 * (t.as_seconds() - onset));
        }
    }
    score.travel_mm = counts.and_then(|t| travel.as_ref()?.travel_at(t));
    Ok(Judged { score, trace, causes })
}

/// A slip from its first notice to its end.
struct Span {
    from: Micros,
    to: Option<Micros>,
    cause: String,
}

struct Played {
    spans: Vec<Span>,
    /// The statistic at every time (s).
    statistics: Vec<(f64, f32)>,
    causes: Causes,
    /// Time in which there were samples (s).
    length_s: f64,
    /// Of it with a slip, or with a floor that never saw rest (s).
    reported_s: f64,
}

/// What a detector shows with a sample.
struct Shown {
    statistic: f32,
    change: Option<Change>,
    slips: bool,
}

impl Shown {
    /// What the pipeline itself decides.
    fn of(step: &Step) -> Self {
        let change = match step.event {
            Some(SlipReport { first: true, .. }) => Some(Change::Begins),
            Some(SlipReport { phase: Phase::Ended, .. }) => Some(Change::Ends),
            _ => None,
        };
        Self { statistic: step.statistic, change, slips: step.scene == Scene::Slipping }
    }
}

fn play(
    one: &Labelled,
    recording: &Recording,
    Fitted { config, mut beside, .. }: Fitted,
    guard_ms: f64,
) -> Result<Played, ScoreError> {
    let mut steps = Replay::new(recording, config, None)
        .map_err(|source| ScoreError::Config { recording: recording.name.clone(), source })?;
    let until_s = rest_until(&one.label, guard_ms);
    // What no sample covers is no time in which an alarm could have come.
    let longest_s = LONGEST_STEP / f64::from(recording.rate_hz);
    let statistics = Vec::with_capacity(recording.samples.len());
    let mut played = Played {
        spans: Vec::new(),
        statistics,
        causes: Causes::default(),
        length_s: 0.0,
        reported_s: 0.0,
    };
    let (mut moving, mut last_s) = (false, None);
    let (array, mut standing) = (recording.taxels.is_some(), Standing::default());
    for sample in &recording.samples {
        let Some(step) = steps.next() else { break };
        let t_s = step.t.as_seconds();
        let Shown { statistic, change, slips } = match &mut beside {
            None => Shown::of(&step),
            Some(beside) => {
                let (statistic, change) = beside.step(sample, steps.detector());
                Shown { statistic, change, slips: beside.slips() }
            }
        };
        played.statistics.push((t_s, statistic));
        let dt_s = last_s.replace(t_s).map_or(0.0, |last| (t_s - last).min(longest_s));
        played.length_s += dt_s;
        if slips || step.floor_health == FloorHealth::Doubtful {
            played.reported_s += dt_s;
        }
        match step.scene {
            Scene::Slipping => {}
            scene => moving = scene == Scene::Moving,
        }
        let closing = array && !standing.step(sample.t, sample.normal_force_n);
        let seen = match (closing, moving) {
            (true, _) => CLOSING,
            (_, true) => MOVING,
            _ => STILL,
        };
        let cause = Causes::at(&one.phases, step.t, seen);
        if t_s < until_s {
            played.causes.add_time(cause, dt_s);
        }
        match (change, played.spans.last_mut()) {
            (Some(Change::Begins), _) => {
                if t_s < until_s {
                    played.causes.add_alarm(cause);
                }
                let cause = cause.to_owned();
                played.spans.push(Span { from: step.t, to: None, cause });
            }
            (Some(Change::Ends), Some(span)) => span.to = Some(step.t),
            _ => {}
        }
    }
    Ok(played)
}
