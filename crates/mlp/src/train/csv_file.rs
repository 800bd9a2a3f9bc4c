//! Bytes of a CSV file in, header and numbered rows out.

use csv::{ReaderBuilder, StringRecord, Trim};

use super::data::{DataSetError, Place};

/// A CSV file with a header row.
#[derive(Debug)]
pub(super) struct CsvFile<'a> {
    file: &'a str,
    bytes: &'a [u8],
    header: StringRecord,
    reader: csv::Reader<&'a [u8]>,
}

impl<'a> CsvFile<'a> {
    pub(super) fn open(file: &'a str, bytes: &'a [u8]) -> Result<Self, DataSetError> {
        let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        let mut reader = ReaderBuilder::new().flexible(true).trim(Trim::All).from_reader(bytes);
        let header = reader.headers().map_err(|error| malformed(file, &error))?.clone();
        if header.iter().all(str::is_empty) {
            return Err(DataSetError::NoHeader { file: file.to_owned() });
        }
        Ok(Self { file, bytes, header, reader })
    }

    /// Place of the column `name`.
    pub(super) fn column(&self, name: &str) -> Result<usize, DataSetError> {
        let mut places =
            self.header.iter().enumerate().filter(|(_, other)| *other == name).map(|(at, _)| at);
        match (places.next(), places.next()) {
            (Some(place), None) => Ok(place),
            (Some(_), Some(_)) => {
                Err(DataSetError::Ambiguous { file: self.file.to_owned(), column: name.to_owned() })
            }
            (None, _) => Err(DataSetError::Missing {
                file: self.file.to_owned(),
                column: name.to_owned(),
                available: self.header.iter().collect::<Vec<_>>().join(", "),
            }),
        }
    }

    /// The next row, or `None` at the end. Every row has as many fields as the header.
    pub(super) fn next_row(&mut self) -> Result<Option<Row<'a>>, DataSetError> {
        let mut fields = StringRecord::new();
        if !self.reader.read_record(&mut fields).map_err(|error| malformed(self.file, &error))? {
            return Ok(None);
        }
        let line = fields.position().map_or(0, |position| self.line_of_row(position));
        if fields.len() != self.header.len() {
            return Err(DataSetError::RowLength {
                file: self.file.to_owned(),
                line,
                needed: self.header.len(),
                given: fields.len(),
            });
        }
        Ok(Some(Row { file: self.file, line, fields }))
    }

    /// The reader's position of a row is in front of the blank lines above it.
    fn line_of_row(&self, position: &csv::Position) -> u64 {
        let start = usize::try_from(position.byte()).unwrap_or(usize::MAX);
        let rest = self.bytes.get(start..).unwrap_or_default();
        let blank = rest.iter().take_while(|byte| matches!(byte, b'\n' | b'\r'));
        position.line() + blank.filter(|byte| **byte == b'\n').count() as u64
    }
}

/// One row of data.
#[derive(Debug)]
pub(super) struct Row<'a> {
    file: &'a str,
    line: u64,
    fields: StringRecord,
}

impl Row<'_> {
    /// The number in field `at`, which belongs to the column `name`.
    pub(super) fn number(&self, at: usize, name: &str) -> Result<f64, DataSetError> {
        let text = self.fields.get(at).unwrap_or_default();
        match text.parse::<f64>() {
            Ok(value) if value.abs() <= f64::from(f32::MAX) => Ok(value),
            _ => Err(DataSetError::NotANumber { place: self.place(name), text: text.to_owned() }),
        }
    }

    /// The text in field `at`.
    pub(super) fn text(&self, at: usize) -> &str {
        self.fields.get(at).unwrap_or_default()
    }

    /// Where the field of column `name` stands.
    pub(super) fn place(&self, name: &str) -> Place {
        Place { file: self.file.to_owned(), line: self.line, column: name.to_owned() }
    }
}

fn malformed(file: &str, error: &csv::Error) -> DataSetError {
    DataSetError::Malformed {
        file: file.to_owned(),
        line: error.position().map_or(0, csv::Position::line),
        message: error.to_string(),
    }
}
