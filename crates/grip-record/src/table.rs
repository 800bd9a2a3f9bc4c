//! The bytes of a CSV file in as they are read, a header and rows with their true line numbers out.

use std::borrow::Cow;
use std::io::Read;
use std::path::{Path, PathBuf};

use csv::{ByteRecord, Reader, ReaderBuilder};

use crate::error::{CsvError, excerpt};
use crate::lines::Lines;
use crate::number::{TimeFault, parse_micros};
use slip_core::units::Micros;

/// Bytes that are read at once.
const BUFFER: usize = 1 << 16;
const PLAIN_NUMBER: &str = "write digits with a decimal point";

/// A file's rows, checked for the width of the header. Lines are counted here because the position of a
/// record includes the blank lines before it and half of a CR LF.
#[derive(Debug)]
pub(crate) struct Table<R> {
    file: PathBuf,
    reader: Reader<Lines<R>>,
    record: ByteRecord,
    header: Vec<String>,
    header_line: u64,
}

/// One row: as many cells as the header has names.
pub(crate) struct Row<'a> {
    pub(crate) line: u64,
    /// Blank lines since the row before.
    pub(crate) blank_before: usize,
    file: &'a Path,
    header: &'a [String],
    cells: &'a ByteRecord,
}

impl<R: Read> Table<R> {
    /// Reads the header: names trimmed, a byte order mark dropped, no name twice.
    pub(crate) fn open(file: &Path, input: R) -> Result<Self, CsvError> {
        let unreadable = |source| CsvError::Unreadable { file: file.to_owned(), source };
        let lines = Lines::new(input).map_err(unreadable)?;
        let reader = ReaderBuilder::new()
            .has_headers(false)
            .flexible(true)
            .buffer_capacity(BUFFER)
            .from_reader(lines);
        let (file, record) = (file.to_owned(), ByteRecord::new());
        let mut table = Self { file, reader, record, header: Vec::new(), header_line: 1 };
        let Some((line, _)) = table.advance()? else {
            return Err(CsvError::Empty { file: table.file });
        };
        let control = |byte: &u8| byte.is_ascii_control() && !matches!(byte, b'\t' | b'\r' | b'\n');
        if table.record.as_slice().iter().any(control) {
            return Err(CsvError::NoText { file: table.file });
        }
        table.header_line = line;
        table.header = table
            .record
            .iter()
            .map(|name| String::from_utf8_lossy(name).trim().to_owned())
            .collect();
        table.refuse_repeated_names()?;
        Ok(table)
    }

    pub(crate) fn header(&self) -> &[String] {
        &self.header
    }

    /// Number of the column called `name`, from 0.
    pub(crate) fn position(&self, name: &str) -> Option<usize> {
        self.header.iter().position(|column| column == name)
    }

    /// The column called `name`, which must be there.
    pub(crate) fn required(&self, name: &'static str) -> Result<usize, CsvError> {
        self.position(name).ok_or_else(|| CsvError::MissingColumn {
            file: self.file.to_owned(),
            wanted: name,
            found: self.header.clone(),
        })
    }

    /// The next row, `None` at the end.
    pub(crate) fn next_row(&mut self) -> Result<Option<Row<'_>>, CsvError> {
        let Some((line, blank_before)) = self.advance()? else { return Ok(None) };
        let (expected, found) = (self.header.len(), self.record.len());
        if expected != found {
            return Err(CsvError::FieldCount { file: self.file.to_owned(), line, expected, found });
        }
        Ok(Some(Row {
            line,
            blank_before,
            file: &self.file,
            header: &self.header,
            cells: &self.record,
        }))
    }

    fn advance(&mut self) -> Result<Option<(u64, usize)>, CsvError> {
        let more = self.reader.read_byte_record(&mut self.record).map_err(|error| {
            CsvError::Unreadable { file: self.file.to_owned(), source: error.into() }
        })?;
        let start = self.record.position().map(csv::Position::byte).filter(|_| more);
        Ok(start.map(|start| self.reader.get_mut().locate(start)))
    }

    fn refuse_repeated_names(&self) -> Result<(), CsvError> {
        for (second, name) in self.header.iter().enumerate() {
            if let Some(first) = self.position(name).filter(|first| *first < second) {
                return Err(CsvError::RepeatedColumn {
                    file: self.file.to_owned(),
                    line: self.header_line,
                    name: name.clone(),
                    first: first + 1,
                    second: second + 1,
                });
            }
        }
        Ok(())
    }
}

impl Row<'_> {
    /// The cell at `column` (from 0), trimmed; bytes that are not UTF-8 become replacement characters.
    pub(crate) fn cell(&self, column: usize) -> Cow<'_, str> {
        let bytes = self.cells.get(column).unwrap_or_default();
        String::from_utf8_lossy(bytes.trim_ascii())
    }

    /// The cell at `column` as a time that is not before `previous`.
    pub(crate) fn time(&self, column: usize, previous: Option<Micros>) -> Result<Micros, CsvError> {
        let text = self.cell(column);
        let time = parse_micros(&text).map_err(|fault| match fault {
            TimeFault::NotANumber => self.not_a_number(column, PLAIN_NUMBER),
            TimeFault::OutOfRange => CsvError::TimeOutOfRange {
                file: self.file.to_owned(),
                line: self.line,
                column: self.name(column),
                text: excerpt(&text),
            },
        })?;
        match previous.filter(|before| *before > time) {
            None => Ok(time),
            Some(before) => Err(CsvError::TimeBackwards {
                file: self.file.to_owned(),
                line: self.line,
                column: self.name(column),
                before: before.as_seconds(),
                time: time.as_seconds(),
            }),
        }
    }

    /// The cell at `column` as a number, which may be infinite or NaN.
    pub(crate) fn number(&self, column: usize) -> Result<f64, CsvError> {
        self.cell(column).parse().map_err(|_| self.not_a_number(column, PLAIN_NUMBER))
    }

    /// The cell at `column` as a finite number.
    pub(crate) fn finite(&self, column: usize) -> Result<f64, CsvError> {
        let text = self.cell(column);
        let value = self.number(column)?;
        if value.is_finite() {
            return Ok(value);
        }
        Err(CsvError::NotFinite {
            file: self.file.to_owned(),
            line: self.line,
            column: self.name(column),
            text: excerpt(&text),
        })
    }

    pub(crate) fn not_a_number(&self, column: usize, remedy: &'static str) -> CsvError {
        CsvError::NotANumber {
            file: self.file.to_owned(),
            line: self.line,
            column: self.name(column),
            text: excerpt(&self.cell(column)),
            remedy,
        }
    }

    fn name(&self, column: usize) -> String {
        self.header.get(column).cloned().unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows(text: &str) -> Vec<(u64, usize, String)> {
        let mut table = Table::open(Path::new("t.csv"), text.as_bytes()).unwrap();
        let mut rows = Vec::new();
        while let Some(row) = table.next_row().unwrap() {
            rows.push((row.line, row.blank_before, row.cell(0).into_owned()));
        }
        rows
    }

    #[test]
    fn lines_are_those_an_editor_shows() {
        let expected = vec![(2, 0, "1".to_owned()), (5, 2, "2".to_owned()), (6, 0, "3".to_owned())];
        for end in ["\n", "\r\n", "\r"] {
            let text = ["a,b", "1,", "", "", "2,x", "3,", ""].join(end);
            assert_eq!(rows(&text), expected, "{end:?}");
            assert_eq!(rows(text.trim_end()), expected, "without a last line end");
        }
    }

    /// Rows without end, each as wide as the header.
    struct Rows(u64);

    impl Read for Rows {
        fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
            let row = b"0.25,1\r\n";
            for byte in &mut *buffer {
                *byte = row[usize::try_from(self.0).unwrap() % row.len()];
                self.0 += 1;
            }
            Ok(buffer.len())
        }
    }

    #[test]
    fn a_file_of_any_length_takes_the_same_room() {
        let mut table = Table::open(Path::new("t.csv"), Rows(0)).unwrap();
        let mut most = 0;
        for line in 2..1_000_000 {
            let row = table.next_row().unwrap().unwrap();
            assert_eq!((row.line, row.blank_before), (line, 0));
            most = most.max(table.reader.get_ref().kept());
        }
        assert!(most <= 2 * BUFFER, "{most}");
    }

    #[test]
    fn a_line_without_end_is_refused() {
        let mut table =
            Table::open(Path::new("t.csv"), b"a\n1\n".chain(std::io::repeat(0))).unwrap();
        assert!(table.next_row().unwrap().is_some());
        let text = table.next_row().err().unwrap().to_string();
        assert!(text.contains("a line has more than"), "{text}");
        assert!(Table::open(Path::new("t.csv"), std::io::repeat(b'x')).is_err());
    }

    #[test]
    fn a_quoted_line_break_counts() {
        assert_eq!(
            rows("a,\"b\nc\"\n1,\"x\n\ny\"\n2,z\n"),
            vec![(3, 0, "1".to_owned()), (6, 0, "2".to_owned())]
        );
    }

    #[test]
    fn a_byte_order_mark_is_not_part_of_the_name() {
        let table = Table::open(Path::new("t.csv"), "\u{feff} a , b\r\n".as_bytes()).unwrap();
        assert_eq!(table.header(), ["a", "b"]);
    }
}
