//! Reader and writer of the named columns of an `.npz` of NumPy.
//!
//! Each array of one dimension is a column under its name, as `numpy.savez(FILE, t_s=..., stylus=...)` or `savez_compressed`
//! writes them. Of an array that nobody asks for only the name is read.

use std::fs::File;
use std::io::{BufReader, Cursor, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use ndarray::{Array1, ArrayRef2};
use zip::result::{ZipError, ZipResult};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipArchive, ZipWriter};

use crate::channels::COLUMN_NAMES;
use crate::csv_read::read_bytes;
use crate::error::CsvError;
use crate::files;
use crate::npy::{self, Npy};
use crate::numbers::{NumberTable, Packed, Strand};

/// Most bytes that the columns read from one file may take, unpacked and as doubles, all together: a small file can hold
/// terabytes of zeros.
pub const MOST_UNPACKED: u64 = 1 << 30;

/// Why an `.npz` cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum NpzError {
    /// The file is missing or cannot be read.
    #[error(transparent)]
    File(#[from] Box<CsvError>),
    /// The bytes are no archive.
    #[error("{}: is no .npz: {message}", file.display())]
    Archive {
        /// The file.
        file: PathBuf,
        /// What the reader states.
        message: String,
    },
    /// No array has the name asked for.
    #[error("{}: no array {array:?}; the file has: {}", file.display(), found.join(", "))]
    Missing {
        /// The file.
        file: PathBuf,
        /// The name asked for.
        array: String,
        /// The names there are.
        found: Vec<String>,
    },
    /// An array that is no column.
    #[error("{}: array {array:?} {fault}", file.display())]
    Array {
        /// The file.
        file: PathBuf,
        /// Its name.
        array: String,
        /// What is wrong, as the end of the sentence.
        fault: String,
    },
    /// Columns of different lengths.
    #[error(
        "{}: array {array:?} has {rows} values and {first:?} has {expected}; all columns need as many",
        file.display()
    )]
    Length {
        /// The file.
        file: PathBuf,
        /// The array.
        array: String,
        /// Its values.
        rows: u64,
        /// The column read before it.
        first: String,
        /// The values of that.
        expected: u64,
    },
}

/// An array that unpacks to more than this (bytes), and to so many times its packed size, holds nothing but repetitions.
const LARGE: u64 = 64 << 20;
const MOST_RATIO: u64 = 200;

/// Bytes of a double, and of a short text.
const NUMBER: usize = 8;
const TEXT: usize = 32;

/// An `.npz`, whose columns are read one by one.
#[derive(Debug)]
pub struct Npz {
    file: PathBuf,
    archive: ZipArchive<Cursor<Vec<u8>>>,
    names: Vec<String>,
    /// Bytes that columns may still take.
    left: u64,
    /// Name and length of the first column that was read.
    first: Option<(String, usize)>,
}

/// Whether the name of `file` states that it is an `.npz`.
#[must_use]
pub fn is_npz(file: &Path) -> bool {
    file.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("npz"))
}

impl Npz {
    /// Opens `file`.
    ///
    /// # Errors
    /// [`NpzError::File`] and [`NpzError::Archive`].
    pub fn open(file: &Path) -> Result<Self, NpzError> {
        Self::parse(file, read_bytes(file).map_err(Box::new)?)
    }

    /// The archive whose bytes are `bytes`; `file` stands in errors.
    ///
    /// # Errors
    /// [`NpzError::Archive`].
    pub fn parse(file: &Path, bytes: Vec<u8>) -> Result<Self, NpzError> {
        let (archive, names) = archive(file, Cursor::new(bytes))?;
        Ok(Self { file: file.to_owned(), archive, names, left: MOST_UNPACKED, first: None })
    }

    /// The names of all arrays, in the order of the file.
    #[must_use]
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Values of the columns read so far, 0 before the first.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.first.as_ref().map_or(0, |(_, rows)| *rows)
    }

    /// The column `name`: float64, float32, integers up to 2^53 in size and bool become doubles.
    ///
    /// # Errors
    /// [`NpzError::Missing`], [`NpzError::Array`]; [`NpzError::Length`] where an earlier column had another length.
    pub fn numbers(&mut self, name: &str) -> Result<Array1<f64>, NpzError> {
        let numbers = self.column(name, NUMBER, Npy::numbers)?;
        self.check_length(name, numbers.len())?;
        Ok(numbers)
    }

    /// The column `name` as labels: texts (`<U`), or numbers as their digits; empty for NaN.
    ///
    /// # Errors
    /// As [`Npz::numbers`].
    pub fn texts(&mut self, name: &str) -> Result<Vec<String>, NpzError> {
        let texts = self.column(name, TEXT, Npy::texts)?;
        self.check_length(name, texts.len())?;
        Ok(texts)
    }

    fn column<T>(
        &mut self,
        name: &str,
        size: usize,
        read: impl Fn(&Npy, &[u8]) -> Result<T, String>,
    ) -> Result<T, NpzError> {
        let Some(at) = self.names.iter().position(|other| other == name) else {
            let (file, found) = (self.file.clone(), self.names.clone());
            return Err(NpzError::Missing { file, array: name.to_owned(), found });
        };
        let read = self.unpack(at).and_then(|bytes| {
            let mut data = &bytes[..];
            let npy = Npy::read(&mut data)?;
            self.take(npy.values().saturating_mul(size).max(bytes.len()))?;
            read(&npy, data)
        });
        let (file, array) = (self.file.clone(), name.to_owned());
        read.map_err(|fault| NpzError::Array { file, array, fault })
    }

    /// The bytes of an array, as far as there is room for them.
    fn unpack(&mut self, at: usize) -> Result<Vec<u8>, String> {
        let left = self.left;
        let member = self.archive.by_index(at).map_err(|error| format!("is damaged: {error}"))?;
        let (size, packed) = (member.size(), member.compressed_size());
        if size > left {
            return Err(too_large());
        }
        if size > LARGE && size / MOST_RATIO > packed {
            return Err("unpacks to more than 200 times its size: save it with numpy.savez if it is meant so".to_owned());
        }
        let mut bytes = Vec::new();
        // What is longer than it says is refused, too.
        let read = member.take(size + 1).read_to_end(&mut bytes);
        read.map_err(|error| format!("is damaged: {error}"))?;
        if u64::try_from(bytes.len()).is_ok_and(|read| read == size) {
            return Ok(bytes);
        }
        Err("is damaged: its size is another".to_owned())
    }

    fn take(&mut self, size: usize) -> Result<(), String> {
        let size = u64::try_from(size).unwrap_or(u64::MAX);
        self.left = self.left.checked_sub(size).ok_or_else(too_large)?;
        Ok(())
    }

    fn check_length(&mut self, name: &str, rows: usize) -> Result<(), NpzError> {
        let (first, expected) = self.first.get_or_insert_with(|| (name.to_owned(), rows));
        if rows == *expected {
            return Ok(());
        }
        let (file, first, array) = (self.file.clone(), first.clone(), name.to_owned());
        let (rows, expected) = (rows as u64, *expected as u64);
        Err(NpzError::Length { file, array, rows, first, expected })
    }
}

/// The archive in `input`, and the names of its arrays.
fn archive<R: Read + Seek>(
    file: &Path,
    mut input: R,
) -> Result<(ZipArchive<R>, Vec<String>), NpzError> {
    let no_archive = |message: String| NpzError::Archive { file: file.to_owned(), message };
    let unreadable = |source| Box::new(CsvError::Unreadable { file: file.to_owned(), source });
    let mut magic = [0; 6];
    if input.read_exact(&mut magic).is_ok() && magic == *b"\x93NUMPY" {
        let message = "it is a single .npy, whose columns have no names; save each under its name with numpy.savez";
        return Err(no_archive(message.to_owned()));
    }
    // The directory is written last, and its end is looked for only where it can be: not in all of a file of any size.
    if !ends_with_a_directory(&mut input).map_err(unreadable)? {
        let cut = magic.starts_with(b"PK");
        let message = if cut { "it was cut off: save it again" } else { "it is no archive" };
        return Err(no_archive(message.to_owned()));
    }
    let archive = ZipArchive::new(input).map_err(|error| no_archive(error.to_string()))?;
    let name = |at: usize| {
        let name = archive.name_for_index(at).and_then(Result::ok).unwrap_or_default();
        name.strip_suffix(".npy").unwrap_or(&name).to_owned()
    };
    let names = (0..archive.len()).map(name).collect();
    Ok((archive, names))
}

/// Whether the end of the directory of an archive, and the longest comment behind it, may stand at the end of `input`.
fn ends_with_a_directory(input: &mut (impl Read + Seek)) -> std::io::Result<bool> {
    const LONGEST_END: u64 = 22 + 65_535;
    let size = input.seek(SeekFrom::End(0))?;
    input.seek(SeekFrom::Start(size.saturating_sub(LONGEST_END)))?;
    let mut end = Vec::new();
    input.by_ref().take(LONGEST_END).read_to_end(&mut end)?;
    input.rewind()?;
    Ok(end.windows(4).any(|bytes| bytes == b"PK\x05\x06"))
}

/// Where the columns of an `.npz` of any size lie: the arrays that are as long as those with the name of a recording's column, or
/// as the longest of one dimension. Nothing but headers is read.
///
/// # Errors
/// Where the file cannot be read, or an array with the name of a column has another length.
pub fn npz_table(file: &Path) -> Result<NumberTable, NpzError> {
    let input = files::open(file)
        .map_err(|source| Box::new(CsvError::Unreadable { file: file.to_owned(), source }))?;
    let (mut archive, names) = archive(file, BufReader::new(input))?;
    let mut table = NumberTable::new(file);
    let mut arrays = Vec::new();
    for (at, name) in names.into_iter().enumerate() {
        match member(&mut archive, file, at, &name) {
            Ok(array) => arrays.push((name, array)),
            Err(fault) if is_column(&name) => {
                let file = file.to_owned();
                return Err(NpzError::Array { file, array: name, fault });
            }
            Err(fault) => table.notes.push(format!("not used: {name}, which {fault}")),
        }
    }
    let own = arrays.iter().find(|(name, _)| is_column(name)).map(|(_, array)| array.rows);
    let longest = |plain: bool| {
        let wanted = arrays.iter().filter(|(_, array)| !plain || array.columns.len() == 1);
        wanted.map(|(_, array)| array.rows).max()
    };
    let rows = own.or_else(|| longest(true)).or_else(|| longest(false)).unwrap_or(0);
    for (name, array) in arrays {
        if array.rows == rows {
            table.append(array);
        } else if is_column(&name) {
            let first = table.columns.first().map(|column| column.name.clone());
            return Err(NpzError::Length {
                file: file.to_owned(),
                array: name,
                rows: array.rows,
                first: first.unwrap_or_default(),
                expected: rows,
            });
        } else {
            table.notes.push(format!("not used: {name}, of {} values", array.rows));
        }
    }
    table.rows = rows;
    Ok(table)
}

fn is_column(name: &str) -> bool {
    COLUMN_NAMES.contains(&name)
}

/// Where the columns of one array lie.
fn member(
    archive: &mut ZipArchive<BufReader<File>>,
    file: &Path,
    at: usize,
    name: &str,
) -> Result<NumberTable, String> {
    let damaged = |error: ZipError| format!("is damaged: {error}");
    let mut member = archive.by_index(at).map_err(damaged)?;
    let npy = Npy::read(&mut member)?;
    let deflated = match member.compression() {
        CompressionMethod::Stored => false,
        CompressionMethod::Deflated => true,
        other => return Err(format!("is packed by {other}; DEFLATE is read")),
    };
    let packed = Packed {
        deflated,
        bytes: member.compressed_size(),
        before: npy.length,
        crc: member.crc32(),
    };
    let offset = member.data_start().ok_or_else(|| "is damaged".to_owned())?;
    let place = Strand { offset, frame: 1, packed: Some(packed) };
    let table = npy.table(file, name, place)?;
    let found = member.size().saturating_sub(npy.length);
    if table.bytes() == Some(found) {
        return Ok(table);
    }
    let frame = table.strands.iter().map(|strand| strand.frame).sum::<usize>();
    Err(format!("has {found} bytes where {} values of {frame} bytes were announced", table.rows))
}

fn too_large() -> String {
    format!("is too large: the columns of a file may take {MOST_UNPACKED} bytes unpacked")
}

/// Writes the columns of `values` (rows x names) to `out` as an `.npz` of 1-dimensional arrays, not compressed.
///
/// # Errors
/// Where it cannot be written.
pub fn write_columns(
    out: impl Write + Seek,
    names: &[&str],
    values: &ArrayRef2<f64>,
) -> ZipResult<()> {
    let mut npz = ZipWriter::new(out);
    for (name, column) in names.iter().zip(values.columns()) {
        write_array(&mut npz, name, column.iter().map(|value| value.to_le_bytes()))?;
    }
    Ok(npz.finish()?.flush()?)
}

/// Writes an array of the bytes of numbers, not compressed.
pub(crate) fn write_array<const N: usize>(
    npz: &mut ZipWriter<impl Write + Seek>,
    name: &str,
    numbers: impl ExactSizeIterator<Item = [u8; N]>,
) -> ZipResult<()> {
    let stored = SimpleFileOptions::default().compression_method(CompressionMethod::Stored);
    npz.start_file(format!("{name}.npy"), stored)?;
    Ok(npy::write(npz, numbers)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two arrays of as many zeros in single bytes, packed, with room for so many bytes.
    fn zeros(count: usize, left: u64) -> Npz {
        let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
        let options = SimpleFileOptions::default().compression_method(CompressionMethod::Deflated);
        for name in ["a", "b"] {
            let header =
                format!("{{'descr': '|u1', 'fortran_order': False, 'shape': ({count},), }}");
            let length = u16::try_from(header.len()).unwrap().to_le_bytes();
            let zeros = vec![0; count];
            zip.start_file(name, options).unwrap();
            let parts = [b"\x93NUMPY\x01\x00", &length[..], header.as_bytes(), &zeros];
            zip.write_all(&parts.concat()).unwrap();
        }
        let bytes = zip.finish().unwrap().into_inner();
        assert!(bytes.len() < count / 100);
        Npz { left, ..Npz::parse(Path::new("z.npz"), bytes).unwrap() }
    }

    #[test]
    fn a_bomb_is_not_unpacked() {
        let count = 1 << 20;
        let reported = |result: Result<Array1<f64>, NpzError>| {
            result.err().is_some_and(|error| error.to_string().contains("too large"))
        };
        // Unpacked, it takes a byte a value, as doubles eight.
        assert!(reported(zeros(count, 1000).numbers("a")));
        assert!(reported(zeros(count, 2 << 20).numbers("a")));
        let mut both = zeros(count, 12 << 20);
        assert!(!reported(both.numbers("a")) && reported(both.numbers("b")));
        assert!(zeros(count, 12 << 20).texts("a").is_err());
    }
}
