//! A recording of a span of another one.

use super::{ExportError, PROGRAM, Sliced, fill};
use crate::damage::Damage;
use crate::model::{Axis, Placed};
use crate::span::Span;
use grip_record::mcap::{
    Attached, Entry, McapIndex, McapReader, McapWriteError, McapWriter, PipelineRecord, Record,
};
use grip_record::outputs::OutputFile;
use std::collections::BTreeMap;
use std::fs::File;
use std::path::Path;

/// Title of the metadata of a slice.
const SLICE: &str = "slice";

/// Copies what the recording `from` holds in a span of the axis, where the model shows it, to `path`: messages as they are with their log
/// times, the attachments, and the settings of the pipeline that was running. States, events and all else go with the samples around
/// them. Device times stay as they are in the file: where they went back, the axis does not show them so. Damaged parts of the recording are
/// passed over as the scope itself does, and counted where they lie in the span.
///
/// # Errors
/// Where the recording cannot be opened, or not be read up to there, holds no sample in the span, there is a file of the slice's name, or it cannot be written.
pub fn mcap_slice(from: &Path, span: Span, path: &Path) -> Result<Sliced, ExportError> {
    fill(path, Some(from), |file| {
        // Log times of the slice are those of the recording: host time 0 is 1970.
        let mut slice = Slice::new(McapWriter::new(file, PROGRAM, 0)?, span);
        let mut reader = McapReader::open(from)?;
        // Without an index damage is passed over as far as the file itself reports where it ends.
        let index = File::open(from).ok().and_then(|file| McapIndex::read(file).ok().flatten());
        let mut damage = Damage::default();
        loop {
            match reader.next_entry() {
                Ok(Some(entry)) if slice.take(&entry)? => {}
                Ok(_) => break,
                Err(error) if error.damaged_at().is_none() => return Err(error.into()),
                Err(error) => {
                    let (more, new) = damage.pass(error, &mut reader, index.as_ref());
                    slice.damaged(u32::from(!more || new.is_some()));
                    if !more {
                        break;
                    }
                }
            }
        }
        if slice.sliced.samples == 0 {
            // Damage is why nothing was found, where there is any.
            return Err(damage.end.or(damage.first).map_or(ExportError::Empty, ExportError::Read));
        }
        slice.out.finish()?;
        Ok(slice.sliced)
    })
}

struct Slice<'a> {
    span: Span,
    /// Where the model puts the rows.
    axis: Axis,
    out: McapWriter<&'a mut OutputFile>,
    /// The first sample of the span was seen.
    inside: bool,
    /// The settings of the last pipeline, and its log time: they stand before the first sample.
    pipeline: Option<Held>,
    sliced: Sliced,
}

/// A pipeline's record, kept until it is needed.
struct Held {
    log_us: u64,
    config: String,
    record: PipelineRecord<'static>,
}

impl<'a> Slice<'a> {
    fn new(out: McapWriter<&'a mut OutputFile>, span: Span) -> Self {
        let (axis, sliced) = (Axis::default(), Sliced::default());
        Self { span, axis, out, inside: false, pipeline: None, sliced }
    }

    /// Takes the next entry; `false` once the span is over.
    fn take(&mut self, entry: &Entry<'_>) -> Result<bool, McapWriteError> {
        match entry {
            Entry::Message { log_ns, record } => return self.message(log_ns / 1000, record),
            Entry::Attachment { name, media_type, data } => {
                let [name, media_type] = [name, media_type].map(String::clone);
                let file = Attached { name, media_type, data: data.to_vec() };
                self.out.attach(0, &file)?;
            }
            Entry::Metadata { name, values } => {
                self.out.metadata(name, values)?;
            }
        }
        Ok(true)
    }

    fn message(&mut self, log_us: u64, record: &Record<'_>) -> Result<bool, McapWriteError> {
        match record {
            Record::Sample(row) => {
                let at_s = match self.axis.row(row.sample.t.as_seconds()) {
                    Placed::At(at_s) | Placed::Leapt { at_s, .. } => Some(at_s),
                    // A row out of order goes with those around it.
                    Placed::Late => None,
                };
                // The axis never goes back.
                if at_s.is_some_and(|at_s| at_s > self.span.to_s) {
                    return Ok(false);
                }
                if !self.inside && at_s.is_some_and(|at_s| self.span.holds(at_s)) {
                    self.inside = true;
                    self.begin()?;
                }
                self.sliced.samples += u64::from(self.inside);
            }
            Record::Pipeline(begun) if !self.inside => {
                let record = PipelineRecord { config: "", ..*begun };
                self.pipeline = Some(Held { log_us, config: begun.config.to_owned(), record });
            }
            _ => {}
        }
        if self.inside {
            self.sliced.messages += 1;
            self.out.write(log_us, record)?;
        }
        Ok(true)
    }

    /// The settings under which the first sample was taken.
    fn begin(&mut self) -> Result<(), McapWriteError> {
        let about = BTreeMap::from([
            ("from_s".to_owned(), self.span.from_s.to_string()),
            ("to_s".to_owned(), self.span.to_s.to_string()),
        ]);
        self.out.metadata(SLICE, &about)?;
        let Some(held) = self.pipeline.take() else { return Ok(()) };
        // It has a past that is not in this file.
        let record = PipelineRecord { continued: true, config: &held.config, ..held.record };
        self.sliced.messages += 1;
        self.out.write(held.log_us, &Record::Pipeline(record))
    }

    /// Parts that cannot be read; those before the span are nobody's loss.
    fn damaged(&mut self, parts: u32) {
        if self.inside {
            self.sliced.damaged += parts;
        }
    }
}
