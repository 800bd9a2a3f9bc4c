//! Bytes in as they are read, the numbers of their lines out: only what is not yet numbered is kept.

use std::collections::VecDeque;
use std::io::{self, Cursor, Read};

const BYTE_ORDER_MARK: [u8; 3] = *b"\xEF\xBB\xBF";
/// The longest line that is believed (bytes). Rows of 256 taxels take some thousand.
const LONGEST_LINE: usize = 1 << 20;

/// A file on its way to the CSV reader.
#[derive(Debug)]
pub(crate) struct Lines<R> {
    input: io::Chain<Cursor<Vec<u8>>, R>,
    /// The bytes from `from` on, as far as they were read.
    kept: VecDeque<u8>,
    from: u64,
    /// Bytes since the last end of a line.
    open: usize,
    /// Line of the byte at `from`, and the byte before it.
    line: u64,
    before: u8,
}

impl<R: Read> Lines<R> {
    /// From the start of a file, without its byte order mark.
    pub(crate) fn new(mut input: R) -> io::Result<Self> {
        let mut start = Vec::new();
        (&mut input).take(BYTE_ORDER_MARK.len() as u64).read_to_end(&mut start)?;
        if start == BYTE_ORDER_MARK {
            start.clear();
        }
        let (input, kept) = (Cursor::new(start).chain(input), VecDeque::new());
        Ok(Self { input, kept, from: 0, open: 0, line: 1, before: 0 })
    }

    /// Line of the first content at or behind the byte `start`, and the blank lines between; what is before is forgotten. A line ends with
    /// LF, CR LF or CR.
    pub(crate) fn locate(&mut self, start: u64) -> (u64, usize) {
        self.pass(usize::try_from(start.saturating_sub(self.from)).unwrap_or(usize::MAX));
        let line = self.line;
        let blank = self.kept.iter().take_while(|byte| matches!(byte, b'\r' | b'\n')).count();
        self.pass(blank);
        (self.line, usize::try_from(self.line - line).unwrap_or(usize::MAX))
    }

    /// Goes past so many bytes, or all there are.
    fn pass(&mut self, count: usize) {
        let count = count.min(self.kept.len());
        for byte in self.kept.drain(..count) {
            // A CR LF is counted at its CR.
            self.line += u64::from(byte == b'\r' || (byte == b'\n' && self.before != b'\r'));
            self.before = byte;
        }
        self.from += count as u64;
    }

    /// Bytes that are kept.
    #[cfg(test)]
    pub(crate) fn kept(&self) -> usize {
        self.kept.len()
    }
}

impl<R: Read> Read for Lines<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let read = self.input.read(buffer)?;
        let bytes = buffer.get(..read).unwrap_or_default();
        self.kept.extend(bytes);
        match bytes.iter().rposition(|byte| matches!(byte, b'\r' | b'\n')) {
            Some(end) => self.open = read - end,
            None => self.open += read,
        }
        if self.open > LONGEST_LINE {
            let text = format!("it is no table: a line has more than {LONGEST_LINE} bytes");
            return Err(io::Error::new(io::ErrorKind::InvalidData, text));
        }
        Ok(read)
    }
}
