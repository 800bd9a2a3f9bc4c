//! Records of cells, split by one delimiter, with the numbers of their lines.

use std::io::Read;

use csv_core::{ReadRecordResult, Reader, ReaderBuilder};

use crate::lines::{Ended, LONGEST_LINE, LineFault, Lines};

/// What stands between two cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Delimiter {
    /// One byte: a comma, a semicolon, a tab or a vertical bar.
    Byte(u8),
    /// Any number of blanks and tabs.
    Blanks,
}

impl Delimiter {
    const fn byte(self) -> u8 {
        match self {
            Self::Byte(byte) => byte,
            Self::Blanks => b' ',
        }
    }
}

/// Why there is no next record.
#[derive(Debug)]
pub(crate) enum RecordFault {
    Line(LineFault),
    /// A quotation mark without its partner.
    OpenQuote,
}

/// One record.
#[derive(Debug)]
pub(crate) struct Record {
    text: Vec<u8>,
    cells: Vec<u8>,
    ends: Vec<usize>,
    count: usize,
    /// Its line, from 1.
    pub(crate) line: u64,
    /// Blank lines before it.
    pub(crate) blank_before: usize,
    pub(crate) ended: Ended,
}

/// The records of a file, one at a time.
#[derive(Debug)]
pub(crate) struct Records<R> {
    lines: Lines<R>,
    reader: Reader,
    delimiter: Delimiter,
    /// Lines so far.
    read: u64,
    pub(crate) now: Record,
}

impl<R: Read> Records<R> {
    pub(crate) fn new(input: R, delimiter: Delimiter) -> Self {
        Self {
            lines: Lines::new(input),
            reader: ReaderBuilder::new().delimiter(delimiter.byte()).build(),
            delimiter,
            read: 0,
            now: Record {
                text: Vec::new(),
                cells: vec![0; 256],
                ends: vec![0; 16],
                count: 0,
                line: 0,
                blank_before: 0,
                ended: Ended { by_line_end: true, nuls: 0 },
            },
        }
    }

    /// Goes to the next record that is not blank; false at the end.
    pub(crate) fn advance(&mut self) -> Result<bool, RecordFault> {
        self.now.blank_before = 0;
        let mut nuls = 0;
        loop {
            if !self.next_line()? {
                self.now.line = self.read;
                self.now.ended.nuls = nuls;
                return Ok(false);
            }
            nuls += self.now.ended.nuls;
            if !self.is_blank() {
                break;
            }
            self.now.blank_before += usize::from(self.now.ended.nuls == 0);
        }
        self.now.line = self.read;
        self.split()?;
        self.now.ended.nuls = nuls;
        Ok(true)
    }

    fn next_line(&mut self) -> Result<bool, RecordFault> {
        self.now.text.clear();
        match self.lines.next(&mut self.now.text).map_err(RecordFault::Line)? {
            None => Ok(false),
            Some(ended) => {
                self.read += 1;
                self.now.ended = ended;
                Ok(true)
            }
        }
    }

    fn is_blank(&self) -> bool {
        let tab = self.delimiter == Delimiter::Byte(b'\t');
        self.now.text.iter().all(|byte| *byte == b' ' || (*byte == b'\t' && !tab))
    }

    fn split(&mut self) -> Result<(), RecordFault> {
        let (mut length, mut length_of_ends, mut lines) = (0, 0, 0);
        loop {
            if self.delimiter == Delimiter::Blanks {
                collapse(&mut self.now.text);
            }
            self.now.text.push(b'\n');
            let mut at = 0;
            loop {
                let (result, read, written, ends) = self.reader.read_record(
                    self.now.text.get(at..).unwrap_or_default(),
                    self.now.cells.get_mut(length..).unwrap_or_default(),
                    self.now.ends.get_mut(length_of_ends..).unwrap_or_default(),
                );
                at += read;
                length += written;
                length_of_ends += ends;
                match result {
                    ReadRecordResult::Record | ReadRecordResult::End => {
                        self.now.count = length_of_ends;
                        return Ok(());
                    }
                    ReadRecordResult::InputEmpty => break,
                    ReadRecordResult::OutputFull => {
                        self.now.cells.resize(2 * self.now.cells.len(), 0)
                    }
                    ReadRecordResult::OutputEndsFull => {
                        self.now.ends.resize(2 * self.now.ends.len(), 0)
                    }
                }
            }
            // Inside of quotes.
            lines += 1;
            if length > LONGEST_LINE || lines > MOST_QUOTED_LINES || !self.next_line()? {
                return Err(RecordFault::OpenQuote);
            }
        }
    }
}

/// Most lines of one quoted cell.
const MOST_QUOTED_LINES: usize = 1000;

impl Record {
    /// Number of cells.
    pub(crate) const fn len(&self) -> usize {
        self.count
    }

    /// The cell at `column`, trimmed; empty where there is none.
    #[inline]
    pub(crate) fn cell(&self, column: usize) -> &[u8] {
        if column >= self.count {
            return &[];
        }
        let end = self.ends.get(column).copied().unwrap_or(0);
        let start =
            column.checked_sub(1).and_then(|before| self.ends.get(before)).copied().unwrap_or(0);
        self.cells.get(start..end).unwrap_or_default().trim_ascii()
    }

    pub(crate) fn cells(&self) -> impl Iterator<Item = &[u8]> {
        (0..self.count).map(|column| self.cell(column))
    }

    /// The last line of the record without its line end, as far as the delimiter left it.
    pub(crate) fn text(&self) -> &[u8] {
        self.text.trim_ascii()
    }
}

/// Makes one blank of each run outside of quotes, and none at the ends.
fn collapse(text: &mut Vec<u8>) {
    let (mut quoted, mut before) = (false, b' ');
    text.retain_mut(|byte| {
        quoted ^= *byte == b'"';
        if *byte == b'\t' && !quoted {
            *byte = b' ';
        }
        let kept = quoted || *byte != b' ' || before != b' ';
        before = *byte;
        kept
    });
    while text.last() == Some(&b' ') {
        text.pop();
    }
}
