//! What the model keeps of a live source and a span in; a recording of that span out.

use super::pieces::{Rest, SAME_S};
use super::{ExportError, PROGRAM, Sliced, fill};
use crate::model::TaxelFrame;
use crate::{channel::Channel, model::Model, span::Span};
use core::ops::Deref;
use grip_record::mcap::{McapWriteError, McapWriter, Record, SampleRecord};
use grip_record::outputs::OutputFile;
use slip_core::{Sample, units::Micros};
use std::collections::BTreeMap;
use std::path::Path;

/// Steps from which on a piece shows the usual one.
const STEPS: usize = 16;

/// Writes the samples that the model keeps of the span as a recording, for sources that are no file: samples, and the frames of the array
/// that are kept (at most a hundred a second); times as on the axis. Numbers of rows jump where samples are missing. `look` lends the
/// model, each time for a piece of some thousand samples a channel, so that whoever fills or shows it goes on.
///
/// # Errors
/// Where there are none, they are dropped meanwhile, there is a file of this name, or it cannot be written.
pub fn mcap<G: Deref<Target = Model>>(
    look: impl Fn() -> G,
    span: Span,
    path: &Path,
) -> Result<Sliced, ExportError> {
    if look().series(Channel::Stylus).and_then(|stylus| stylus.stats(span)).is_none() {
        return Err(ExportError::Empty);
    }
    let failed = |source| ExportError::Record { file: path.to_owned(), source };
    fill(path, None, |file| {
        let mut out = McapWriter::new(file, PROGRAM, 0).map_err(failed)?;
        let mut rest = Rest::new(span, &look());
        let (mut piece, mut numbers, mut samples) = (Piece::default(), Numbers::default(), 0);
        while piece.copy(&look(), &mut rest)? {
            samples += piece.write(&mut numbers, &mut out).map_err(failed)?;
        }
        out.finish().map_err(failed)?;
        if samples == 0 {
            Err(ExportError::Empty)
        } else {
            Ok(Sliced { samples, messages: samples, damaged: 0 })
        }
    })
}

/// What was copied at one look.
#[derive(Default)]
struct Piece {
    columns: BTreeMap<Channel, Vec<[f64; 2]>>,
    frames: Vec<TaxelFrame>,
}

impl Piece {
    /// Copies the next piece; `false` behind the last one.
    fn copy(&mut self, model: &Model, rest: &mut Rest) -> Result<bool, ExportError> {
        let Some(span) = rest.next(model, Channel::ROWS.into_iter())? else { return Ok(false) };
        for series in Channel::ROWS.into_iter().filter_map(|channel| model.series(channel)) {
            series.copy(span, self.columns.entry(series.channel()).or_default());
        }
        self.frames.clear();
        self.frames.extend(model.taxel_frames(span).cloned());
        Ok(true)
    }

    /// Writes the rows of the piece: how many.
    fn write(
        &self,
        numbers: &mut Numbers,
        out: &mut McapWriter<&mut OutputFile>,
    ) -> Result<u64, McapWriteError> {
        let stylus = self.columns.get(&Channel::Stylus).map_or(&[] as &[_], Vec::as_slice);
        let mut others: Vec<(grip_record::Channel, Column<'_>)> = Vec::new();
        for (channel, points) in &self.columns {
            others.extend(channel.recorded().map(|channel| (channel, Column { points })));
        }
        let mut frames = self.frames.as_slice();
        let mut rows = 0;
        for (index, [t_s, value]) in numbers.rows(stylus) {
            let mut sample = Sample::stylus(micros(t_s), single(value));
            for (channel, column) in &mut others {
                channel.set(&mut sample, column.take(t_s));
            }
            let taxels = frame_at(&mut frames, t_s);
            out.write(sample.t.0, &Record::Sample(SampleRecord { index, sample, taxels }))?;
            rows += 1;
        }
        Ok(rows)
    }
}

/// Samples of a channel in order of time.
struct Column<'a> {
    points: &'a [[f64; 2]],
}

impl Column<'_> {
    /// The sample at this time, where there is one that is a number.
    fn take(&mut self, t_s: f64) -> Option<f32> {
        while let [[at_s, value], rest @ ..] = self.points {
            if *at_s > t_s + SAME_S {
                return None;
            }
            self.points = rest;
            if *at_s >= t_s - SAME_S && !value.is_nan() {
                return Some(single(*value));
            }
        }
        None
    }
}

/// The frame at this time; empty where there is none.
fn frame_at<'a>(frames: &mut &'a [TaxelFrame], t_s: f64) -> &'a [f32] {
    while let [frame, rest @ ..] = *frames {
        if frame.t_s > t_s + SAME_S {
            return &[];
        }
        *frames = rest;
        if frame.t_s >= t_s - SAME_S {
            return &frame.values;
        }
    }
    &[]
}

/// Numbers of rows, from piece to piece.
#[derive(Default)]
struct Numbers {
    last: Option<(u32, f64)>,
    broken: bool,
    /// The usual time between two samples (s).
    step_s: Option<f64>,
}

impl Numbers {
    /// The samples with the numbers of their rows. Where samples are missing (a NaN) as many are left out as fit the time, and one where
    /// none fits: what was broken must not join.
    fn rows(&mut self, points: &[[f64; 2]]) -> Vec<(u32, [f64; 2])> {
        self.step_s = median_step(points, self.step_s).or(self.step_s);
        let mut rows = Vec::with_capacity(points.len());
        for &point in points {
            if point[1].is_nan() {
                self.broken = true;
                continue;
            }
            let index =
                self.last.map_or(0, |(before, before_s)| self.after(before, before_s, point[0]));
            self.broken = false;
            self.last = Some((index, point[0]));
            rows.push((index, point));
        }
        rows
    }

    fn after(&self, before: u32, before_s: f64, t_s: f64) -> u32 {
        let missing = self.step_s.map_or(0.0, |step_s| (t_s - before_s) / step_s);
        before.saturating_add(if self.broken { steps(missing).max(2) } else { 1 })
    }
}

/// The usual time between two samples (s); a few of them show nothing where it is `known`.
fn median_step(points: &[[f64; 2]], known: Option<f64>) -> Option<f64> {
    let mut steps: Vec<f64> =
        points.iter().zip(points.iter().skip(1)).map(|(a, b)| b[0] - a[0]).collect();
    steps.retain(|step_s| *step_s > 0.0);
    if steps.is_empty() || (known.is_some() && steps.len() < STEPS) {
        return None;
    }
    let middle = steps.len() / 2;
    Some(*steps.select_nth_unstable_by(middle, f64::total_cmp).1)
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "the cast saturates")]
fn steps(count: f64) -> u32 {
    count.round() as u32
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "the cast saturates")]
fn micros(t_s: f64) -> Micros {
    Micros((1e6 * t_s).round() as u64)
}

#[expect(clippy::cast_possible_truncation, reason = "it was kept as f32")]
fn single(value: f64) -> f32 {
    value as f32
}
