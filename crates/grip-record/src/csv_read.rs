//! A CSV recording in, its samples and what is odd about them out.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use slip_core::sample::Sample;
use slip_core::units::Micros;

use crate::channels::Scale;
use crate::error::CsvError;
use crate::files;
use crate::number::parse_reading;
use crate::recording::{Cells, Gathering, Recording};
use crate::table::{Row, Table};

/// What the file itself does not show.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CsvOptions {
    /// Samples per second, 0.001 to 1e6 Hz. Needed without a time column (t = i / rate); beside one it is the
    /// rate reported, and the file's times stay.
    pub rate_hz: Option<f32>,
    /// Renamings: (known name, the file's column); see [`COLUMN_NAMES`](crate::COLUMN_NAMES).
    pub map: Vec<(String, String)>,
}

/// Reads the recording in `file`, line by line: only its samples are held, at most [`MOST_HELD`](crate::MOST_HELD) bytes.
///
/// # Errors
/// Where the file cannot be read, or its header, a row or an option is not usable; see [`CsvError`].
pub fn read_csv(file: &Path, options: &CsvOptions) -> Result<Recording, CsvError> {
    CsvSamples::open(file, options)?.hold()
}

/// Reads the recording in `file`: an `.npz` by its name (with the feature `arrays`), any other as CSV.
///
/// # Errors
/// Where the file cannot be read, or its columns, a row or an option is not usable; see [`CsvError`].
pub fn read_recording(file: &Path, options: &CsvOptions) -> Result<Recording, CsvError> {
    #[cfg(feature = "arrays")]
    if crate::npz::is_npz(file) {
        return crate::arrays::read_npz(file, options);
    }
    read_csv(file, options)
}

/// The recording whose bytes are `bytes`; `file` gives its name and stands in errors.
///
/// # Errors
/// Where the header, a row or an option is not usable; see [`CsvError`].
pub fn parse_csv(file: &Path, bytes: &[u8], options: &CsvOptions) -> Result<Recording, CsvError> {
    CsvSamples::new(file, bytes, options)?.hold()
}

/// The samples of a CSV recording one after the other, as the file is read: the memory does not depend on its length.
#[derive(Debug)]
pub struct CsvSamples<R> {
    table: Table<R>,
    gathering: Gathering,
    one_column: bool,
    /// Blank lines that stand for samples, and the sample behind them.
    blank: usize,
    behind: Option<Sample>,
}

impl CsvSamples<File> {
    /// Opens `file`.
    ///
    /// # Errors
    /// Where it cannot be read, or its header or an option is not usable.
    pub fn open(file: &Path, options: &CsvOptions) -> Result<Self, CsvError> {
        let input = files::open(file)
            .map_err(|source| CsvError::Unreadable { file: file.to_owned(), source })?;
        Self::new(file, input, options)
    }
}

impl<R: Read> CsvSamples<R> {
    fn new(file: &Path, input: R, options: &CsvOptions) -> Result<Self, CsvError> {
        let table = Table::open(file, input)?;
        let one_column = table.header().len() == 1;
        let mut gathering = Gathering::new(file, table.header(), options)?;
        gathering.notes.trailing_comma = table.header().last().is_some_and(String::is_empty);
        Ok(Self { table, gathering, one_column, blank: 0, behind: None })
    }

    /// The next sample and the frame of taxels that came with it, which is empty where none did; `None` at the end.
    ///
    /// # Errors
    /// Where a row is not usable.
    pub fn next_sample(&mut self) -> Result<Option<(Sample, &[f32])>, CsvError> {
        let sample = self.next()?;
        Ok(sample.map(|sample| (sample, self.gathering.frame())))
    }

    fn next(&mut self) -> Result<Option<Sample>, CsvError> {
        if self.blank > 0 {
            self.blank -= 1;
            return Ok(Some(self.gathering.without_stylus()));
        }
        if let Some(sample) = self.behind.take() {
            return Ok(Some(self.gathering.timed(sample)));
        }
        let Some(row) = self.table.next_row()? else { return Ok(None) };
        if !self.one_column || self.gathering.is_empty() || row.blank_before == 0 {
            self.gathering.notes.blank_lines += row.blank_before;
            return self.gathering.sample(&row).map(Some);
        }
        self.blank = row.blank_before;
        self.behind = Some(self.gathering.uncounted(&row)?);
        self.next()
    }

    /// The recording without its samples: channels, rate and what is odd about it. Reads what is left of the file.
    ///
    /// # Errors
    /// Where a row is not usable, there is none, or no rate.
    pub fn survey(mut self) -> Result<Recording, CsvError> {
        while self.next()?.is_some() {}
        self.gathering.finish()
    }

    fn hold(mut self) -> Result<Recording, CsvError> {
        while let Some(sample) = self.next()? {
            self.gathering.keep(sample)?;
        }
        self.gathering.finish()
    }
}

pub(crate) fn read_bytes(file: &Path) -> Result<Vec<u8>, CsvError> {
    files::read(file, files::MOST_TABLE)
        .map_err(|source| CsvError::Unreadable { file: file.to_owned(), source })
}

const READING: &str = "write digits with a decimal point, NaN for a bad reading";

impl Cells for Row<'_> {
    fn time(&self, column: usize, previous: Option<Micros>) -> Result<Micros, CsvError> {
        Row::time(self, column, previous)
    }

    fn reading(&self, column: usize, scale: Scale) -> Result<Option<f32>, CsvError> {
        let text = self.cell(column);
        if text.is_empty() {
            return Ok(None);
        }
        parse_reading(&text, scale).map(Some).ok_or_else(|| self.not_a_number(column, READING))
    }

    fn micros(&self, column: usize) -> Result<Option<Micros>, CsvError> {
        let text = self.cell(column);
        if text.is_empty() {
            return Ok(None);
        }
        let wrong = |_| self.not_a_number(column, "write whole microseconds");
        text.parse().map(|us| Some(Micros(us))).map_err(wrong)
    }
}
