//! A recording, or what the model keeps of a live source, and a span in; a recording of that span out.

use super::{ExportError, fill};
use crate::model::{Model, Series};
use crate::{channel::Channel, span::Span};
use grip_record::mcap::{Attached, Entry, McapReader, McapWriter, Record, SampleRecord};
use slip_core::{Sample, units::Micros};
use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::BufWriter;
use std::path::Path;

/// Who writes.
const PROGRAM: &str = concat!("grip-scope ", env!("CARGO_PKG_VERSION"));
/// Title of the metadata of a slice.
const SLICE: &str = "slice";
/// Rows looked at once.
const MOST: usize = 20_000_000;

/// What a slice holds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sliced {
    /// Samples.
    pub samples: u64,
    /// Messages of all kinds, samples included.
    pub messages: u64,
}

/// Copies what the recording `from` holds between two device times (s) to `path`: messages as they are with their log times, the
/// attachments, and the settings of the pipeline that was running. States, events and all else go with the samples around them.
///
/// # Errors
/// Where the recording cannot be read up to there, holds no sample in the span, there is a file of the slice's name, or it cannot be written.
pub fn mcap_slice(from: &Path, span: Span, path: &Path) -> Result<Sliced, ExportError> {
    if fs::canonicalize(from).ok().is_some_and(|a| fs::canonicalize(path).ok() == Some(a)) {
        return Err(ExportError::Same { file: path.to_owned() });
    }
    fill(path, |file| {
        let mut slice = Slice::new((path, file), span)?;
        let mut reader = McapReader::open(from)?;
        while let Some(entry) = reader.next_entry()? {
            if !slice.take(&entry)? {
                break;
            }
        }
        slice.finish()
    })
}

struct Slice<'a> {
    path: &'a Path,
    span: Span,
    out: McapWriter<BufWriter<File>>,
    /// Log time of the file's begin (ns): the writer counts from it.
    inside: bool,
    /// The settings of the last pipeline, and its log time: they stand before the first sample.
    pipeline: Option<Held>,
    sliced: Sliced,
}

/// A pipeline's record, kept until it is needed.
struct Held {
    log_us: u64,
    config: String,
    record: grip_record::mcap::PipelineRecord<'static>,
}

impl<'a> Slice<'a> {
    fn new((path, file): (&'a Path, File), span: Span) -> Result<Self, ExportError> {
        // Log times of the slice are those of the recording: host time 0 is 1970.
        let out = McapWriter::new(BufWriter::new(file), PROGRAM, 0)
            .map_err(|source| ExportError::Record { file: path.to_owned(), source })?;
        let sliced = Sliced::default();
        Ok(Self { path, span, out, inside: false, pipeline: None, sliced })
    }

    /// Takes the next entry; `false` once the span is over.
    fn take(&mut self, entry: &Entry<'_>) -> Result<bool, ExportError> {
        match entry {
            Entry::Message { log_ns, record } => return self.message(log_ns / 1000, record),
            Entry::Attachment { name, media_type, data } => {
                let [name, media_type] = [name, media_type].map(|text| (*text).to_owned());
                let file = Attached { name, media_type, data: data.to_vec() };
                let attached = self.out.attach(0, &file);
                self.told(attached)?;
            }
            Entry::Metadata { name, values } => {
                let written = self.out.metadata(name, values);
                self.told(written)?;
            }
        }
        Ok(true)
    }

    fn message(&mut self, log_us: u64, record: &Record<'_>) -> Result<bool, ExportError> {
        match record {
            Record::Sample(row) => {
                let t_s = row.sample.t.as_seconds();
                if !self.inside && self.span.holds(t_s) {
                    self.inside = true;
                    self.begin()?;
                } else if self.inside && t_s > self.span.to_s {
                    return Ok(false);
                }
                self.sliced.samples += u64::from(self.inside);
            }
            Record::Pipeline(begun) if !self.inside => {
                let record = grip_record::mcap::PipelineRecord { config: "", ..*begun };
                self.pipeline = Some(Held { log_us, config: begun.config.to_owned(), record });
            }
            _ => {}
        }
        if self.inside {
            self.sliced.messages += 1;
            let written = self.out.write(log_us, record);
            self.told(written)?;
        }
        Ok(true)
    }

    /// The settings under which the first sample was taken.
    fn begin(&mut self) -> Result<(), ExportError> {
        let about = BTreeMap::from([
            ("from_s".to_owned(), self.span.from_s.to_string()),
            ("to_s".to_owned(), self.span.to_s.to_string()),
        ]);
        let written = self.out.metadata(SLICE, &about);
        self.told(written)?;
        let Some(held) = self.pipeline.take() else { return Ok(()) };
        // It has a past that is not in this file.
        let record = grip_record::mcap::PipelineRecord {
            continued: true,
            config: &held.config,
            ..held.record
        };
        self.sliced.messages += 1;
        let written = self.out.write(held.log_us, &Record::Pipeline(record));
        self.told(written)
    }

    fn told<T>(
        &self,
        done: Result<T, grip_record::mcap::McapWriteError>,
    ) -> Result<T, ExportError> {
        done.map_err(|source| ExportError::Record { file: self.path.to_owned(), source })
    }

    fn finish(self) -> Result<Sliced, ExportError> {
        if self.sliced.samples == 0 {
            return Err(ExportError::Empty);
        }
        let path = self.path;
        self.out
            .finish()
            .map_err(|source| ExportError::Record { file: path.to_owned(), source })?;
        Ok(self.sliced)
    }
}

/// Writes the samples that the model keeps of the span as a recording, for sources that are no file: samples, and the frames of the array
/// that are kept (at most a hundred a second); times as on the axis. Numbers of rows jump where samples are missing.
///
/// # Errors
/// Where there are none, they are thinned out, there is a file of this name, or it cannot be written.
pub fn mcap(model: &Model, span: Span, path: &Path) -> Result<Sliced, ExportError> {
    let Some(stylus) = model.series(Channel::Stylus) else { return Err(ExportError::Empty) };
    let rows = numbered(&kept(stylus, span)?, span);
    if rows.is_empty() {
        return Err(ExportError::Empty);
    }
    let mut columns = Vec::new();
    for channel in Channel::ROWS.into_iter().filter(|channel| *channel != Channel::Stylus) {
        let Some(series) = model.series(channel) else { continue };
        let mut points = kept(series, span)?;
        points.retain(|[t_s, value]| span.holds(*t_s) && !value.is_nan());
        columns.push((channel, points.into_iter().peekable()));
    }
    let failed = |source| ExportError::Record { file: path.to_owned(), source };
    fill(path, |file| {
        let mut out = McapWriter::new(BufWriter::new(file), PROGRAM, 0).map_err(failed)?;
        for &(index, [t_s, value]) in &rows {
            let mut sample = Sample::stylus(micros(t_s), single(value));
            for (channel, points) in &mut columns {
                while points.next_if(|point| point[0] < t_s - SAME_S).is_some() {}
                let found = points.next_if(|point| point[0] <= t_s + SAME_S);
                set(&mut sample, *channel, found.map(|point| single(point[1])));
            }
            let frame = model.taxels(t_s + SAME_S).filter(|frame| frame.t_s >= t_s - SAME_S);
            let taxels = frame.map_or(&[] as &[f32], |frame| &frame.values);
            let record = SampleRecord { index, sample, taxels };
            out.write(sample.t.0, &Record::Sample(record)).map_err(failed)?;
        }
        out.finish().map_err(failed)?;
        let samples = rows.len() as u64;
        Ok(Sliced { samples, messages: samples })
    })
}

/// Times that differ by less than this (s) are one row.
const SAME_S: f64 = 1e-6;

/// The samples of the span, a NaN where some are missing.
fn kept(series: &Series, span: Span) -> Result<Vec<[f64; 2]>, ExportError> {
    let mut points = Vec::new();
    if series.points(span, MOST, &mut points) { Ok(points) } else { Err(ExportError::Thin) }
}

/// The samples of the span with the numbers of their rows. Where samples are missing as many are left out as fit the time, and one where
/// none fits: what was broken must not join.
fn numbered(points: &[[f64; 2]], span: Span) -> Vec<(u32, [f64; 2])> {
    let step_s = median_step(points);
    let mut rows: Vec<(u32, [f64; 2])> = Vec::with_capacity(points.len());
    let mut broken = false;
    for &point in points.iter().filter(|point| span.holds(point[0])) {
        if point[1].is_nan() {
            broken = true;
            continue;
        }
        let index = rows.last().map_or(0, |(before, [before_s, _])| {
            let steps = if broken { steps((point[0] - before_s) / step_s).max(2) } else { 1 };
            before.saturating_add(steps)
        });
        broken = false;
        rows.push((index, point));
    }
    rows
}

/// The usual time between two samples (s).
fn median_step(points: &[[f64; 2]]) -> f64 {
    let mut steps: Vec<f64> =
        points.iter().zip(points.iter().skip(1)).map(|(a, b)| b[0] - a[0]).collect();
    steps.retain(|step_s| *step_s > 0.0);
    let middle = steps.len() / 2;
    if steps.is_empty() {
        return f64::INFINITY;
    }
    *steps.select_nth_unstable_by(middle, f64::total_cmp).1
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "the cast saturates")]
fn steps(count: f64) -> u32 {
    count.round() as u32
}

const fn set(sample: &mut Sample, channel: Channel, value: Option<f32>) {
    match channel {
        Channel::NormalForce => sample.normal_force_n = value,
        Channel::TangentialForce => sample.tangential_n = value,
        Channel::Travel => sample.travel_m = value,
        Channel::Velocity => sample.velocity_m_s = value,
        Channel::SecondStylus => sample.second_stylus = value,
        Channel::Reference => sample.reference = value,
        Channel::Pressure => sample.pressure = value,
        Channel::Motion => sample.motion = value,
        _ => {}
    }
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "the cast saturates")]
fn micros(t_s: f64) -> Micros {
    Micros((1e6 * t_s).round() as u64)
}

#[expect(clippy::cast_possible_truncation, reason = "it was kept as f32")]
fn single(value: f64) -> f32 {
    value as f32
}
