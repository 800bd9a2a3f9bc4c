//! Training data for the network of `nn`: what it may learn from labelled recordings.
//!
//! Rest up to onset - guard, slip from the onset on; what lies between may be either and is left out. A recording that slides from the
//! first sample on would learn its floor on the slide: it teaches only where the floor is known beforehand.

use super::{
    ScoreError,
    labelled::{Labelled, Recordings, rest_until},
    network_test::Rows,
};
use grip_record::LabelKind;
use grip_session::replay::Replay;
use slip_core::PipelineConfig;

/// Start of a recording that slides all the time, in which the filters settle (s).
const SETTLE_S: f64 = 0.02;

/// No block is longer (s): the rest is a gap.
const MOST_BLOCK_S: f64 = 0.05;

/// The levels of every block of `all`, recordings of the `folder`, that is labelled, seen with the floors of `config`.
pub(super) fn rows<'a>(
    folder: &Recordings,
    all: impl Iterator<Item = &'a Labelled>,
    config: PipelineConfig,
    guard_ms: f64,
) -> Result<Rows, ScoreError> {
    let mut rows = Rows::default();
    for one in all {
        let label = &one.label;
        if label.kind == LabelKind::Steady && config.known_floor.is_none() {
            continue;
        }
        let contents = folder.open(one)?;
        let recording = contents.recording(false);
        let first_s = recording.samples.first().map_or(0.0, |sample| sample.t.as_seconds());
        let until_s = rest_until(label, guard_ms);
        let from_s = match label.kind {
            LabelKind::Onset { at } => at.as_seconds(),
            LabelKind::Steady => first_s + SETTLE_S,
            LabelKind::Rest => f64::INFINITY,
        };
        let mut steps = Replay::new(recording, config, None)
            .map_err(|source| ScoreError::Config { recording: recording.name.clone(), source })?;
        let mut last_s = None;
        while let Some(step) = steps.next() {
            let (t_s, detector) = (step.t.as_seconds(), steps.detector());
            if detector.is_learning() || detector.in_block() {
                continue;
            }
            let block_s = last_s.replace(t_s).map_or(0.0, |last| t_s - last);
            if t_s < until_s {
                rows.push_rest(detector, block_s.min(MOST_BLOCK_S));
            } else if t_s >= from_s {
                rows.push_slip(detector);
            }
        }
    }
    Ok(rows)
}
