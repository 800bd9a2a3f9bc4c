//! Why a file or arrays are no data set, and where.

use core::fmt;

use super::topology::MOST_OUTPUTS;
use crate::model::Transform;

/// Where in a file something is wrong.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Place {
    /// Name of the file.
    pub file: String,
    /// Line, counted from 1.
    pub line: u64,
    /// Name of the column.
    pub column: String,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}, line {}, column \"{}\"", self.file, self.line, self.column)
    }
}

/// What to do about a file whose columns have names of their places only.
fn without_header(available: &str) -> &'static str {
    match available.split(", ").all(|name| name.starts_with("column_")) {
        true => "; its first line is numbers: use these names, or put names above the numbers",
        false => "",
    }
}

/// Why a file is no data set.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum DataSetError {
    /// A header and nothing below it.
    #[error("{file}: no rows below the header")]
    NoRows {
        /// Name of the file.
        file: String,
    },
    /// None or too many columns of one kind were asked for.
    #[error("{given} {kind} columns: 1 to {limit} are possible")]
    Columns {
        /// `input` or `target`.
        kind: &'static str,
        /// Columns asked for.
        given: usize,
        /// Most columns.
        limit: usize,
    },
    /// One class only, or too many.
    #[error("{given} classes in column \"{column}\": 2 to {MOST_OUTPUTS} are possible")]
    Classes {
        /// Name of the column.
        column: String,
        /// Different texts in it.
        given: usize,
    },
    /// A row of a class that is none of those asked for.
    #[error("{file}, row {row}: \"{class}\" is none of the classes {known}")]
    UnknownClass {
        /// Name of the file.
        file: String,
        /// The row, from 1.
        row: usize,
        /// Its class.
        class: String,
        /// The classes, separated by commas.
        known: String,
    },
    /// The same column was asked for twice.
    #[error("column \"{column}\" is used twice")]
    Repeated {
        /// Its name.
        column: String,
    },
    /// No column has the name asked for.
    #[error("{file}: no column \"{column}\" (there are: {available}){}", without_header(available))]
    Missing {
        /// Name of the file.
        file: String,
        /// The name asked for.
        column: String,
        /// All names of the header, separated by commas.
        available: String,
    },
    /// Text, nothing, NaN, an infinity, or more than an `f32` can hold.
    #[error("{place}: \"{text}\" is not a number within +-3.4e38; fill the cell or remove the row")]
    NotANumber {
        /// Where it stands.
        place: Place,
        /// The field.
        text: String,
    },
    /// Logarithm or reciprocal of a value that is not positive.
    #[error("{place}: {transform} needs a value above 0, this is {value}")]
    NotPositive {
        /// Where it stands.
        place: Place,
        /// What is done to its column.
        transform: Transform,
        /// The value.
        value: f64,
    },
    /// A row without a label in the column that groups the rows.
    #[error("{place}: a label is needed to split by it")]
    NoLabel {
        /// Where it should stand.
        place: Place,
    },
    /// Arrays that have not a column for each spec, or not as many rows of inputs as of targets.
    #[error(
        "{name}: inputs of {} x {} and targets of {} x {}: as many rows of both are needed, {} and {} columns",
        inputs[0], inputs[1], targets[0], targets[1], columns[0], columns[1]
    )]
    Shape {
        /// Name of the data.
        name: String,
        /// Rows and columns of the inputs given.
        inputs: [usize; 2],
        /// Rows and columns of the targets given.
        targets: [usize; 2],
        /// Columns of inputs and targets that are needed.
        columns: [usize; 2],
    },
    /// Not one label a row.
    #[error("{name}: {labels} labels for {rows} rows")]
    Labels {
        /// Name of the data.
        name: String,
        /// Labels given.
        labels: usize,
        /// Rows there are.
        rows: usize,
    },
    /// A row that the data set has not.
    #[error("row {row} of {rows} (counted from 0)")]
    NoSuchRow {
        /// Asked for.
        row: usize,
        /// Rows there are.
        rows: usize,
    },
    /// The file is no table, or a line of it no row.
    #[error("{0}")]
    Table(String),
}

impl From<grip_table::TableError> for DataSetError {
    fn from(error: grip_table::TableError) -> Self {
        Self::Table(error.to_string())
    }
}
