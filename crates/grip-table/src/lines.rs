//! Lines of a file that is read once, each of bounded length.

use std::io::{self, BufRead as _, BufReader, Read};

use memchr::memchr2;

/// Bytes that are read at once.
const BUFFER: usize = 1 << 16;
/// The longest line, and the longest run of NULs, that is believed (bytes). Rows of 256 taxels take some thousand.
pub(crate) const LONGEST_LINE: usize = 1 << 20;

/// Why there is no next line.
#[derive(Debug)]
pub(crate) enum LineFault {
    Read(io::Error),
    TooLong,
}

/// How a line ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Ended {
    /// By a line end, not by the end of the file.
    pub(crate) by_line_end: bool,
    /// NULs before its text, which are left out: a file system writes them for data that a power cut took.
    pub(crate) nuls: usize,
}

/// A line ends with LF, CR LF or CR.
#[derive(Debug)]
pub(crate) struct Lines<R> {
    input: BufReader<R>,
    after_cr: bool,
    /// Nothing but NULs is left, as far as is looked.
    done: bool,
}

impl<R: Read> Lines<R> {
    pub(crate) fn new(input: R) -> Self {
        Self { input: BufReader::with_capacity(BUFFER, input), after_cr: false, done: false }
    }

    /// Appends the next line to `line`; `None` at the end of the file. More NULs than [`LONGEST_LINE`] are the end.
    pub(crate) fn next(&mut self, line: &mut Vec<u8>) -> Result<Option<Ended>, LineFault> {
        let start = line.len();
        let (mut any, mut nuls) = (false, 0);
        loop {
            let bytes = match self.input.fill_buf() {
                Ok(bytes) => bytes,
                Err(error) if error.kind() == io::ErrorKind::Interrupted => continue,
                Err(error) => return Err(LineFault::Read(error)),
            };
            self.done |= nuls > LONGEST_LINE;
            if bytes.is_empty() || self.done {
                return Ok(any.then_some(Ended { by_line_end: false, nuls }));
            }
            if self.after_cr {
                self.after_cr = false;
                if bytes.first() == Some(&b'\n') {
                    self.input.consume(1);
                    continue;
                }
            }
            any = true;
            let end = memchr2(b'\n', b'\r', bytes);
            let mut text = bytes.get(..end.unwrap_or(bytes.len())).unwrap_or_default();
            if line.len() == start {
                let before = text.iter().take_while(|byte| **byte == 0).count();
                nuls += before;
                text = text.get(before..).unwrap_or_default();
            }
            line.extend_from_slice(text);
            self.after_cr = end.is_some_and(|at| bytes.get(at) == Some(&b'\r'));
            let used = end.map_or(bytes.len(), |at| at + 1);
            self.input.consume(used);
            if end.is_some() {
                return Ok(Some(Ended { by_line_end: true, nuls }));
            }
            if line.len() - start > LONGEST_LINE {
                return Err(LineFault::TooLong);
            }
        }
    }
}
