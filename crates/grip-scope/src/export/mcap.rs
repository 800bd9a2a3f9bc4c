//! A recording of what the model keeps of a live source.

use super::part::{Part, SAME_S};
use super::{ExportError, PROGRAM, Sliced, fill};
use crate::channel::Channel;
use crate::model::TaxelFrame;
use crate::num;
use grip_record::mcap::{McapWriteError, McapWriter, Record, SampleRecord};
use grip_record::outputs::OutputFile;
use slip_core::{Sample, units::Micros};
use std::path::Path;

/// Of how many steps between samples the usual one is a mean.
const STEPS: f64 = 16.0;

/// Writes the samples of [`Channel::ROWS`] as a recording, for sources that are no file, with the frames of the array that are kept (at most a
/// hundred a second); times as on the axis. Numbers of rows jump where samples are missing.
///
/// # Errors
/// Where there are none, there is a file of this name, or it cannot be written.
pub fn mcap(part: Part, path: &Path) -> Result<Sliced, ExportError> {
    if part.columns.first().is_none_or(|column| column.channel != Channel::Stylus) {
        return Err(ExportError::Empty);
    }
    fill(path, None, |file| {
        let samples = write(part, file)?;
        Ok(Sliced { samples, messages: samples, damaged: 0 })
    })
}

fn write(mut part: Part, file: &mut OutputFile) -> Result<u64, McapWriteError> {
    let mut out = McapWriter::new(file, PROGRAM, 0)?;
    let mut frames = part.frames.as_slice();
    let [stylus, others @ ..] = part.columns.as_mut_slice() else { return Ok(0) };
    let (mut numbers, mut samples) = (Numbers::default(), 0);
    while let Some(t_s) = stylus.next_s() {
        let Some((value, broken)) = stylus.take(t_s) else { break };
        let mut sample = Sample::stylus(Micros::from_seconds(t_s), value);
        for column in &mut *others {
            if let Some(channel) = column.channel.recorded() {
                channel.set(&mut sample, column.take(t_s).map(|(value, _)| value));
            }
        }
        let (index, taxels) = (numbers.next(t_s, broken), frame_at(&mut frames, t_s));
        out.write(sample.t.0, &Record::Sample(SampleRecord { index, sample, taxels }))?;
        samples += 1;
    }
    out.finish()?;
    Ok(samples)
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

/// Numbers of rows.
#[derive(Default)]
struct Numbers {
    last: Option<(u32, f64)>,
    /// The usual time between two samples (s).
    step_s: Option<f64>,
}

impl Numbers {
    /// The number of the row at this time. Where samples are missing before it as many numbers are left out as fit the time, and one where
    /// none fits: what was broken must not join.
    fn next(&mut self, t_s: f64, broken: bool) -> u32 {
        let index = self.last.map_or(0, |(before, before_s)| {
            let since_s = t_s - before_s;
            if broken {
                let missing = self.step_s.map_or(0.0, |step_s| (since_s / step_s).round());
                let missing = u32::try_from(num::whole(missing)).unwrap_or(u32::MAX);
                return before.saturating_add(missing.max(2));
            }
            let step_s = self.step_s.get_or_insert(since_s);
            *step_s += (since_s - *step_s) / STEPS;
            before.saturating_add(1)
        });
        self.last = Some((index, t_s));
        index
    }
}
