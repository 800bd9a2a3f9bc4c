//! Bytes of a CSV file and column specs in, feature and target rows out.

use core::fmt;

use sha2::{Digest, Sha256};

use super::column::ColumnSpec;
use super::csv_file::{CsvFile, Row};
use super::scaling::{Method, Scaling};
use crate::scaler::{MAX_IO, Transform};

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

/// Why a file is no data set.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum DataSetError {
    /// Empty file.
    #[error("{file}: no header row")]
    NoHeader {
        /// Name of the file.
        file: String,
    },
    /// A header and nothing below it.
    #[error("{file}: no rows below the header")]
    NoRows {
        /// Name of the file.
        file: String,
    },
    /// None or more than [`MAX_IO`] columns of one kind were asked for.
    #[error("{given} {kind} columns: 1 to {MAX_IO} are possible")]
    Columns {
        /// `input` or `target`.
        kind: &'static str,
        /// Columns asked for.
        given: usize,
    },
    /// The same column was asked for twice.
    #[error("column \"{column}\" is used twice")]
    Repeated {
        /// Its name.
        column: String,
    },
    /// No column has the name asked for.
    #[error("{file}: no column \"{column}\" (there are: {available})")]
    Missing {
        /// Name of the file.
        file: String,
        /// The name asked for.
        column: String,
        /// All names of the header, separated by commas.
        available: String,
    },
    /// Several columns have the name asked for.
    #[error("{file}: several columns \"{column}\"")]
    Ambiguous {
        /// Name of the file.
        file: String,
        /// The name asked for.
        column: String,
    },
    /// Too few or too many fields.
    #[error("{file}, line {line}: {given} fields where the header has {needed}")]
    RowLength {
        /// Name of the file.
        file: String,
        /// Line, counted from 1.
        line: u64,
        /// Fields of the header.
        needed: usize,
        /// Fields of the row.
        given: usize,
    },
    /// Text, nothing, NaN, an infinity, or more than an `f32` can hold.
    #[error("{place}: \"{text}\" is not a finite number")]
    NotANumber {
        /// Where it stands.
        place: Place,
        /// The field.
        text: String,
    },
    /// The logarithm of a value that is not positive.
    #[error("{place}: the logarithm needs a value above 0, this is {value}")]
    LogOfNonPositive {
        /// Where it stands.
        place: Place,
        /// The value as text.
        value: String,
    },
    /// A row without a label in the column that groups the rows.
    #[error("{place}: a label is needed to split by it")]
    NoLabel {
        /// Where it should stand.
        place: Place,
    },
    /// Values that do not divide into rows.
    #[error("{name}: {inputs} input and {targets} target values are no rows of {columns} columns")]
    Ragged {
        /// Name of the data.
        name: String,
        /// Input values given.
        inputs: usize,
        /// Target values given.
        targets: usize,
        /// Columns of a row.
        columns: usize,
    },
    /// A row that the data set has not.
    #[error("row {row} of {rows} (counted from 0)")]
    NoSuchRow {
        /// Asked for.
        row: usize,
        /// Rows there are.
        rows: usize,
    },
    /// The bytes are no CSV text.
    #[error("{file}, line {line}: {message}")]
    Malformed {
        /// Name of the file.
        file: String,
        /// Line, counted from 1, or 0 when unknown.
        line: u64,
        /// What the reader says.
        message: String,
    },
}

/// Features and targets of one CSV file in raw units, row by row.
#[derive(Debug, Clone, PartialEq)]
pub struct DataSet {
    /// Name of the file, for messages.
    pub file: String,
    /// SHA-256 of the file's bytes in hexadecimal.
    pub sha256: String,
    /// Feature columns in the order asked for.
    pub inputs: Vec<ColumnSpec>,
    /// Target columns in the order asked for.
    pub targets: Vec<ColumnSpec>,
    rows: usize,
    input_values: Vec<f64>,
    target_values: Vec<f64>,
    /// One label a row, or none at all.
    labels: Vec<String>,
}

impl DataSet {
    /// Reads the wanted columns of a CSV file with a header row. `file` is its name, used in messages.
    ///
    /// # Errors
    /// Any [`DataSetError`]; the first fault ends the reading.
    pub fn from_csv(
        file: &str,
        bytes: &[u8],
        inputs: &[ColumnSpec],
        targets: &[ColumnSpec],
    ) -> Result<Self, DataSetError> {
        Self::from_grouped_csv(file, bytes, (inputs, targets), None)
    }

    /// The same for the columns `(inputs, targets)`, and of each row the text in the column `group` (an object, a
    /// grasp, a session): rows with the same one stay together in a [split](super::split).
    ///
    /// # Errors
    /// Any [`DataSetError`]; the first fault ends the reading.
    pub fn from_grouped_csv(
        file: &str,
        bytes: &[u8],
        (inputs, targets): (&[ColumnSpec], &[ColumnSpec]),
        group: Option<&str>,
    ) -> Result<Self, DataSetError> {
        check_columns(inputs, targets)?;
        let mut csv = CsvFile::open(file, bytes)?;
        let places = |specs: &[ColumnSpec], csv: &CsvFile<'_>| {
            specs.iter().map(|spec| csv.column(&spec.name)).collect::<Result<Vec<_>, _>>()
        };
        let (input_places, target_places) = (places(inputs, &csv)?, places(targets, &csv)?);
        let group = group.map(|name| Ok((csv.column(name)?, name))).transpose()?;
        let hash = hexadecimal(&Sha256::digest(bytes));
        let mut data = Self::empty(file, hash, inputs, targets);
        while let Some(row) = csv.next_row()? {
            read_fields(&row, &input_places, inputs, &mut data.input_values)?;
            read_fields(&row, &target_places, targets, &mut data.target_values)?;
            if let Some((at, name)) = group {
                data.labels.push(read_label(&row, at, name)?);
            }
            data.rows += 1;
        }
        if data.rows == 0 {
            return Err(DataSetError::NoRows { file: file.to_owned() });
        }
        Ok(data)
    }

    /// Data that was computed instead of read: `values` holds features and targets, both row by row. `name` is used in
    /// messages, with the number of the row (from 1) as the line. The hash is that of the values' bytes, little-endian.
    ///
    /// # Errors
    /// [`DataSetError::Columns`], [`DataSetError::Repeated`], [`DataSetError::Ragged`], [`DataSetError::NoRows`],
    /// [`DataSetError::NotANumber`] and [`DataSetError::LogOfNonPositive`].
    pub fn from_values(
        name: &str,
        inputs: &[ColumnSpec],
        targets: &[ColumnSpec],
        values: (Vec<f64>, Vec<f64>),
    ) -> Result<Self, DataSetError> {
        check_columns(inputs, targets)?;
        let (input_values, target_values) = values;
        let rows = input_values.len() / inputs.len();
        if input_values.len() != rows * inputs.len() || target_values.len() != rows * targets.len()
        {
            return Err(DataSetError::Ragged {
                name: name.to_owned(),
                inputs: input_values.len(),
                targets: target_values.len(),
                columns: inputs.len() + targets.len(),
            });
        }
        if rows == 0 {
            return Err(DataSetError::NoRows { file: name.to_owned() });
        }
        for (specs, values) in [(inputs, &input_values), (targets, &target_values)] {
            check_values(name, specs, values)?;
        }
        let mut hash = Sha256::new();
        input_values.iter().chain(&target_values).for_each(|v| hash.update(v.to_le_bytes()));
        let data = Self::empty(name, hexadecimal(&hash.finalize()), inputs, targets);
        Ok(Self { rows, input_values, target_values, ..data })
    }

    fn empty(file: &str, sha256: String, inputs: &[ColumnSpec], targets: &[ColumnSpec]) -> Self {
        Self {
            file: file.to_owned(),
            sha256,
            inputs: inputs.to_vec(),
            targets: targets.to_vec(),
            rows: 0,
            input_values: Vec::new(),
            target_values: Vec::new(),
            labels: Vec::new(),
        }
    }

    /// The given rows, counted from 0, in the given order. Name and hash stay those of the whole.
    ///
    /// # Errors
    /// [`DataSetError::NoRows`] and [`DataSetError::NoSuchRow`].
    pub fn subset(&self, rows: &[usize]) -> Result<Self, DataSetError> {
        if rows.is_empty() {
            return Err(DataSetError::NoRows { file: self.file.clone() });
        }
        let mut part = Self::empty(&self.file, self.sha256.clone(), &self.inputs, &self.targets);
        part.rows = rows.len();
        for &row in rows {
            let (Some(inputs), Some(targets)) = (
                self.input_values.chunks_exact(self.inputs.len()).nth(row),
                self.target_values.chunks_exact(self.targets.len()).nth(row),
            ) else {
                return Err(DataSetError::NoSuchRow { row, rows: self.rows });
            };
            part.input_values.extend_from_slice(inputs);
            part.target_values.extend_from_slice(targets);
            part.labels.extend(self.labels.get(row).cloned());
        }
        Ok(part)
    }

    /// The label of each row, or none where no column of labels was read.
    #[must_use]
    pub fn labels(&self) -> &[String] {
        &self.labels
    }

    /// Number of rows, at least 1.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Features and targets of each row, raw.
    #[must_use]
    pub fn iter(&self) -> impl ExactSizeIterator<Item = (&[f64], &[f64])> {
        self.input_values
            .chunks_exact(self.inputs.len())
            .zip(self.target_values.chunks_exact(self.targets.len()))
    }

    /// Limits of the feature columns over the rows, for min-max.
    #[must_use]
    pub fn input_scalings(&self) -> Vec<Scaling> {
        self.scalings(Method::MinMax).0
    }

    /// Limits of the target columns over the rows, for min-max.
    #[must_use]
    pub fn target_scalings(&self) -> Vec<Scaling> {
        self.scalings(Method::MinMax).1
    }

    /// Limits of feature and target columns over the rows, scaled by `method`.
    #[must_use]
    pub fn scalings(&self, method: Method) -> (Vec<Scaling>, Vec<Scaling>) {
        (
            scalings(method, &self.inputs, &self.input_values),
            scalings(method, &self.targets, &self.target_values),
        )
    }

    /// All rows scaled. Limits come from the training rows, whichever rows these are.
    #[must_use]
    pub fn patterns(&self, inputs: &[Scaling], targets: &[Scaling]) -> Patterns {
        Patterns {
            inputs: scale_all(inputs, &self.input_values),
            targets: scale_all(targets, &self.target_values),
        }
    }
}

/// Scaled rows as the objective takes them, both row by row.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Patterns {
    /// rows x inputs.
    pub inputs: Vec<f64>,
    /// rows x targets.
    pub targets: Vec<f64>,
}

fn check_columns(inputs: &[ColumnSpec], targets: &[ColumnSpec]) -> Result<(), DataSetError> {
    for (kind, specs) in [("input", inputs), ("target", targets)] {
        if !(1..=MAX_IO).contains(&specs.len()) {
            return Err(DataSetError::Columns { kind, given: specs.len() });
        }
    }
    let all: Vec<&ColumnSpec> = inputs.iter().chain(targets).collect();
    for (place, spec) in all.iter().enumerate() {
        if all[..place].iter().any(|other| other.name == spec.name) {
            return Err(DataSetError::Repeated { column: spec.name.clone() });
        }
    }
    Ok(())
}

fn read_fields(
    row: &Row<'_>,
    places: &[usize],
    specs: &[ColumnSpec],
    values: &mut Vec<f64>,
) -> Result<(), DataSetError> {
    for (&at, spec) in places.iter().zip(specs) {
        let value = row.number(at, &spec.name)?;
        // A positive value that is 0 in the model's precision has no logarithm there either.
        if spec.transform == Transform::Ln && !spec.transform.accepts(super::rounded(value)) {
            let place = row.place(&spec.name);
            return Err(DataSetError::LogOfNonPositive { place, value: value.to_string() });
        }
        values.push(value);
    }
    Ok(())
}

fn read_label(row: &Row<'_>, at: usize, name: &str) -> Result<String, DataSetError> {
    match row.text(at) {
        "" => Err(DataSetError::NoLabel { place: row.place(name) }),
        label => Ok(label.to_owned()),
    }
}

/// What [`read_fields`] asks of the fields of a file.
fn check_values(name: &str, specs: &[ColumnSpec], values: &[f64]) -> Result<(), DataSetError> {
    let place = |at: usize, spec: &ColumnSpec| Place {
        file: name.to_owned(),
        line: (at / specs.len() + 1) as u64,
        column: spec.name.clone(),
    };
    for (at, (value, spec)) in values.iter().zip(specs.iter().cycle()).enumerate() {
        let (single, text) = (super::rounded(*value), value.to_string());
        if !single.is_finite() {
            return Err(DataSetError::NotANumber { place: place(at, spec), text });
        }
        if !spec.transform.accepts(single) {
            return Err(DataSetError::LogOfNonPositive { place: place(at, spec), value: text });
        }
    }
    Ok(())
}

fn scalings(method: Method, specs: &[ColumnSpec], values: &[f64]) -> Vec<Scaling> {
    let column = |at: usize| values.iter().copied().skip(at).step_by(specs.len());
    let scaling =
        |(at, spec): (usize, &ColumnSpec)| Scaling::by(method, spec.transform, &column(at));
    specs.iter().enumerate().map(scaling).collect()
}

fn scale_all(scalings: &[Scaling], values: &[f64]) -> Vec<f64> {
    values.iter().zip(scalings.iter().cycle()).map(|(&raw, scaling)| scaling.scaled(raw)).collect()
}

fn hexadecimal(digest: &[u8]) -> String {
    digest.iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
#[path = "data_tests.rs"]
mod tests;
