//! What is wrong with a file: where it is, which number or text, and what to do about it.

use std::io;
use std::path::PathBuf;

use crate::channels::COLUMN_NAMES;

/// Why a file of columns could not be read. Lines and columns count from 1, as an editor shows them; of an `.npz` the line is
/// the row, the first value being 1.
#[derive(Debug, thiserror::Error)]
pub enum CsvError {
    /// The file is missing or cannot be read.
    #[error("{}: cannot be read ({source}); check the path and its permissions", file.display())]
    Unreadable {
        /// The file.
        file: PathBuf,
        /// What the operating system said.
        source: io::Error,
    },
    /// An `.npz` or one of its arrays.
    #[cfg(feature = "arrays")]
    #[error(transparent)]
    Arrays(#[from] crate::npz::NpzError),
    /// The file has a header row and nothing else.
    #[error("{}: has a header but no rows; record at least one row", file.display())]
    NoRows {
        /// The file.
        file: PathBuf,
    },
    /// There is no column that reports a slip.
    #[error(
        "{}: nothing was taken for a vibration, a stylus, a travel or taxels; say which it is, for example --map {}; the file has: {}",
        file.display(),
        shell(&format!("vibration={}", example.as_deref().unwrap_or("NAME"))),
        list(found)
    )]
    NoStylus {
        /// The file.
        file: PathBuf,
        /// The names in the header.
        found: Vec<String>,
        /// One that could be.
        example: Option<String>,
    },
    /// There is neither a time column nor a rate.
    #[error(
        "{}: no column of times and no rate; give --rate HZ, or name the times with --map t_s=NAME; the file has: {}",
        file.display(), list(found)
    )]
    NoTime {
        /// The file.
        file: PathBuf,
        /// The names in the header.
        found: Vec<String>,
    },
    /// More axes than a vector has.
    #[error(
        "{}: {} axes ({}); a vector has one to three: choose one with --map {vector}=NAME, or remove some",
        file.display(), found.len(), list(found)
    )]
    TooManyAxes {
        /// The file.
        file: PathBuf,
        /// The plain name, for example `vibration`.
        vector: String,
        /// The names of its axes.
        found: Vec<String>,
    },
    /// The columns of a taxel array do not count up from 0.
    #[error(
        "{}: has {found} but not {missing}; taxels are named pressure_0, pressure_1 and so on",
        file.display()
    )]
    TaxelGap {
        /// The file.
        file: PathBuf,
        /// The column that is missing.
        missing: String,
        /// A column beyond it.
        found: String,
    },
    /// An array with no taxels, or with too many.
    #[error("{}: {count} taxels; an array has 1 to {}", file.display(), slip_core::pressure::MAX_TAXELS)]
    TaxelCount {
        /// The file.
        file: PathBuf,
        /// Its taxels.
        count: usize,
    },
    /// Two columns could serve the same channel.
    #[error(
        "{}: has {first} and {second}, only one of them can be used; choose with --map {first}={first} \
         or --map {second}={second}",
        file.display()
    )]
    Ambiguous {
        /// The file.
        file: PathBuf,
        /// One of the two names.
        first: &'static str,
        /// The other name.
        second: &'static str,
    },
    /// Several signals could be the one.
    #[error(
        "{}: {what} may be any of {}; choose one with --map {}",
        file.display(), list(found),
        shell(&format!("{ours}={}", found.first().map_or("NAME", String::as_str)))
    )]
    Unclear {
        /// The file.
        file: PathBuf,
        /// What is looked for.
        what: &'static str,
        /// Its name among the columns.
        ours: String,
        /// What could be it.
        found: Vec<String>,
    },
    /// A column of text where numbers are wanted.
    #[error(
        "{}: column {column} holds text and cannot be {wanted}{}",
        file.display(),
        if wanted == "t_s" { "; a date or a time of day is not read: write seconds, or leave it out and give --rate HZ" } else { "" }
    )]
    Text {
        /// The file.
        file: PathBuf,
        /// The column as the file names it.
        column: String,
        /// What it was to be.
        wanted: String,
    },
    /// A table that cannot be read, or a row or cell of it.
    #[error(transparent)]
    Table(#[from] grip_table::TableError),
    /// The times cannot be used as such.
    #[error("{}: {fault}; the file has: {}", file.display(), list(found))]
    Times {
        /// The file.
        file: PathBuf,
        /// What is wrong with them, and what helps.
        fault: String,
        /// The names in the header.
        found: Vec<String>,
    },
    /// The finger asked for is not there.
    #[error("{}: {fault}", file.display())]
    Finger {
        /// The file.
        file: PathBuf,
        /// What is wrong.
        fault: String,
    },
    /// The left side of a renaming is not a name the reader knows.
    #[error("--map {ours}={theirs}: {ours:?} is not a known column; known are: {}", COLUMN_NAMES.join(", "))]
    UnknownMapName {
        /// The name that is not known.
        ours: String,
        /// The file's column it was to be given.
        theirs: String,
    },
    /// The right side of a renaming is not in the file.
    #[error(
        "{}: --map {}: no such signal; the file has: {}",
        file.display(), shell(&format!("{ours}={theirs}")), list(found)
    )]
    MapColumnAbsent {
        /// The file.
        file: PathBuf,
        /// The known name.
        ours: String,
        /// The column that is not there.
        theirs: String,
        /// The names in the header.
        found: Vec<String>,
    },
    /// A name stands twice in the renamings, on the same side.
    #[error("--map names {name:?} twice on the same side; one column goes to one channel")]
    MapRepeated {
        /// The repeated name.
        name: String,
    },
    /// The given rate is not usable.
    #[error("--rate {rate_hz}: must be between 0.001 and 1000000 Hz")]
    BadRate {
        /// The rate (Hz).
        rate_hz: f32,
    },
    /// The rate cannot be derived from the times.
    #[error(
        "{}: the rate cannot be told from {rows} rows because most times are equal or there is only one; \
         give --rate HZ",
        file.display()
    )]
    NoRate {
        /// The file.
        file: PathBuf,
        /// Rows read.
        rows: usize,
    },
    /// More samples than are held in memory.
    #[error(
        "{}: more than {most} rows, which is as many as are held in memory; split the file (`gripctl replay` takes any \
         length, and `gripctl import` writes that of WAV, NPY and NPZ as .csv or .mcap)",
        file.display()
    )]
    TooManyRows {
        /// The file.
        file: PathBuf,
        /// Rows that are held.
        most: usize,
    },
    /// A profile has fewer heights than its evaluation needs.
    #[error("{}: only {rows} heights; a profile needs at least {needed}", file.display())]
    FewRows {
        /// The file.
        file: PathBuf,
        /// Heights that were measured.
        rows: usize,
        /// Heights needed.
        needed: usize,
    },
    /// The places of a profile do not go on by equal steps.
    #[error(
        "{}: line {line}, column x_mm: {} where {} mm is the usual step; a profile needs equal steps: resample it, or \
         give the step where x_mm is wrong",
        file.display(),
        step(*step_mm),
        digits(usual_mm.abs())
    )]
    UnequalStep {
        /// The file.
        file: PathBuf,
        /// The line that ends the step.
        line: u64,
        /// The step (mm).
        step_mm: f64,
        /// The median of all steps (mm).
        usual_mm: f64,
    },
    /// A time is negative, not finite or beyond 64 bits of microseconds.
    #[error(
        "{}: line {line}, column {column}: {text:?} is no time; remove the row",
        file.display()
    )]
    TimeOutOfRange {
        /// The file.
        file: PathBuf,
        /// The line.
        line: u64,
        /// The column as the file names it.
        column: String,
        /// The cell, at most 40 characters of it.
        text: String,
    },
    /// A time is earlier than that of the row before.
    #[error(
        "{}: line {line}, column {column}: time goes backwards from {before} s to {time} s; split the file there, sorting would \
         mix two recordings",
        file.display()
    )]
    TimeBackwards {
        /// The file.
        file: PathBuf,
        /// The line of the earlier time.
        line: u64,
        /// The column as the file names it.
        column: String,
        /// Time of the row before (s).
        before: f64,
        /// Time of this row (s).
        time: f64,
    },
}

/// A step as a person says it; `step_mm` counts in the direction of the profile.
fn step(step_mm: f64) -> String {
    match step_mm {
        0.0 => "the same place as in the row before".to_owned(),
        back if back < 0.0 => format!("{} mm back", digits(-back)),
        on => format!("a step of {} mm", digits(on)),
    }
}

/// Four digits, without those of binary fractions.
fn digits(value: f64) -> String {
    let scale = 10_f64.powf(3.0 - value.abs().max(1e-300).log10().floor());
    format!("{}", (value * scale).round() / scale)
}

impl CsvError {
    /// Whether the file is empty.
    #[must_use]
    pub const fn is_empty_file(&self) -> bool {
        matches!(self, Self::Table(grip_table::TableError::Empty { .. }))
    }
}

/// A word of a command line, in quotes where a shell would split or change it; what would change a terminal or forge a line of
/// the message is escaped.
#[must_use]
pub fn shell(word: &str) -> String {
    let word = &visible(word);
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "_-./=:,+@%".contains(c);
    if word.chars().all(is_plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', "'\\''"))
    }
}

use grip_table::{list, visible};

pub(crate) use grip_table::excerpt;
