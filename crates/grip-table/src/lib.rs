//! Tables of numbers as people have them: the one reader behind every program that takes a table.
//!
//! A [`Table`] finds the form of a file in its first bytes ([`LOOK_AHEAD`], at most [`LOOK_AHEAD_LINES`] lines) and
//! then gives its rows one after the other; its memory does not depend on the length of the file.
//!
//! | what | how |
//! |---|---|
//! | encodings | UTF-8, UTF-16 with a byte order mark or evident without, else Windows-1252; lines end with LF, CR LF or CR |
//! | delimiters | `,` `;` tab `\|` or blanks: the one that makes the most numbers; a first line `sep=;` is obeyed |
//! | decimal sign | point; comma where no comma separates or cells are in quotes; what may be thousands is refused |
//! | text before the rows | passed over; the header is the last line of text with as many cells as the rows |
//! | comments | lines that begin with `#`, `%` or `//`; one may be the header |
//! | units | of a row below the header, or of the name: [`Column::unit`], [`scale`] |
//! | columns of text | [`Column::is_text`]; a cell is read only when it is asked for |
//! | NaN | also `NA`, `null`, `None`, `-`, `#N/A`, `#NUM!`, `-nan(ind)`, `1.#QNAN` and more; a blank cell is none |
//! | the end | up to 64 lines that are no rows are left out and reported: [`Table::losses`] |
//! | other kinds of files | named by their first bytes ([`TableError::Foreign`]); `.xlsx` is read with the feature `xlsx` |
//!
//! Limits: a line has at most 1 MiB. The form is that of the look-ahead: a column that turns into text later is an
//! error where it is used. A table [written by hand](Table::by_hand) has its header in its first line, and every row
//! counts.
//!
#![doc = include_str!("../README.md")]

mod detect;
mod error;
mod foreign;
mod lines;
mod number;
mod quantity;
mod records;
mod unit;
#[cfg(feature = "xlsx")]
mod xlsx;

pub use detect::{Column, Header};
pub use error::{TableError, excerpt, list, visible};
pub use number::Decimal;
pub use records::Delimiter;
pub use unit::{Quantity, of_name, scale};

use std::{
    borrow::Cow,
    fmt,
    io::{Chain, Cursor, Read},
    path::{Path, PathBuf},
};

use encoding_rs::{Encoding, UTF_16BE, UTF_16LE, WINDOWS_1252};
use encoding_rs_io::{DecodeReaderBytes, DecodeReaderBytesBuilder};

use detect::Shape;
use lines::{LONGEST_LINE, LineFault};
use number::{Points, plain, remedy};
use records::{Record, RecordFault, Records};

/// Bytes and lines in which the form of a table is looked for.
pub const LOOK_AHEAD: usize = 256 << 10;
/// See [`LOOK_AHEAD`].
pub const LOOK_AHEAD_LINES: usize = 200;
/// Lines at the end of a file that may be no rows.
const MOST_AFTER: usize = 64;
/// Places of damage that are kept.
const MOST_LOSSES: usize = 16;
const PLAIN_NUMBER: &str = "write digits with a decimal point";

type Decoded<R> = DecodeReaderBytes<Chain<Cursor<Vec<u8>>, R>, Vec<u8>>;

/// Something of a file that was no row and is left out.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Loss {
    /// Its line.
    pub line: u64,
    /// What it is.
    pub kind: LossKind,
    /// The beginning of its text.
    pub text: String,
}

/// What is left out of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LossKind {
    /// A last row that was cut off: numbers are lost.
    Cut,
    /// NULs or other bytes that are no text, in the place of rows: numbers are lost.
    Bytes,
    /// A line of text after the rows: no numbers are lost.
    Remark,
}

impl Loss {
    /// Whether rows were lost, so that a program ends with the code for a loss of data.
    #[must_use]
    pub fn is_data(&self) -> bool {
        self.kind != LossKind::Remark
    }
}

impl fmt::Display for Loss {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { line, text, .. } = self;
        match self.kind {
            LossKind::Cut => write!(f, "line {line} was cut off and is left out: {text:?}"),
            LossKind::Bytes => write!(
                f,
                "line {line}: bytes that are no text stand in the place of rows; these are lost"
            ),
            LossKind::Remark => write!(f, "line {line} is no row and is left out: {text:?}"),
        }
    }
}

/// A file's rows under the names of its columns.
#[derive(Debug)]
pub struct Table<R> {
    file: PathBuf,
    records: Records<Chain<Cursor<Vec<u8>>, Decoded<R>>>,
    shape: Shape,
    names: Vec<String>,
    /// Columns that are not text.
    numbers: Vec<usize>,
    by_hand: bool,
    rows: u64,
    losses: Vec<Loss>,
}

/// One row.
#[derive(Clone, Copy, Debug)]
pub struct Row<'a> {
    /// Its line, from 1; that of its beginning where cells have line breaks.
    pub line: u64,
    /// Blank lines since the row before.
    pub blank_before: usize,
    file: &'a Path,
    names: &'a [String],
    record: &'a Record,
    decimal: Decimal,
    points: &'a [Points],
}

impl<R: Read> Table<R> {
    /// Finds the form of the table in `input`; `file` stands in errors.
    ///
    /// # Errors
    /// Where it cannot be read, is empty or is no table.
    pub fn open(file: &Path, input: R) -> Result<Self, TableError> {
        Self::new(file, input, false)
    }

    /// The same for a table that somebody writes: its first line is the header, every line below is a row, also the
    /// last one.
    ///
    /// # Errors
    /// As [`Table::open`].
    pub fn by_hand(file: &Path, input: R) -> Result<Self, TableError> {
        Self::new(file, input, true)
    }

    fn new(file: &Path, mut input: R, by_hand: bool) -> Result<Self, TableError> {
        let unreadable = |source| TableError::Unreadable { file: file.to_owned(), source };
        let mut head = Vec::new();
        (&mut input).take(4096).read_to_end(&mut head).map_err(unreadable)?;
        #[cfg(feature = "xlsx")]
        if xlsx::is_workbook(&head) {
            head = xlsx::text_of(file, &head, &mut input)?;
        }
        if let Some((kind, remedy)) = foreign::kind(&head) {
            return Err(TableError::Foreign { file: file.to_owned(), kind, remedy });
        }
        let mut decoded = DecodeReaderBytesBuilder::new()
            .encoding(utf16(&head))
            .utf8_passthru(true)
            .strip_bom(true)
            .bom_override(true)
            .build(Cursor::new(head).chain(input));
        let mut start = Vec::new();
        (&mut decoded).take(LOOK_AHEAD as u64).read_to_end(&mut start).map_err(unreadable)?;
        let whole = start.len() < LOOK_AHEAD;
        if !whole && memchr::memchr2(b'\n', b'\r', &start).is_none() {
            return Err(TableError::LongLine { file: file.to_owned() });
        }
        let nuls = start.iter().rev().take_while(|byte| **byte == 0).count();
        let text = start.get(..start.len() - nuls).unwrap_or_default();
        let controls = text.iter().filter(|byte| is_control(byte)).count();
        if !start.is_empty() && 8 * controls >= text.len() {
            return Err(TableError::NoText { file: file.to_owned() });
        }
        let shape = detect::shape(&start, whole, by_hand)
            .map_err(|(line, fault)| fault_of(file, line, fault))?
            .ok_or_else(|| TableError::Empty { file: file.to_owned() })?;
        if let Some((line, text)) = shape.commas {
            return Err(TableError::DecimalCommas {
                file: file.to_owned(),
                line,
                text: excerpt(&text),
            });
        }
        if shape.columns.iter().any(|column| column.given.bytes().any(|byte| is_control(&byte))) {
            return Err(TableError::NoText { file: file.to_owned() });
        }
        let names = shape.columns.iter().map(|column| column.name.clone()).collect();
        let of_numbers = |(at, column): (usize, &Column)| (!column.is_text).then_some(at);
        let numbers = shape.columns.iter().enumerate().filter_map(of_numbers).collect();
        let records = Records::new(Cursor::new(start).chain(decoded), shape.delimiter);
        Ok(Self {
            file: file.to_owned(),
            records,
            shape,
            names,
            numbers,
            by_hand,
            rows: 0,
            losses: Vec::new(),
        })
    }

    /// The next row, `None` at the end.
    ///
    /// # Errors
    /// Where the file cannot be read, or a line is no row and rows follow it.
    pub fn next_row(&mut self) -> Result<Option<Row<'_>>, TableError> {
        let Some(blank_before) = self.advance()? else { return Ok(None) };
        self.rows += 1;
        Ok(Some(Row { blank_before, ..self.row() }))
    }

    /// Goes to the next row; gives the blank lines before it.
    fn advance(&mut self) -> Result<Option<usize>, TableError> {
        let mut blank = 0;
        loop {
            let more = self.next_record()?;
            if self.rows > 0 && self.records.now.ended.nuls > 0 {
                self.lose(LossKind::Bytes);
            }
            if !more {
                return Ok(None);
            }
            if self.records.now.line < self.shape.first {
                continue;
            }
            blank += self.records.now.blank_before;
            let Some(fault) = self.fault() else { break };
            if self.is_comment() && !self.by_hand {
                continue;
            }
            self.end_with(fault)?;
            return Ok(None);
        }
        let last = self.shape.columns.len() - 1;
        let cut = !self.by_hand
            && !self.records.now.ended.by_line_end
            && self.shape.last_column.may_be_cut(self.records.now.cell(last));
        if cut {
            self.lose(LossKind::Cut);
            return Ok(None);
        }
        Ok(Some(blank))
    }

    fn next_record(&mut self) -> Result<bool, TableError> {
        self.records.advance().map_err(|fault| fault_of(&self.file, self.records.now.line, fault))
    }

    /// What keeps the record from being a row.
    fn fault(&self) -> Option<TableError> {
        let (expected, found) = (self.shape.columns.len(), self.records.now.len());
        let ends_blank =
            !self.by_hand && found == expected + 1 && self.records.now.cell(expected).is_empty();
        if !(self.shape.least..=expected).contains(&found) && !ends_blank {
            let (file, line) = (self.file.clone(), self.records.now.line);
            return Some(TableError::FieldCount { file, line, expected, found });
        }
        if self.by_hand || self.numbers.is_empty() {
            return None;
        }
        let mut text = None;
        for &column in &self.numbers {
            let cell = self.records.now.cell(column);
            match cell.first() {
                Some(b'0'..=b'9') => return None,
                None => {}
                Some(_) if number::parse(cell, self.shape.decimal).is_some() => return None,
                Some(_) => text = text.or(Some(column)),
            }
        }
        text.map(|column| self.row().not_a_number(column, PLAIN_NUMBER))
    }

    fn is_comment(&self) -> bool {
        detect::comment(self.records.now.cell(0)).is_some()
    }

    /// Leaves the record out and what follows, where that is the end of the file; otherwise it is a fault.
    fn end_with(&mut self, fault: TableError) -> Result<(), TableError> {
        if self.by_hand || self.rows == 0 {
            return Err(fault);
        }
        let given = self.shape.columns.iter().map(|column| column.given.as_bytes());
        if self.records.now.cells().eq(given) {
            return Err(TableError::HeaderAgain {
                file: self.file.clone(),
                line: self.records.now.line,
            });
        }
        self.lose(self.kind_of_loss());
        for _ in 0..MOST_AFTER {
            if !self.next_record().unwrap_or(false) {
                return Ok(());
            }
            if self.fault().is_none() {
                return Err(fault);
            }
            self.lose(self.kind_of_loss());
        }
        Err(fault)
    }

    fn kind_of_loss(&self) -> LossKind {
        let is_number = |column: &usize| {
            let cell = self.records.now.cell(*column);
            cell.is_empty() || number::parse(cell, self.shape.decimal).is_some()
        };
        let cells = self.records.now.len();
        let has_cells = self.numbers.iter().filter(|column| **column + 1 < cells).all(is_number);
        if self.records.now.text().iter().any(is_control) {
            LossKind::Bytes
        } else if cells < self.shape.least
            && has_cells
            && (!self.records.now.ended.by_line_end || cells > 1)
        {
            LossKind::Cut
        } else {
            LossKind::Remark
        }
    }

    fn lose(&mut self, kind: LossKind) {
        if self.losses.len() < MOST_LOSSES {
            let text = excerpt(&text(self.records.now.text()));
            self.losses.push(Loss { line: self.records.now.line, kind, text });
        }
    }
}

impl<R> Table<R> {
    fn row(&self) -> Row<'_> {
        Row {
            line: self.records.now.line,
            blank_before: 0,
            file: &self.file,
            names: &self.names,
            decimal: self.shape.decimal,
            points: &self.shape.points,
            record: &self.records.now,
        }
    }

    /// The names of the columns.
    #[must_use]
    pub fn header(&self) -> &[String] {
        &self.names
    }

    /// The columns.
    #[must_use]
    pub fn columns(&self) -> &[Column] {
        &self.shape.columns
    }

    /// Where their names come from.
    #[must_use]
    pub const fn header_line(&self) -> Header {
        self.shape.header
    }

    /// What stands between two cells.
    #[must_use]
    pub const fn delimiter(&self) -> Delimiter {
        self.shape.delimiter
    }

    /// What was left out so far.
    #[must_use]
    pub fn losses(&self) -> &[Loss] {
        &self.losses
    }

    /// Number of the column called `name`, from 0.
    #[must_use]
    pub fn position(&self, name: &str) -> Option<usize> {
        self.names.iter().position(|column| column == name)
    }

    /// The column called `name`, which must be there, once.
    ///
    /// # Errors
    /// Where it is not.
    pub fn required(&self, name: &str) -> Result<usize, TableError> {
        self.check_repeated(|column| column == name)?;
        self.position(name).ok_or_else(|| self.missing(name.to_owned(), &[]))
    }

    /// # Errors
    /// Where two columns have one name that is used.
    pub fn check_repeated(&self, is_used: impl Fn(&str) -> bool) -> Result<(), TableError> {
        for (second, column) in self.shape.columns.iter().enumerate() {
            if let (Some(first), Header::Line(line) | Header::Numbers(line)) =
                (column.repeats, self.shape.header)
                && is_used(&column.given)
            {
                return Err(TableError::Repeated {
                    file: self.file.clone(),
                    line,
                    name: column.given.clone(),
                    first: first + 1,
                    second: second + 1,
                });
            }
        }
        Ok(())
    }
}

impl<'a> Row<'a> {
    /// The cell at `column` (from 0), trimmed; bytes that are not UTF-8 are taken for Windows-1252.
    #[inline]
    #[must_use]
    pub fn cell(&self, column: usize) -> Cow<'a, str> {
        text(self.record.cell(column))
    }

    /// The cell at `column` as a number, which may be infinite or NaN; `None` where it is blank.
    ///
    /// # Errors
    /// Where it is text.
    #[inline]
    pub fn value(&self, column: usize) -> Result<Option<f64>, TableError> {
        let cell = self.record.cell(column);
        if cell.is_empty() {
            return Ok(None);
        }
        number::parse(cell, self.decimal)
            .filter(|_| !self.may_be_thousands(column))
            .map(Some)
            .ok_or_else(|| self.not_a_number(column, PLAIN_NUMBER))
    }

    /// The same, where a blank cell is no number either.
    ///
    /// # Errors
    /// Where it is blank or text.
    #[inline]
    pub fn number(&self, column: usize) -> Result<f64, TableError> {
        self.value(column)?.ok_or_else(|| self.not_a_number(column, PLAIN_NUMBER))
    }

    /// The cell at `column` as a finite number.
    ///
    /// # Errors
    /// Where it is none.
    pub fn finite(&self, column: usize) -> Result<f64, TableError> {
        let value = self.number(column)?;
        if value.is_finite() {
            return Ok(value);
        }
        Err(TableError::NotFinite {
            file: self.file.to_owned(),
            line: self.line,
            column: self.name(column),
            text: excerpt(&self.cell(column)),
        })
    }

    /// The text of a number with a decimal point, for readings that a `f64` would round.
    #[inline]
    #[must_use]
    pub fn digits(&self, column: usize) -> Cow<'a, str> {
        match self.cell(column) {
            text if self.may_be_thousands(column) => Cow::Owned(format!("'{text}")),
            text if self.decimal == Decimal::Point => text,
            Cow::Borrowed(text) => plain(text, self.decimal),
            owned @ Cow::Owned(_) => owned,
        }
    }

    #[inline]
    fn may_be_thousands(&self, column: usize) -> bool {
        let points = self.points.get(column).filter(|points| **points != Points::Clear);
        points.is_some_and(|points| points.leave_open(self.record.cell(column)))
    }

    /// That the cell at `column` is no number, with what helps.
    #[must_use]
    pub fn not_a_number(&self, column: usize, otherwise: &'static str) -> TableError {
        let text = self.cell(column);
        TableError::NotANumber {
            file: self.file.to_owned(),
            line: self.line,
            column: self.name(column),
            text: excerpt(&text),
            remedy: match self.may_be_thousands(column) {
                true => number::THOUSANDS,
                false => remedy(&text, self.decimal, otherwise),
            },
        }
    }

    /// The name of a column.
    #[must_use]
    pub fn name(&self, column: usize) -> String {
        self.names.get(column).cloned().unwrap_or_default()
    }

    /// The file, as it stands in errors.
    #[must_use]
    pub const fn file(&self) -> &'a Path {
        self.file
    }
}

/// Bytes as UTF-8, or as Windows-1252 where they are none.
#[inline]
fn text(bytes: &[u8]) -> Cow<'_, str> {
    match str::from_utf8(bytes) {
        Ok(text) => Cow::Borrowed(text),
        Err(_) => WINDOWS_1252.decode_without_bom_handling(bytes).0,
    }
}

/// Whether a byte is neither text nor what terminals and old systems put between it.
const fn is_control(byte: &u8) -> bool {
    byte.is_ascii_control() && !matches!(*byte, b'\t' | b'\r' | b'\n' | 0x0c | 0x1a | 0x1b)
}

/// UTF-16 without a byte order mark: every other byte is a NUL.
fn utf16(start: &[u8]) -> Option<&'static Encoding> {
    let pairs = || start.as_chunks::<2>().0.iter().take(64);
    let of = |at: usize| {
        pairs().filter(|pair| pair[at] == 0 && pair[1 - at] != 0).count() * 10 > pairs().count() * 9
    };
    match (of(0), of(1)) {
        (false, true) if start.len() > 3 => Some(UTF_16LE),
        (true, false) if start.len() > 3 => Some(UTF_16BE),
        _ => None,
    }
}

fn fault_of(file: &Path, line: u64, fault: RecordFault) -> TableError {
    let file = file.to_owned();
    match fault {
        RecordFault::OpenQuote => TableError::OpenQuote { file, line },
        RecordFault::Line(LineFault::TooLong) => TableError::LongLine { file },
        RecordFault::Line(LineFault::Read(source)) => TableError::Unreadable { file, source },
    }
}
