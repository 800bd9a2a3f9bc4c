//! Places of numbers of a fixed size in a file, and a reader of their rows, a piece at a time: what WAV, NPY and NPZ are alike.

use std::fs::File;
use std::io::{self, Read, Seek as _, SeekFrom};
use std::path::{Path, PathBuf};

use flate2::read::DeflateDecoder;

use crate::files;

/// Bytes that are read at once of one strand; a frame may be longer.
const PIECE: usize = 1 << 16;
/// Rows whose times show their unit and their pace.
const ROWS: usize = 1 << 16;

/// How a number is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Coding {
    /// IEEE 754, of 2, 4 or 8 bytes.
    Float,
    /// Two's complement.
    Signed,
    /// Counting from 0.
    Unsigned,
    /// G.711, mu-law.
    MuLaw,
    /// G.711, A-law.
    ALaw,
}

/// One number of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell {
    /// First byte in the frame, and bytes, 1 to 8.
    pub at: usize,
    /// Bytes, 1 to 8.
    pub size: usize,
    /// How it is written.
    pub coding: Coding,
    /// Whether the highest byte comes first.
    pub big_endian: bool,
    /// Of integers: what is taken off before they become doubles.
    pub zero: i64,
    /// What the number is multiplied by.
    pub scale: f64,
}

impl Cell {
    /// A number of `size` bytes at `at`, as it is.
    #[must_use]
    pub const fn new(at: usize, size: usize, coding: Coding, big_endian: bool) -> Self {
        Self { at, size, coding, big_endian, zero: 0, scale: 1.0 }
    }

    /// The integer as it is written, sign extended.
    pub(crate) fn integer(&self, frame: &[u8]) -> i128 {
        let mut bytes = [0; 8];
        let found = frame.get(self.at..self.at + self.size).unwrap_or_default();
        for (place, byte) in bytes.iter_mut().zip(found) {
            *place = *byte;
        }
        if self.big_endian {
            bytes[..self.size.min(8)].reverse();
        }
        let value = u64::from_le_bytes(bytes);
        let unused = 64 - 8 * self.size.clamp(1, 8);
        if self.coding == Coding::Signed {
            i128::from((value << unused).cast_signed() >> unused)
        } else {
            i128::from(value)
        }
    }

    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "bits of a float")]
    pub(crate) fn number(&self, frame: &[u8]) -> f64 {
        let bits = self.integer(frame);
        let value = match (self.coding, self.size) {
            (Coding::Float, 2) => half(bits as u16),
            (Coding::Float, 4) => f64::from(f32::from_bits(bits as u32)),
            (Coding::Float, _) => f64::from_bits(bits as u64),
            (Coding::Signed | Coding::Unsigned, _) => (bits - i128::from(self.zero)) as f64,
            (Coding::MuLaw, _) => mu_law(bits as u8),
            (Coding::ALaw, _) => a_law(bits as u8),
        };
        value * self.scale
    }
}

/// A float of 16 bits.
fn half(bits: u16) -> f64 {
    let (exponent, fraction) = (i32::from(bits >> 10 & 31), f64::from(bits & 0x3ff));
    let size = match exponent {
        0 => fraction * 2.0_f64.powi(-24),
        31 if fraction > 0.0 => f64::NAN,
        31 => f64::INFINITY,
        _ => (1024.0 + fraction) * 2.0_f64.powi(exponent - 25),
    };
    if bits >> 15 == 1 { -size } else { size }
}

/// As share of full scale, which is 2^15.
fn mu_law(byte: u8) -> f64 {
    let byte = !byte;
    let size = ((f64::from(byte & 15) * 8.0 + 132.0) * 2.0_f64.powi(i32::from(byte >> 4 & 7))
        - 132.0)
        / 32768.0;
    if byte >> 7 == 1 { -size } else { size }
}

/// As share of full scale, which is 2^15.
fn a_law(byte: u8) -> f64 {
    let byte = byte ^ 0x55;
    let (segment, step) = (i32::from(byte >> 4 & 7), f64::from(byte & 15) * 16.0 + 8.0);
    let size = if segment == 0 { step } else { (step + 256.0) * 2.0_f64.powi(segment - 1) };
    if byte >> 7 == 1 { size / 32768.0 } else { -size / 32768.0 }
}

/// Frames of equal size behind each other in a file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Strand {
    /// Place of the first byte, packed or not.
    pub offset: u64,
    /// Bytes of a frame, at least 1.
    pub frame: usize,
    /// Of a member of an archive: how it is packed.
    pub packed: Option<Packed>,
}

impl Strand {
    /// Leaves out so many (unpacked) bytes at its start.
    pub(crate) fn skip(&mut self, bytes: u64) {
        match &mut self.packed {
            Some(packed) => packed.before = packed.before.saturating_add(bytes),
            None => self.offset = self.offset.saturating_add(bytes),
        }
    }
}

/// How a member of an archive is packed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Packed {
    /// Whether by DEFLATE; stored as it is otherwise.
    pub deflated: bool,
    /// Packed bytes.
    pub bytes: u64,
    /// Unpacked bytes before the first frame.
    pub before: u64,
    /// Checksum of all unpacked bytes.
    pub crc: u32,
}

/// A column of a [`NumberTable`].
#[derive(Clone, Debug, PartialEq)]
pub struct NumberColumn {
    /// Its name.
    pub name: String,
    /// Which strand it lies in.
    pub strand: usize,
    /// Where it lies in a frame.
    pub cell: Cell,
    /// Its unit, where the format knows it.
    pub unit: Option<&'static str>,
    /// Whether it holds times (`datetime64`).
    pub is_time: bool,
}

/// Columns of numbers in a file, none of them read yet.
#[derive(Clone, Debug, Default)]
pub struct NumberTable {
    /// The file.
    pub file: PathBuf,
    /// Where their frames lie.
    pub strands: Vec<Strand>,
    /// The columns.
    pub columns: Vec<NumberColumn>,
    /// Rows.
    pub rows: u64,
    /// Whether its columns have names.
    pub named: bool,
    /// Samples per second, where the format states it, and where that stands.
    pub rate_hz: Option<f32>,
    /// Where the rate stands, for people.
    pub clock: String,
    /// What else is to be known.
    pub notes: Vec<String>,
    /// What is missing at its end, where it was cut off.
    pub cut: Option<String>,
}

impl NumberTable {
    /// Nothing yet, of `file`.
    #[must_use]
    pub fn new(file: &Path) -> Self {
        Self { file: file.to_owned(), named: true, ..Self::default() }
    }

    /// Takes over the columns of `other`, of the same file and with as many rows.
    pub(crate) fn append(&mut self, other: Self) {
        let before = self.strands.len();
        self.rows = other.rows;
        self.strands.extend(other.strands);
        self.notes.extend(other.notes);
        self.columns.extend(other.columns.into_iter().map(|mut column| {
            column.strand += before;
            column
        }));
    }

    /// Bytes of all frames.
    pub(crate) fn bytes(&self) -> Option<u64> {
        let mut sizes = self.strands.iter().map(|strand| strand.frame as u64);
        sizes.try_fold(0_u64, |all, size| all.checked_add(size.checked_mul(self.rows)?))
    }

    /// Starts to read the columns that are picked, in that order; none is NaN in every row.
    ///
    /// # Errors
    /// Where the file cannot be read.
    pub(crate) fn rows(&self, picks: &[Option<usize>]) -> io::Result<NumberRows> {
        let picks: Vec<_> = picks.iter().map(|pick| self.columns.get((*pick)?)).collect();
        let mut used: Vec<usize> = picks.iter().flatten().map(|column| column.strand).collect();
        used.sort_unstable();
        used.dedup();
        let place = |strand: usize| used.iter().position(|used| *used == strand);
        let picks =
            picks.iter().map(|column| column.and_then(|c| Some((place(c.strand)?, c.cell))));
        let picks = picks.collect();
        let strands = used.iter().filter_map(|strand| self.strands.get(*strand));
        let strands = strands.map(|strand| Frames::open(&self.file, strand));
        Ok(NumberRows { strands: strands.collect::<io::Result<_>>()?, picks, left: self.rows })
    }

    /// The first numbers of a column, as many as show what times are.
    pub(crate) fn first(&self, column: usize) -> io::Result<Vec<f64>> {
        let mut rows = self.rows(&[Some(column)])?;
        let (mut row, mut first) = (Vec::new(), Vec::new());
        while first.len() < ROWS && rows.next_row(&mut row)? {
            first.extend(row.first());
        }
        Ok(first)
    }
}

/// The rows of a table one after the other: the memory does not depend on their number.
#[derive(Debug)]
pub(crate) struct NumberRows {
    strands: Vec<Frames>,
    picks: Vec<Option<(usize, Cell)>>,
    left: u64,
}

impl NumberRows {
    /// Rows that are left.
    pub(crate) const fn left(&self) -> u64 {
        self.left
    }

    /// Reads on to the end, where checksums stand.
    ///
    /// # Errors
    /// As [`NumberRows::next_row`].
    pub(crate) fn drain(&mut self) -> io::Result<()> {
        let mut row = Vec::new();
        while self.next_row(&mut row)? {}
        Ok(())
    }

    /// Puts the next row into `row`; `false` at the end.
    ///
    /// # Errors
    /// Where the file cannot be read, ends before, or is damaged.
    pub(crate) fn next_row(&mut self, row: &mut Vec<f64>) -> io::Result<bool> {
        row.clear();
        if self.left == 0 {
            self.strands.iter_mut().try_for_each(Frames::end)?;
            return Ok(false);
        }
        self.left -= 1;
        for strand in &mut self.strands {
            strand.advance(self.left)?;
        }
        row.extend(self.picks.iter().map(|place| {
            place.map_or(f64::NAN, |(strand, cell)| {
                cell.number(self.strands.get(strand).map_or(&[] as &[u8], Frames::frame))
            })
        }));
        Ok(true)
    }
}

/// The frames of a strand.
struct Frames {
    input: Box<dyn Read + Send>,
    frame: usize,
    block: Vec<u8>,
    /// Place of the frame in the block, and how much of the block is filled.
    at: usize,
    filled: usize,
}

impl core::fmt::Debug for Frames {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Frames").field("frame", &self.frame).finish_non_exhaustive()
    }
}

impl Frames {
    fn open(file: &Path, strand: &Strand) -> io::Result<Self> {
        let mut input = files::open(file)?;
        input.seek(SeekFrom::Start(strand.offset))?;
        let input: Box<dyn Read + Send> = match strand.packed {
            None => Box::new(input),
            Some(packed) => {
                let mut input = unpacked(input, packed);
                let skipped = io::copy(&mut input.by_ref().take(packed.before), &mut io::sink())?;
                if skipped < packed.before {
                    return Err(io::ErrorKind::UnexpectedEof.into());
                }
                input
            }
        };
        let frame = strand.frame.max(1);
        let block = vec![0; PIECE.next_multiple_of(frame).max(frame)];
        Ok(Self { input, frame, block, at: frame, filled: frame })
    }

    fn frame(&self) -> &[u8] {
        self.block.get(self.at..self.at + self.frame).unwrap_or_default()
    }

    /// Goes to the next frame, behind which there are `more`.
    fn advance(&mut self, more: u64) -> io::Result<()> {
        self.at += self.frame;
        if self.at < self.filled {
            return Ok(());
        }
        let wanted = usize::try_from(more.saturating_add(1)).unwrap_or(usize::MAX);
        let wanted = wanted.saturating_mul(self.frame).min(self.block.len());
        self.input.read_exact(&mut self.block[..wanted])?;
        (self.at, self.filled) = (0, wanted);
        Ok(())
    }

    /// Reads on to the end of what is packed, where its checksum stands.
    fn end(&mut self) -> io::Result<()> {
        self.input.read(&mut [0]).map(drop)
    }
}

/// The bytes of a member of an archive; the last read fails where their checksum is another one.
fn unpacked(input: File, packed: Packed) -> Box<dyn Read + Send> {
    let input = io::BufReader::with_capacity(PIECE, input).take(packed.bytes);
    let input: Box<dyn Read + Send> =
        if packed.deflated { Box::new(DeflateDecoder::new(input)) } else { Box::new(input) };
    Box::new(Checked { input, crc: crc32fast::Hasher::new(), wanted: packed.crc })
}

struct Checked {
    input: Box<dyn Read + Send>,
    crc: crc32fast::Hasher,
    wanted: u32,
}

impl Read for Checked {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let read = self.input.read(buffer)?;
        self.crc.update(buffer.get(..read).unwrap_or_default());
        if read == 0 && !buffer.is_empty() && self.crc.clone().finalize() != self.wanted {
            return Err(io::Error::new(
                io::ErrorKind::InvalidData,
                "it is damaged: the checksum of its bytes is another one",
            ));
        }
        Ok(read)
    }
}

#[cfg(test)]
mod tests {
    use super::{Cell, Coding};

    #[test]
    fn numbers_of_every_coding() {
        let number = |coding, bytes: &[u8]| {
            let swapped: Vec<u8> = bytes.iter().rev().copied().collect();
            let little = Cell::new(0, bytes.len(), coding, false).number(bytes);
            let big =
                Cell::new(1, bytes.len(), coding, true).number(&[&[9], &swapped[..]].concat());
            assert!(little.to_bits() == big.to_bits(), "{coding:?} {bytes:?}");
            little
        };
        for (coding, bytes, value) in [
            (Coding::Float, &1.5_f64.to_le_bytes()[..], 1.5),
            (Coding::Float, &(-0.25_f32).to_le_bytes(), -0.25),
            (Coding::Float, &[0x00, 0x3c], 1.0),
            (Coding::Float, &[0x01, 0x80], -(2.0_f64.powi(-24))),
            (Coding::Float, &[0xff, 0x7b], 65504.0),
            (Coding::Float, &[0x00, 0xfc], f64::NEG_INFINITY),
            (Coding::Signed, &[0xfe, 0xff, 0xff], -2.0),
            (Coding::Signed, &i64::MIN.to_le_bytes(), -(2.0_f64.powi(63))),
            (Coding::Unsigned, &u64::MAX.to_le_bytes(), 2.0_f64.powi(64)),
            (Coding::Unsigned, &[200], 200.0),
            (Coding::MuLaw, &[0x00], -32124.0 / 32768.0),
            (Coding::MuLaw, &[0xff], 0.0),
            (Coding::MuLaw, &[0x8f], 16764.0 / 32768.0),
            (Coding::ALaw, &[0xd5], 8.0 / 32768.0),
            (Coding::ALaw, &[0x2a], -32256.0 / 32768.0),
            (Coding::ALaw, &[0x95], 2112.0 / 32768.0),
        ] {
            assert_eq!(number(coding, bytes), value, "{coding:?} {bytes:?}");
        }
        assert!(number(Coding::Float, &[0x01, 0x7c]).is_nan());
    }
}
