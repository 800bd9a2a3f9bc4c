//! Writer of samples to CSV files, one for each pipeline.

use super::{RecorderError, name};
use grip_record::{ChannelSet, CsvWriter, StylusKind};
use grip_session::session::Beginning;
use slip_core::Sample;
use std::{
    fs::File,
    io::{BufWriter, Write as _},
    path::{Path, PathBuf},
};

/// One CSV file.
#[derive(Debug)]
pub(super) struct Table {
    pub(super) file: PathBuf,
    pub(super) number: u32,
    out: Option<File>,
    sync: Option<File>,
    writer: Option<CsvWriter<BufWriter<File>>>,
    /// What the samples of its pipeline are.
    stylus: StylusKind,
    taxels: usize,
}

impl Table {
    /// Opens the first free file from `number` on.
    pub(super) fn open(wanted: &Path, number: u32) -> Result<Self, RecorderError> {
        let unwritable = |source| RecorderError::Create { file: wanted.to_owned(), source };
        let (out, file, number) = name::create(wanted, number).map_err(unwritable)?;
        let regular = out.metadata().map_err(unwritable)?.is_file();
        let sync = regular.then(|| out.try_clone()).transpose().map_err(unwritable)?;
        Ok(Self {
            file,
            number,
            out: Some(out),
            sync,
            writer: None,
            stylus: StylusKind::Displacement,
            taxels: 0,
        })
    }

    /// Whether a sample stands in it.
    pub(super) fn begun(&self) -> bool {
        self.writer.is_some()
    }

    /// A pipeline begins.
    pub(super) fn begin(&mut self, beginning: &Beginning) {
        self.taxels = beginning.taxels;
        self.stylus = beginning.stylus();
    }

    /// Every channel and every taxel has a column, used or not: a sensor may be silent at the first sample, and a replay knows
    /// by the column of the normal force that a controller ran.
    pub(super) fn sample(&mut self, sample: &Sample, frame: &[f32]) -> Result<(), RecorderError> {
        let failed = |source| RecorderError::Row { file: self.file.clone(), source };
        if let Some(out) = self.out.take() {
            let channels = ChannelSet::all(self.stylus).with_taxels(self.taxels).with_arrivals();
            let writer = CsvWriter::new(BufWriter::with_capacity(1 << 16, out), &channels);
            self.writer = Some(writer.map_err(failed)?);
        }
        match &mut self.writer {
            Some(writer) => writer.write_with(sample, frame).map_err(failed),
            None => Ok(()),
        }
    }

    pub(super) fn flush(&mut self) -> Result<(), RecorderError> {
        let failed = |source| RecorderError::Row { file: self.file.clone(), source };
        self.writer.as_mut().map_or(Ok(()), |writer| writer.flush().map_err(failed))
    }

    pub(super) fn sync(&mut self) -> std::io::Result<()> {
        self.sync.as_ref().map_or(Ok(()), File::sync_data)
    }

    pub(super) fn finish(self) -> Result<(), RecorderError> {
        let Some(writer) = self.writer else { return Ok(()) };
        let failed = |source| RecorderError::Row { file: self.file.clone(), source };
        writer.finish().and_then(|mut out| Ok(out.flush()?)).map_err(failed)
    }
}
