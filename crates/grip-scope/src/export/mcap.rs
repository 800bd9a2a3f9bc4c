//! A recording, or what the model keeps of a live source, and a span in; a recording of that span out.

use super::ExportError;
use crate::{channel::Channel, model::Model, span::Span};
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
/// Where the recording cannot be read up to there, holds no sample in the span, or the slice cannot be written.
pub fn mcap_slice(from: &Path, span: Span, path: &Path) -> Result<Sliced, ExportError> {
    if fs::canonicalize(from).ok().is_some_and(|a| fs::canonicalize(path).ok() == Some(a)) {
        return Err(ExportError::Same { file: path.to_owned() });
    }
    let written = (|| {
        let mut slice = Slice::new(path, span)?;
        let mut reader = McapReader::open(from)?;
        while let Some(entry) = reader.next_entry()? {
            if !slice.take(&entry)? {
                break;
            }
        }
        slice.finish()
    })();
    if written.is_err() {
        // A slice without its end would look like a recording that was cut off.
        let _gone = fs::remove_file(path);
    }
    written
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
    fn new(path: &'a Path, span: Span) -> Result<Self, ExportError> {
        let file = File::create(path)
            .map_err(|source| ExportError::Write { file: path.to_owned(), source })?;
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

/// Writes the samples that the model keeps of the span as a recording, for sources that are no file: samples only, times as on the axis.
///
/// # Errors
/// Where there are none, they are thinned out, or the file cannot be written.
pub fn mcap(model: &Model, span: Span, path: &Path) -> Result<Sliced, ExportError> {
    let mut columns = Vec::new();
    for channel in Channel::ROWS {
        let Some(series) = model.series(channel) else { continue };
        let mut points = Vec::new();
        if !series.points(span, MOST, &mut points) {
            return Err(ExportError::Thin);
        }
        points.retain(|[t_s, value]| span.holds(*t_s) && !value.is_nan());
        columns.push((channel, points.into_iter().peekable()));
    }
    let styli = columns.iter().position(|(channel, _)| *channel == Channel::Stylus);
    let Some((_, stylus)) = styli.map(|at| columns.remove(at)) else {
        return Err(ExportError::Empty);
    };
    let failed = |source| ExportError::Record { file: path.to_owned(), source };
    let file = File::create(path)
        .map_err(|source| ExportError::Write { file: path.to_owned(), source })?;
    let mut out = McapWriter::new(BufWriter::new(file), PROGRAM, 0).map_err(failed)?;
    let mut samples = 0_u32;
    for [t_s, value] in stylus {
        let mut sample = Sample::stylus(micros(t_s), single(value));
        for (channel, points) in &mut columns {
            while points.next_if(|point| point[0] < t_s - 1e-6).is_some() {}
            let found = points.next_if(|point| point[0] <= t_s + 1e-6);
            set(&mut sample, *channel, found.map(|point| single(point[1])));
        }
        let record = SampleRecord { index: samples, sample, taxels: &[] };
        out.write(sample.t.0, &Record::Sample(record)).map_err(failed)?;
        samples += 1;
    }
    out.finish().map_err(failed)?;
    if samples == 0 {
        return Err(ExportError::Empty);
    }
    Ok(Sliced { samples: samples.into(), messages: samples.into() })
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
