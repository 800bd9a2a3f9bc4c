//! Reader of `phases.csv` of a folder: what went on in its recordings beside slips, the causes that an alarm can have.

use std::path::{Path, PathBuf};

use slip_core::units::Micros;

use crate::csv_read::{read_optional, time};
use crate::error::CsvError;
use grip_table::{Table, TableError};

/// A stretch of a recording with a cause that is no slip: `closing`, `arm`, `knock` or any other word.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Phase {
    /// Name of the recording: its file without `.csv`.
    pub recording: String,
    /// First time of the stretch, on the clock of the recording.
    pub begin: Micros,
    /// First time after it.
    pub end: Micros,
    /// What went on, in the folder's own words.
    pub cause: String,
}

/// Why `phases.csv` could not be read.
#[derive(Debug, thiserror::Error)]
pub enum PhaseError {
    /// No proper table.
    #[error(transparent)]
    Table(#[from] CsvError),
    /// A stretch that ends before it begins.
    #[error("{}: line {line}: end_s must lie after begin_s", file.display())]
    Empty {
        /// The file.
        file: PathBuf,
        /// The line.
        line: u64,
    },
    /// A stretch without a cause.
    #[error("{}: line {line}, column cause: is empty; name what goes on there", file.display())]
    Nameless {
        /// The file.
        file: PathBuf,
        /// The line.
        line: u64,
    },
}

impl From<TableError> for PhaseError {
    fn from(error: TableError) -> Self {
        Self::Table(error.into())
    }
}

/// Reads the phases in `file`: columns `recording`, `begin_s`, `end_s` (seconds, rounded to 1 us) and `cause`; others are ignored.
/// Nothing where there is no such file.
///
/// # Errors
/// Where the file cannot be read or a row is not usable; see [`PhaseError`].
pub fn read_phases(file: &Path) -> Result<Vec<Phase>, PhaseError> {
    let Some(bytes) = read_optional(file)? else { return Ok(Vec::new()) };
    let mut table = Table::by_hand(file, bytes.as_slice())?;
    let recording = table.required("recording")?;
    let (begin, end) = (table.required("begin_s")?, table.required("end_s")?);
    let cause = table.required("cause")?;
    let mut phases = Vec::new();
    while let Some(row) = table.next_row()? {
        let phase = Phase {
            recording: row.cell(recording).into_owned(),
            begin: time(&row, begin, None)?,
            end: time(&row, end, None)?,
            cause: row.cell(cause).into_owned(),
        };
        if phase.end <= phase.begin {
            return Err(PhaseError::Empty { file: file.to_owned(), line: row.line });
        }
        if phase.cause.is_empty() {
            return Err(PhaseError::Nameless { file: file.to_owned(), line: row.line });
        }
        phases.push(phase);
    }
    Ok(phases)
}

/// Alarms of a detector of one's own in `file`: columns `recording`, `begin_s` and `end_s` (seconds, rounded to 1 us), as phases without
/// a cause. A row without an end is an alarm of one sample. `None` where there is no such file.
///
/// # Errors
/// Where the file cannot be read or a row is not usable; see [`PhaseError`].
pub fn read_alarms(file: &Path) -> Result<Option<Vec<Phase>>, PhaseError> {
    let Some(bytes) = read_optional(file)? else { return Ok(None) };
    let mut table = Table::by_hand(file, bytes.as_slice())?;
    let (recording, begin) = (table.required("recording")?, table.required("begin_s")?);
    let end = table.position("end_s");
    let mut alarms = Vec::new();
    while let Some(row) = table.next_row()? {
        let begin = time(&row, begin, None)?;
        let given = end.filter(|end| !row.cell(*end).is_empty());
        let end = given.map_or(Ok(begin), |end| time(&row, end, None))?;
        if end < begin {
            return Err(PhaseError::Empty { file: file.to_owned(), line: row.line });
        }
        let recording = row.cell(recording).into_owned();
        alarms.push(Phase { recording, begin, end, cause: String::new() });
    }
    alarms.sort_by_key(|alarm| alarm.begin);
    Ok(Some(alarms))
}

#[cfg(test)]
mod tests {
    use super::{PhaseError, read_phases};
    use slip_core::units::Micros;

    #[test]
    fn phases_are_optional_and_checked() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("phases.csv");
        assert!(read_phases(&file).unwrap().is_empty());
        let head = "recording,begin_s,end_s,cause\n";
        std::fs::write(&file, format!("{head}a,0,1.5,closing\nb,2,3,arm\n")).unwrap();
        let phases = read_phases(&file).unwrap();
        assert_eq!((phases.len(), phases[0].end), (2, Micros(1_500_000)));
        assert_eq!((phases[1].recording.as_str(), phases[1].cause.as_str()), ("b", "arm"));
        std::fs::write(&file, format!("{head}a,1,1,closing\n")).unwrap();
        assert!(matches!(read_phases(&file), Err(PhaseError::Empty { line: 2, .. })));
        std::fs::write(&file, format!("{head}a,1,2,\n")).unwrap();
        assert!(matches!(read_phases(&file), Err(PhaseError::Nameless { line: 2, .. })));
    }
}
