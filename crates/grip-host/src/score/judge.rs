//! One labelled recording in, its alarms held against its label out.

use super::{
    Detector, LATE_S, RecordingScore, ScoreError,
    curve::Trace,
    labelled::{Labelled, rest_until},
};
use crate::replay::Replay;
use grip_record::{LabelKind, Recording};
use slip_core::{PipelineConfig, SlipEvent, units::Micros};

/// What became of the recording, and the statistic it showed.
pub(super) fn judge(
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
