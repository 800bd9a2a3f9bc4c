//! Bytes of a CSV file and column specs in, feature and target rows out.

use core::fmt;

use sha2::{Digest, Sha256};

use super::column::ColumnSpec;
use super::csv_file::{CsvFile, Row};
use super::scaling::Scaling;
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
        check_columns(inputs, targets)?;
        let mut csv = CsvFile::open(file, bytes)?;
        let places = |specs: &[ColumnSpec], csv: &CsvFile<'_>| {
            specs.iter().map(|spec| csv.column(&spec.name)).collect::<Result<Vec<_>, _>>()
        };
        let (input_places, target_places) = (places(inputs, &csv)?, places(targets, &csv)?);
        let mut data = Self {
            file: file.to_owned(),
            sha256: hexadecimal(&Sha256::digest(bytes)),
            inputs: inputs.to_vec(),
            targets: targets.to_vec(),
            rows: 0,
            input_values: Vec::new(),
            target_values: Vec::new(),
        };
        while let Some(row) = csv.next_row()? {
            read_fields(&row, &input_places, inputs, &mut data.input_values)?;
            read_fields(&row, &target_places, targets, &mut data.target_values)?;
            data.rows += 1;
        }
        if data.rows == 0 {
            return Err(DataSetError::NoRows { file: file.to_owned() });
        }
        Ok(data)
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

    /// Limits of the feature columns over the rows.
    #[must_use]
    pub fn input_scalings(&self) -> Vec<Scaling> {
        scalings(&self.inputs, &self.input_values)
    }

    /// Limits of the target columns over the rows.
    #[must_use]
    pub fn target_scalings(&self) -> Vec<Scaling> {
        scalings(&self.targets, &self.target_values)
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

fn scalings(specs: &[ColumnSpec], values: &[f64]) -> Vec<Scaling> {
    let column = |at: usize| values.iter().copied().skip(at).step_by(specs.len());
    specs.iter().enumerate().map(|(at, spec)| Scaling::of(spec.transform, column(at))).collect()
}

fn scale_all(scalings: &[Scaling], values: &[f64]) -> Vec<f64> {
    values.iter().zip(scalings.iter().cycle()).map(|(&raw, scaling)| scaling.scaled(raw)).collect()
}

fn hexadecimal(digest: &[u8]) -> String {
    digest.iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn specs(texts: &[&str]) -> Vec<ColumnSpec> {
        texts.iter().map(|text| text.parse().unwrap()).collect()
    }

    fn read(csv: &str, inputs: &[&str], targets: &[&str]) -> Result<DataSet, DataSetError> {
        DataSet::from_csv("grasps.csv", csv.as_bytes(), &specs(inputs), &specs(targets))
    }

    fn message(csv: &str, inputs: &[&str]) -> String {
        read(csv, inputs, &["f_n"]).unwrap_err().to_string()
    }

    #[test]
    fn columns_are_found_by_name_and_scaled() {
        let csv = "\u{feff}f_n, note ,v_m_s\n1,a,0.1\r\n\n3,\"b,c\",0.3\n2,,0.2\n";
        let data = read(csv, &["v_m_s"], &["f_n:ln"]).unwrap();
        assert_eq!(data.rows(), 3);
        let raw: Vec<_> = data.iter().map(|(x, y)| (x.to_vec(), y.to_vec())).collect();
        assert_eq!(raw[1], (vec![0.3], vec![3.0]));
        let patterns = data.patterns(&data.input_scalings(), &data.target_scalings());
        let expected = [-1.0, 1.0, 2.0 * 2_f64.ln() / 3_f64.ln() - 1.0];
        for (scaled, expected) in patterns.targets.iter().zip(expected) {
            assert!((scaled - expected).abs() < 1e-15, "{scaled} {expected}");
        }
    }

    #[test]
    fn the_hash_is_that_of_the_bytes() {
        let data = read("x,y\n1,2\n", &["x"], &["y"]).unwrap();
        // As `printf 'x,y\n1,2\n' | sha256sum` says.
        let known = "81bf9fa83c6f7f151bd491a98cd7d933de3965289e3ebd77c6c425f7eaa16392";
        assert_eq!(data.sha256, known);
    }

    #[test]
    fn messages_say_where_and_what() {
        assert_eq!(
            message("v,f_n\n1,2\n", &["speed"]),
            "grasps.csv: no column \"speed\" (there are: v, f_n)"
        );
        assert_eq!(
            message("v,f_n\n1,2\n\nfast,3\n", &["v"]),
            "grasps.csv, line 4, column \"v\": \"fast\" is not a finite number"
        );
        assert_eq!(
            message("v,f_n\n1,2\n3\n", &["v"]),
            "grasps.csv, line 3: 1 fields where the header has 2"
        );
        assert_eq!(
            message("v,f_n\n0.5,2\n0,3\n", &["v:ln"]),
            "grasps.csv, line 3, column \"v\": the logarithm needs a value above 0, this is 0"
        );
        assert_eq!(message("v,v,f_n\n1,1,1\n", &["v"]), "grasps.csv: several columns \"v\"");
        assert_eq!(message("v,f_n\n", &["v"]), "grasps.csv: no rows below the header");
        assert_eq!(message("", &["v"]), "grasps.csv: no header row");
        assert_eq!(message("v,f_n\n1,1\n", &["f_n"]), "column \"f_n\" is used twice");
        assert!(matches!(
            read("x,y\n1,2\n", &[], &["y"]),
            Err(DataSetError::Columns { kind: "input", given: 0 })
        ));
    }

    #[test]
    fn what_is_not_finite_is_refused() {
        for text in ["NaN", "nan", "inf", "-inf", "1e999", "1e39", "", "1,5"] {
            let csv = format!("v,f_n\n\"{text}\",1\n");
            let error = read(&csv, &["v"], &["f_n"]).unwrap_err();
            assert!(matches!(error, DataSetError::NotANumber { .. }), "{text}: {error}");
        }
    }

    #[test]
    fn bytes_that_are_no_text_are_refused() {
        let error = DataSet::from_csv(
            "grasps.csv",
            b"v,f_n\n1,2\n\xff\xfe,3\n",
            &specs(&["v"]),
            &specs(&["f_n"]),
        )
        .unwrap_err();
        assert!(matches!(error, DataSetError::Malformed { line: 3, .. }), "{error:?}");
    }
}
