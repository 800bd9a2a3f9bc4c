//! The bytes of an `.npy` in, its one column of numbers or texts out.
//!
//! The header is checked before `ndarray-npy` parses it: that allocates whatever the header asks for, and follows brackets
//! as deep as they go.

use ndarray::{Array1, ArrayD};
use ndarray_npy::npy::header::Header;
use ndarray_npy::{ReadNpyExt as _, ReadableElement};

/// Most bytes of a header: what NumPy itself accepts.
const MOST_HEADER: usize = 10_000;
/// Brackets of a plain header: one of the dictionary, one of the shape.
const BRACKETS: usize = 2;
/// From here on neighbours among the integers are the same double.
const MOST_INTEGER: u64 = 1 << 53;

/// The array in the `.npy` whose bytes these are: its numbers, a row after the other, and how many a row has. One dimension is one column.
///
/// # Errors
/// What is wrong, as the end of a sentence about the array.
pub fn parse_npy(bytes: &[u8]) -> Result<(Vec<f64>, usize), String> {
    let npy = Npy::of_any_shape(bytes)?;
    let width = match *npy.shape() {
        [_] => 1,
        [_, width] => width,
        _ => return Err(format!("has {} dimensions; one or two are read", npy.shape().len())),
    };
    Ok((npy.numbers()?.to_vec(), width))
}

/// A column as it is stored.
#[derive(Debug)]
pub(crate) struct Npy<'a> {
    bytes: &'a [u8],
    /// Type of an element as NumPy writes it, for example `<f8`.
    kind: String,
    data: &'a [u8],
    shape: Vec<usize>,
}

impl<'a> Npy<'a> {
    /// Reads the header of a column.
    ///
    /// # Errors
    /// What is wrong, as the end of a sentence about the array.
    pub(crate) fn open(bytes: &'a [u8]) -> Result<Self, String> {
        let npy = Self::of_any_shape(bytes)?;
        if npy.shape.len() != 1 {
            let sizes: Vec<String> = npy.shape.iter().map(ToString::to_string).collect();
            let (count, sizes) = (npy.shape.len(), sizes.join(" x "));
            return Err(format!("has {count} dimensions ({sizes}); a column has one"));
        }
        Ok(npy)
    }

    /// Reads the header of an array.
    ///
    /// # Errors
    /// As [`Npy::open`].
    pub(crate) fn of_any_shape(bytes: &'a [u8]) -> Result<Self, String> {
        check_header(bytes)?;
        let mut data = bytes;
        let header = Header::from_reader(&mut data).map_err(|error| error.to_string())?;
        let kind = header.type_descriptor.as_string().cloned().unwrap_or_default();
        Ok(Self { bytes, kind, data, shape: header.shape })
    }

    /// Values of all dimensions, as the header states.
    pub(crate) fn rows(&self) -> usize {
        self.shape.iter().fold(1, |all, size| all.saturating_mul(*size))
    }

    /// Sizes of the dimensions.
    pub(crate) fn shape(&self) -> &[usize] {
        &self.shape
    }

    /// The values as doubles, the last dimension going fastest.
    ///
    /// # Errors
    /// As [`Npy::open`].
    pub(crate) fn numbers(&self) -> Result<Array1<f64>, String> {
        match self.kind.trim_start_matches(['<', '>', '|', '=']) {
            "f8" => self.read(8, Ok::<f64, String>),
            "f4" => self.read(4, |value: f32| Ok(value.into())),
            "i8" => self.read(8, |value: i64| integer(value.unsigned_abs(), value < 0)),
            "u8" => self.read(8, |value: u64| integer(value, false)),
            "i4" => self.read(4, |value: i32| Ok(value.into())),
            "u4" => self.read(4, |value: u32| Ok(value.into())),
            "i2" => self.read(2, |value: i16| Ok(value.into())),
            "u2" => self.read(2, |value: u16| Ok(value.into())),
            "i1" => self.read(1, |value: i8| Ok(value.into())),
            "u1" => self.read(1, |value: u8| Ok(value.into())),
            "b1" => self.read(1, |value: bool| Ok(f64::from(u8::from(value)))),
            _ => Err(format!(
                "holds values of type {:?}; float64, float32, integers and bool are read",
                self.kind
            )),
        }
    }

    /// The column as texts; numbers as their digits, nothing for NaN.
    ///
    /// # Errors
    /// As [`Npy::open`].
    pub(crate) fn texts(&self) -> Result<Vec<String>, String> {
        let Some((order, length)) = self.kind.split_once('U') else {
            let text = |value: &f64| if value.is_nan() { String::new() } else { value.to_string() };
            return Ok(self.numbers()?.iter().map(text).collect());
        };
        let length: usize = length.parse().unwrap_or(0);
        let size = length.checked_mul(4).filter(|size| *size > 0);
        let size = size.ok_or_else(|| format!("holds texts of type {:?}", self.kind))?;
        self.check_length(size)?;
        let letter = |bytes: &[u8; 4]| {
            if order == ">" { u32::from_be_bytes(*bytes) } else { u32::from_le_bytes(*bytes) }
        };
        let text = |cell: &[u8]| {
            let letters = cell.as_chunks::<4>().0.iter().map(letter);
            let text: Option<String> = letters.map(char::from_u32).collect();
            text.map(|text| text.trim_end_matches('\0').to_owned())
                .ok_or_else(|| "holds texts that are no Unicode".to_owned())
        };
        self.data.chunks_exact(size).map(text).collect()
    }

    fn read<T: ReadableElement>(
        &self,
        size: usize,
        number: impl Fn(T) -> Result<f64, String>,
    ) -> Result<Array1<f64>, String> {
        self.check_length(size)?;
        let values = ArrayD::<T>::read_npy(self.bytes).map_err(|error| error.to_string())?;
        values.into_iter().map(number).collect()
    }

    /// Whether there are as many bytes as the shape states, before anything is made that large.
    fn check_length(&self, size: usize) -> Result<(), String> {
        let (rows, found) = (self.rows(), self.data.len());
        if rows.checked_mul(size) == Some(found) {
            return Ok(());
        }
        Err(format!("has {found} bytes where {rows} values of {size} bytes were announced"))
    }
}

fn check_header(bytes: &[u8]) -> Result<(), String> {
    let truncated = || "ends within its header".to_owned();
    if !bytes.starts_with(b"\x93NUMPY") {
        return Err("is no .npy".to_owned());
    }
    let (start, length) = match bytes {
        [_, _, _, _, _, _, 1, _, low, high, ..] => (10, u32::from_le_bytes([*low, *high, 0, 0])),
        [_, _, _, _, _, _, 2 | 3, _, a, b, c, d, ..] => (12, u32::from_le_bytes([*a, *b, *c, *d])),
        [_, _, _, _, _, _, version, _, _, _, _, _, ..] => {
            return Err(format!("has version {version} of the format; 1 to 3 are read"));
        }
        _ => return Err(truncated()),
    };
    let length = usize::try_from(length).unwrap_or(usize::MAX);
    if length > MOST_HEADER {
        return Err(format!("has a header of {length} bytes; {MOST_HEADER} are read"));
    }
    let header = bytes.get(start..start + length).ok_or_else(truncated)?;
    let brackets = header.iter().filter(|byte| b"([{".contains(byte)).count();
    if brackets > BRACKETS {
        return Err("is a structured array; a column holds plain numbers".to_owned());
    }
    Ok(())
}

fn integer(size: u64, negative: bool) -> Result<f64, String> {
    if size > MOST_INTEGER {
        return Err("holds integers beyond 2^53, which a double cannot keep".to_owned());
    }
    let value = size as f64;
    Ok(if negative { -value } else { value })
}
