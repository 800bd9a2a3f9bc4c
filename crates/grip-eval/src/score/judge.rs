//! Comparison of the alarms in one labelled recording with its label.

use super::{
    Alarm, Decides, Detector, FileNotes, FloorFrom, LATE_S, RecordingScore, ScoreError,
    beside::{Beside, Change, Test},
    causes::{CLOSING, Causes, MOVING, STILL, UNKNOWN},
    curve::{APART_S, Trace},
    labelled::{Contents, Labelled, rest_until},
};
use grip_record::{LabelKind, Recording};
use grip_session::replay::Replay;
use slip_core::{
    Phase, PipelineConfig, Sample, SlipReport, Step, detector::FloorHealth, pressure::Standing,
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
    /// Of each slip that is labelled in it; of the recording, where none or one is.
    pub(super) scores: Vec<RecordingScore>,
    pub(super) traces: Vec<Trace>,
    pub(super) causes: Causes,
}

/// What became of the recording, the statistic it showed, and its false alarms by cause.
pub(super) fn judge(
    one: &Labelled,
    contents: &Contents,
    fitted: Fitted,
    guard_ms: f64,
) -> Result<Judged, ScoreError> {
    let (label, travel) = (&one.label, &contents.travel);
    let detector = fitted.detector;
    let recording = contents.recording(detector.companions);
    let known = fitted.config;
    let is_known = known.known_floor.is_some() || known.pressure.known_rms.is_some();
    let Played { spans, statistics, causes, length_s, reported_s, in_alarm_s, learning } =
        play(one, recording, fitted, guard_ms)?;
    let rest_until_s = rest_until(label, guard_ms);
    let time_s = |at: Option<&Sample>| at.map_or(0.0, |sample| sample.t.as_seconds());
    let (first_s, last_s) = (time_s(recording.samples.first()), time_s(recording.samples.last()));
    let alarms = spans.iter().map(|span| Alarm {
        t_s: span.from.as_seconds(),
        end_s: span.to.map(Micros::as_seconds),
        cause: span.cause.clone(),
        is_false: span.from.as_seconds() < rest_until_s,
    });
    let travel_at = |t: Option<Micros>| travel.as_ref()?.travel_at(t?);
    let mut whole = RecordingScore {
        detector: detector.name,
        recording: label.recording.clone(),
        slip: 1,
        kind: label.kind.word(),
        material: label.material.clone(),
        onset_s: None,
        alarm_s: spans.first().map(|span| span.from.as_seconds()),
        latency_ms: None,
        missed: false,
        inside: false,
        early: false,
        travel_mm: None,
        alarms: u32::try_from(spans.len()).unwrap_or(u32::MAX),
        alarms_at: alarms.collect(),
        window_s: 0.0,
        rate_hz: recording.rate_hz,
        floor_from: if is_known { FloorFrom::Known } else { FloorFrom::Own },
        learning,
        reported_s,
        in_alarm_s,
        length_s,
        file: FileNotes { remarks: recording.notes.remarks.clone(), cut: recording.notes.cut },
    };
    let windows = windows(one, guard_ms);
    if windows.is_empty() {
        if label.kind == LabelKind::Steady {
            let counts = spans.first().map(|span| span.from);
            whole.missed = counts.is_none();
            whole.latency_ms = counts.map(|t| 1e3 * (t.as_seconds() - first_s));
            whole.window_s = length_s;
            whole.travel_mm = travel_at(counts);
        }
        let traces = vec![Trace::new(label.kind, rest_until_s, &statistics)];
        return Ok(Judged { scores: vec![whole], traces, causes });
    }
    whole.early = whole.alarm_s.is_some_and(|alarm_s| alarm_s < rest_until_s);
    let (mut scores, mut traces) = (Vec::new(), Vec::new());
    for (slip, window) in (1..).zip(windows) {
        let Window { onset, from_s, until_s, ends_s } = window;
        // The rest before the first slip, and all alarms, are its.
        let shown_from_s = if slip == 1 { f64::NEG_INFINITY } else { from_s };
        let further = || RecordingScore { slip, ..whole.without_alarms() };
        let mut score = if slip == 1 { whole.clone() } else { further() };
        let counts = window.first_alarm(&spans);
        score.onset_s = Some(onset.as_seconds());
        score.inside = counts.is_none() && window.is_reached(&spans);
        score.missed = counts.is_none() && !score.inside;
        score.latency_ms = counts.map(|t| 1e3 * (t.as_seconds() - onset.as_seconds()));
        score.travel_mm = travel_at(counts);
        score.window_s = until_s.min(last_s) - from_s.max(first_s);
        if slip > 1 {
            score.alarm_s = counts.map(Micros::as_seconds);
        }
        let at = |limit_s: f64| statistics.partition_point(|(t_s, _)| *t_s < limit_s);
        let shown = statistics.get(at(shown_from_s)..at(ends_s)).unwrap_or(&[]);
        let before = statistics.get(at(from_s - APART_S)..at(from_s)).unwrap_or(&[]);
        let trace = Trace::new(LabelKind::Onset { at: onset }, from_s, shown);
        traces.push(trace.with_before(before));
        scores.push(score);
    }
    Ok(Judged { scores, traces, causes })
}

/// When an alarm finds a slip (s).
#[derive(Clone, Copy)]
struct Window {
    onset: Micros,
    from_s: f64,
    /// The last time that counts; and where the next slip may be found.
    until_s: f64,
    ends_s: f64,
}

impl Window {
    fn first_alarm(&self, spans: &[Span]) -> Option<Micros> {
        let in_time = |t: &Micros| (self.from_s..=self.until_s).contains(&t.as_seconds());
        spans.iter().map(|span| span.from).find(in_time)
    }

    /// Whether an alarm of before is still going on.
    fn is_reached(&self, spans: &[Span]) -> bool {
        spans.iter().any(|span| {
            let ends = span.to.is_none_or(|to| to.as_seconds() >= self.from_s);
            span.from.as_seconds() < self.from_s && ends
        })
    }
}

/// One for each labelled onset.
fn windows(one: &Labelled, guard_ms: f64) -> Vec<Window> {
    let onsets: Vec<Micros> = one.onsets().collect();
    let begins = |onset: &Micros| onset.as_seconds() - 1e-3 * guard_ms;
    let window = |(nth, onset): (usize, &Micros)| {
        let ends_s = onsets.get(nth + 1).map_or(f64::INFINITY, begins);
        let until_s = (onset.as_seconds() + LATE_S).min(ends_s);
        Window { onset: *onset, from_s: begins(onset), until_s, ends_s }
    };
    onsets.iter().enumerate().map(window).collect()
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
    /// Of it with an alarm (s).
    in_alarm_s: f64,
    /// Whether the floor was not known at its end, and is needed.
    learning: bool,
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
    Fitted { detector, config, mut beside }: Fitted,
    guard_ms: f64,
) -> Result<Played, ScoreError> {
    if let Some(own) = one.own.as_ref().filter(|_| detector.decides == Decides::Own) {
        beside = Some(Beside::new(Test::Own(own.clone().into()), &config.detector));
    }
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
        in_alarm_s: 0.0,
        learning: false,
    };
    let (mut moving, mut last_s) = (false, None);
    let shows_motion = |sample: &Sample| sample.reference.is_some() || sample.motion.is_some();
    let still = if recording.samples.iter().any(shows_motion) { STILL } else { UNKNOWN };
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
        let in_alarm_s = if slips { dt_s } else { 0.0 };
        played.in_alarm_s += in_alarm_s;
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
            _ => still,
        };
        let cause = Causes::at(&one.phases, step.t, seen);
        if t_s < until_s {
            played.causes.add_time(cause, dt_s, in_alarm_s);
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
    played.learning = detector.decides != Decides::Own && steps.is_learning();
    Ok(played)
}
