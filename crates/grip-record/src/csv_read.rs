//! A CSV recording in, its samples and what is odd about them out.

use std::path::Path;

use slip_core::units::Micros;

use crate::channels::Scale;
use crate::error::CsvError;
use crate::files;
use crate::number::parse_reading;
use crate::recording::{Cells, Gathering, Recording};
use crate::table::{Row, Table};

/// What the file itself does not tell.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CsvOptions {
    /// Samples per second, 0.001 to 1e6 Hz. Needed without a time column (t = i / rate); beside one it is the
    /// rate reported, and the file's times stay.
    pub rate_hz: Option<f32>,
    /// Renamings: (known name, the file's column); see [`COLUMN_NAMES`](crate::COLUMN_NAMES).
    pub map: Vec<(String, String)>,
}

/// Reads the recording in `file`.
///
/// # Errors
/// Where the file cannot be read, or its header, a row or an option is not usable; see [`CsvError`].
pub fn read_csv(file: &Path, options: &CsvOptions) -> Result<Recording, CsvError> {
    parse_csv(file, &read_bytes(file)?, options)
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
    let mut table = Table::open(file, bytes)?;
    let one_column = table.header().len() == 1;
    let mut gathering = Gathering::new(file, table.header(), options)?;
    gathering.notes.trailing_comma = table.header().last().is_some_and(String::is_empty);
    while let Some(row) = table.next_row()? {
        if one_column && !gathering.is_empty() {
            gathering.push_without_stylus(row.blank_before);
        } else {
            gathering.notes.blank_lines += row.blank_before;
        }
        gathering.push(&row)?;
    }
    gathering.finish()
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
