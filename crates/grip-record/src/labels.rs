//! Reader of `labels.csv` of a folder: what is known about each of its recordings.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use slip_core::units::Micros;

use crate::csv_read::read_bytes;
use crate::csv_read::time;
use crate::error::{CsvError, excerpt};
use grip_table::{Row, Table, TableError};

/// What happens in a recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LabelKind {
    /// Starts at rest and begins to slip.
    Onset {
        /// Time of the first slip, on the clock of the recording.
        at: Micros,
    },
    /// Slips all the time.
    Steady,
    /// Never slips: every alarm is false.
    Rest,
}

impl LabelKind {
    /// The word in the file: `onset`, `steady` or `rest`.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Onset { .. } => "onset",
            Self::Steady => "steady",
            Self::Rest => "rest",
        }
    }
}

/// One row of `labels.csv`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Label {
    /// Name of the recording: its file without `.csv`.
    pub recording: String,
    /// What happens in it.
    pub kind: LabelKind,
    /// The material touched, in the folder's own words; may be empty.
    pub material: String,
}

impl Label {
    /// The recording in the folder `dir`: `NAME.csv`.
    #[must_use]
    pub fn file(&self, dir: &Path) -> PathBuf {
        dir.join(format!("{}.csv", self.recording))
    }

    /// When the slip begins; `None` where it always or never slips.
    #[must_use]
    pub const fn onset(&self) -> Option<Micros> {
        match self.kind {
            LabelKind::Onset { at } => Some(at),
            LabelKind::Steady | LabelKind::Rest => None,
        }
    }
}

/// Why `labels.csv` could not be read.
#[derive(Debug, thiserror::Error)]
pub enum LabelError {
    /// The file is missing, or no proper table.
    #[error(transparent)]
    Table(#[from] CsvError),
    /// The kind is none of the three.
    #[error("{}: line {line}, column kind: {text:?} is unknown; write onset, steady or rest", file.display())]
    UnknownKind {
        /// The file.
        file: PathBuf,
        /// The line.
        line: u64,
        /// The cell.
        text: String,
    },
    /// An onset without its time.
    #[error(
        "{}: line {line}, column onset_s: is empty; kind onset needs the time of the onset in seconds",
        file.display()
    )]
    OnsetMissing {
        /// The file.
        file: PathBuf,
        /// The line.
        line: u64,
    },
    /// A time of onset where there is no onset.
    #[error(
        "{}: line {line}, column onset_s: {text:?} stands at kind {kind}; only kind onset has a time, clear the cell",
        file.display()
    )]
    OnsetUnexpected {
        /// The file.
        file: PathBuf,
        /// The line.
        line: u64,
        /// The kind of the row.
        kind: &'static str,
        /// The cell.
        text: String,
    },
    /// The name is empty or leads out of the folder.
    #[error(
        "{}: line {line}, column recording: {text:?} is no file name; write the name of a file in this \
         folder without .csv",
        file.display()
    )]
    BadName {
        /// The file.
        file: PathBuf,
        /// The line.
        line: u64,
        /// The cell.
        text: String,
    },
    /// A recording has two rows that are not onsets in rising order.
    #[error(
        "{}: line {line}, column recording: {name:?} has a label already; remove one of the rows, or give further onsets in rising order",
        file.display()
    )]
    Repeated {
        /// The file.
        file: PathBuf,
        /// The line of the second row.
        line: u64,
        /// The name.
        name: String,
    },
}

impl From<TableError> for LabelError {
    fn from(error: TableError) -> Self {
        Self::Table(error.into())
    }
}

/// Columns of the table; those a folder may do without are optional.
struct Columns {
    recording: usize,
    kind: usize,
    material: Option<usize>,
    onset_s: Option<usize>,
}

/// Reads the labels in `file`: columns `recording`, `kind`, `material`, `onset_s` (seconds, rounded to 1 us,
/// given exactly where the kind is `onset`). The last two columns may be absent; others are ignored. A recording has one row, or
/// a row for each of its onsets, in rising order.
///
/// # Errors
/// Where the file cannot be read or a row is not usable; see [`LabelError`].
pub fn read_labels(file: &Path) -> Result<Vec<Label>, LabelError> {
    let bytes = read_bytes(file)?;
    let mut table = Table::by_hand(file, bytes.as_slice())?;
    let columns = Columns {
        recording: table.required("recording")?,
        kind: table.required("kind")?,
        material: table.position("material"),
        onset_s: table.position("onset_s"),
    };
    let mut labels = Vec::new();
    let mut last: HashMap<String, Option<Micros>> = HashMap::new();
    while let Some(row) = table.next_row()? {
        let label = label_of(file, &row, &columns)?;
        let before = last.insert(label.recording.clone(), label.onset());
        // None before Some(_): what is no onset follows nothing, and is followed by nothing.
        if before.is_some_and(|before| before.is_none() || before >= label.onset()) {
            return Err(LabelError::Repeated {
                file: file.to_owned(),
                line: row.line,
                name: label.recording,
            });
        }
        labels.push(label);
    }
    if labels.is_empty() {
        return Err(CsvError::NoRows { file: file.to_owned() }.into());
    }
    Ok(labels)
}

fn label_of(file: &Path, row: &Row<'_>, columns: &Columns) -> Result<Label, LabelError> {
    let recording = row.cell(columns.recording).into_owned();
    let plain =
        !recording.is_empty() && recording != ".." && !recording.contains(['/', '\\', '\0']);
    if !plain {
        return Err(LabelError::BadName {
            file: file.to_owned(),
            line: row.line,
            text: excerpt(&recording),
        });
    }
    let kind = kind_of(file, row, columns)?;
    let material = columns.material.map(|column| row.cell(column).into_owned()).unwrap_or_default();
    Ok(Label { recording, kind, material })
}

fn kind_of(file: &Path, row: &Row<'_>, columns: &Columns) -> Result<LabelKind, LabelError> {
    let onset = columns.onset_s.filter(|column| !row.cell(*column).is_empty());
    let word = row.cell(columns.kind);
    let kind = match word.as_ref() {
        "onset" => {
            let missing = || LabelError::OnsetMissing { file: file.to_owned(), line: row.line };
            return Ok(LabelKind::Onset { at: time(row, onset.ok_or_else(missing)?, None)? });
        }
        "steady" => LabelKind::Steady,
        "rest" => LabelKind::Rest,
        other => {
            return Err(LabelError::UnknownKind {
                file: file.to_owned(),
                line: row.line,
                text: excerpt(other),
            });
        }
    };
    match onset {
        None => Ok(kind),
        Some(column) => Err(LabelError::OnsetUnexpected {
            file: file.to_owned(),
            line: row.line,
            kind: kind.word(),
            text: excerpt(&row.cell(column)),
        }),
    }
}
