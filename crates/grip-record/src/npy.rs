//! Format `.npy`: the header, which states where the numbers lie, and the bytes of one column as numbers or texts.
//!
//! A header is a literal of Python, of so many bytes at most; it is read as the JSON that says the same.

use core::slice;
use std::io::{BufWriter, Read, Write};
use std::path::Path;

use ndarray::Array1;
use serde_json::Value;

use crate::files;
use crate::numbers::{Cell, Coding, NumberColumn, NumberTable, Strand};

/// Most bytes of a header: what NumPy itself accepts.
const MOST_HEADER: usize = 10_000;
/// From here on neighbours among the integers are the same double.
const MOST_INTEGER: u128 = 1 << 53;
/// Most columns of an array.
const MOST_COLUMNS: usize = 4096;
/// More rows than columns is what a recording has; an array of at most so many rows lies on its side.
const MOST_SIDEWAYS: usize = 300;

/// Where the columns of an array lie: those of one or two dimensions as `column_0`, .., fields under their names.
///
/// # Errors
/// What is wrong, as the end of a sentence about the array.
pub fn npy_table(file: &Path) -> Result<NumberTable, String> {
    let unreadable = |error: std::io::Error| format!("cannot be read ({error})");
    let mut input = files::open(file).map_err(unreadable)?;
    let length = input.metadata().map_err(unreadable)?.len();
    let npy = Npy::read(&mut input)?;
    let place = Strand { offset: npy.length, frame: 1, packed: None };
    let mut table = npy.table(file, "", place)?;
    let found = length.saturating_sub(npy.length);
    let announced = table.bytes().unwrap_or(u64::MAX);
    if found > announced {
        table.notes.push(format!("{} bytes behind the array, not read", found - announced));
    } else if found < announced {
        // Of columns one behind the other, only the last one is short.
        let frame = table.strands.last().map_or(1, |strand| strand.frame as u64);
        let before = announced - table.rows.saturating_mul(frame);
        let rows = found.saturating_sub(before) / frame;
        if rows == 0 {
            return Err(format!(
                "has {found} bytes where {announced} were announced: it was cut off"
            ));
        }
        let rows_announced = core::mem::replace(&mut table.rows, rows);
        table.cut = Some(format!("cut off: {rows} of {rows_announced} rows are there"));
    }
    Ok(table)
}

/// What a header states, by the names it has there.
#[derive(serde::Deserialize)]
struct Stated {
    descr: Value,
    fortran_order: bool,
    shape: Vec<usize>,
}

/// The same, understood.
#[derive(Debug)]
pub(crate) struct Npy {
    kind: Kind,
    pub(crate) shape: Vec<usize>,
    fortran: bool,
    /// Bytes of the header, with those before it.
    pub(crate) length: u64,
}

/// What an element is.
#[derive(Debug)]
enum Kind {
    /// One value, as NumPy writes it, for example `<f8`.
    Plain(String),
    /// A structure.
    Fields(Fields),
}

/// The fields of a structure, those of structures in it among them.
#[derive(Debug, Default)]
struct Fields {
    fields: Vec<Field>,
    /// Bytes of all.
    size: usize,
    /// How many there are, with those that are padding.
    count: usize,
}

#[derive(Debug)]
struct Field {
    name: String,
    at: usize,
    kind: String,
}

impl Npy {
    /// Reads a header, and nothing behind it.
    ///
    /// # Errors
    /// What is wrong, as the end of a sentence about the array.
    pub(crate) fn read(input: &mut impl Read) -> Result<Self, String> {
        let bytes = header(input)?;
        let before = if bytes[6] == 1 { 10 } else { 12 };
        // Version 3 is UTF-8, what came before Latin-1.
        let literal = if bytes[6] < 3 {
            json(&bytes[before..].iter().copied().map(char::from).collect::<String>())
        } else {
            json(
                core::str::from_utf8(&bytes[before..])
                    .map_err(|_| "has a header that is no text")?,
            )
        };
        let stated: Stated = serde_json::from_str(&literal)
            .map_err(|error| format!("has a header that is not understood: {error}"))?;
        let kind = if let Value::String(kind) = stated.descr {
            Kind::Plain(kind)
        } else {
            let mut fields = Fields::default();
            fields.take(&stated.descr, "")?;
            Kind::Fields(fields)
        };
        let length = bytes.len() as u64;
        Ok(Self { kind, shape: stated.shape, fortran: stated.fortran_order, length })
    }

    /// The columns of this array in `file`, whose elements begin at `place`; under `name`, if it has one.
    ///
    /// # Errors
    /// Where it holds no numbers, or has neither one nor two dimensions.
    pub(crate) fn table(
        &self,
        file: &Path,
        name: &str,
        place: Strand,
    ) -> Result<NumberTable, String> {
        let mut table = NumberTable::new(file);
        table.named = !name.is_empty() || matches!(self.kind, Kind::Fields(_));
        match &self.kind {
            Kind::Plain(kind) => {
                let (cell, unit) = cell(kind)?;
                self.plain(&mut table, place, &|k: Option<usize>| NumberColumn {
                    name: match (k, name) {
                        (None, "") => "column_0".to_owned(),
                        (None, name) => name.to_owned(),
                        (Some(k), "") => format!("column_{k}"),
                        (Some(k), name) => format!("{name}_{k}"),
                    },
                    strand: 0,
                    cell,
                    unit,
                    is_time: unit.is_some(),
                })?;
            }
            Kind::Fields(fields) => {
                let [rows] = *self.shape else {
                    return Err(format!("is of structures, and has {}; one is read", self.sizes()));
                };
                table.rows = rows as u64;
                table.strands.push(Strand { frame: fields.size, ..place });
                for field in &fields.fields {
                    match cell(&field.kind) {
                        Ok((cell, unit)) => table.columns.push(NumberColumn {
                            name: field.name.clone(),
                            strand: 0,
                            cell: Cell { at: field.at, ..cell },
                            unit,
                            is_time: unit.is_some(),
                        }),
                        Err(what) => {
                            table.notes.push(format!("not used: {}, which {what}", field.name))
                        }
                    }
                }
            }
        }
        Ok(table)
    }

    /// The columns of an array of plain values: beside each other in the rows, or one behind the other.
    fn plain(
        &self,
        table: &mut NumberTable,
        place: Strand,
        column: &dyn Fn(Option<usize>) -> NumberColumn,
    ) -> Result<(), String> {
        let (first, second) = match *self.shape {
            [rows] => (rows, None),
            [first, second] => (first, Some(second)),
            _ => return Err(format!("has {}; one or two are read", self.sizes())),
        };
        let sideways = second.is_some_and(|second| first < second && first <= MOST_SIDEWAYS);
        let (rows, width) =
            if sideways { (second.unwrap_or(1), first) } else { (first, second.unwrap_or(1)) };
        if sideways {
            table.notes.push(format!(
                "an array of {width} x {rows}, taken as {rows} samples of {width} columns"
            ));
        }
        if width > MOST_COLUMNS {
            return Err(format!("has {width} columns; {MOST_COLUMNS} are read"));
        }
        table.rows = rows as u64;
        let beside = self.fortran == sideways;
        for k in 0..width {
            let mut column = column(second.map(|_| k));
            let size = column.cell.size;
            if beside {
                column.cell.at = k * size;
            } else {
                column.strand = k;
                let before = (k as u64).saturating_mul(table.rows).saturating_mul(size as u64);
                let mut strand = Strand { frame: size, ..place };
                strand.skip(before);
                table.strands.push(strand);
            }
            table.columns.push(column);
        }
        if beside {
            let size = table.columns.first().map_or(1, |column| column.cell.size);
            table.strands.push(Strand { frame: size * width.max(1), ..place });
        }
        Ok(())
    }

    /// Values of all dimensions, as the header states.
    pub(crate) fn values(&self) -> usize {
        self.shape.iter().fold(1, |all, size| all.saturating_mul(*size))
    }

    fn sizes(&self) -> String {
        if self.shape.is_empty() {
            return "no dimension, being a single value".to_owned();
        }
        let sizes: Vec<String> = self.shape.iter().map(ToString::to_string).collect();
        format!("{} dimensions ({})", sizes.len(), sizes.join(" x "))
    }

    fn one_dimension(&self) -> Result<(), String> {
        if self.shape.len() == 1 {
            return Ok(());
        }
        Err(format!("has {}; a column has one", self.sizes()))
    }

    /// The values of an array of one dimension as doubles; `data` is what follows the header.
    ///
    /// # Errors
    /// As [`Npy::read`].
    pub(crate) fn numbers(&self, data: &[u8]) -> Result<Array1<f64>, String> {
        self.one_dimension()?;
        let Kind::Plain(kind) = &self.kind else {
            return Err("is a structured array; a column holds plain numbers".to_owned());
        };
        let (cell, _) = cell(kind)?;
        self.check_length(data, cell.size)?;
        let whole = matches!(cell.coding, Coding::Signed | Coding::Unsigned);
        let number = |frame: &[u8]| {
            if whole && cell.integer(frame).unsigned_abs() > MOST_INTEGER {
                return Err("holds integers beyond 2^53, which a double cannot keep".to_owned());
            }
            Ok(cell.number(frame))
        };
        data.chunks_exact(cell.size).map(number).collect()
    }

    /// The column as texts; numbers as their digits, nothing for NaN.
    ///
    /// # Errors
    /// As [`Npy::read`].
    pub(crate) fn texts(&self, data: &[u8]) -> Result<Vec<String>, String> {
        self.one_dimension()?;
        let (kind, split) = match &self.kind {
            Kind::Plain(kind) => (kind.as_str(), kind.split_once('U')),
            Kind::Fields(_) => ("", None),
        };
        let Some((order, length)) = split else {
            let text = |value: &f64| if value.is_nan() { String::new() } else { value.to_string() };
            return Ok(self.numbers(data)?.iter().map(text).collect());
        };
        let length: usize = length.parse().unwrap_or(0);
        let size = length.checked_mul(4).filter(|size| *size > 0);
        let size = size.ok_or_else(|| format!("holds texts of type {kind:?}"))?;
        self.check_length(data, size)?;
        let letter = |bytes: &[u8; 4]| {
            if order == ">" { u32::from_be_bytes(*bytes) } else { u32::from_le_bytes(*bytes) }
        };
        let text = |cell: &[u8]| {
            let letters = cell.as_chunks::<4>().0.iter().map(letter);
            let text: Option<String> = letters.map(char::from_u32).collect();
            text.map(|text| text.trim_end_matches('\0').to_owned())
                .ok_or_else(|| "holds texts that are no Unicode".to_owned())
        };
        data.chunks_exact(size).map(text).collect()
    }

    /// Whether there are as many bytes as the shape states.
    fn check_length(&self, data: &[u8], size: usize) -> Result<(), String> {
        let (rows, found) = (self.values(), data.len());
        if rows.checked_mul(size) == Some(found) {
            return Ok(());
        }
        Err(format!("has {found} bytes where {rows} values of {size} bytes were announced"))
    }
}

impl Fields {
    /// Appends what `descr` states: pairs of a name and a type, or of a name, a type and a shape.
    fn take(&mut self, descr: &Value, within: &str) -> Result<(), String> {
        let odd =
            || "has a type that is not understood; save its columns with numpy.savez".to_owned();
        for field in descr.as_array().ok_or_else(odd)? {
            let [name, kind, shape @ ..] = field.as_array().ok_or_else(odd)?.as_slice() else {
                return Err(odd());
            };
            // A field may have a title beside its name.
            let name = name.as_str().or_else(|| name.get(1)?.as_str());
            let name = format!("{within}{}", name.ok_or_else(odd)?);
            let mut times = 1_usize;
            // A number is a tuple of one.
            let sizes = match shape.first() {
                Some(Value::Array(sizes)) => sizes,
                one => one.map_or(&[][..], slice::from_ref),
            };
            for size in sizes {
                let size = size.as_u64().and_then(|size| usize::try_from(size).ok());
                times = times.saturating_mul(size.ok_or_else(odd)?);
            }
            self.count = self.count.saturating_add(times);
            if self.count > MOST_COLUMNS {
                return Err(format!("has more than {MOST_COLUMNS} columns"));
            }
            for k in 0..times {
                let name = if shape.is_empty() { name.clone() } else { format!("{name}_{k}") };
                let Some(kind) = kind.as_str() else {
                    self.take(kind, &format!("{name}."))?;
                    continue;
                };
                let size = size(kind).ok_or_else(|| format!("{name} {}", no_number(kind)))?;
                // Void without a name is padding.
                if !(name.is_empty() && kind.contains('V')) {
                    self.fields.push(Field { name, at: self.size, kind: kind.to_owned() });
                }
                self.size = self.size.saturating_add(size);
            }
        }
        Ok(())
    }
}

/// Bytes of an element.
fn size(kind: &str) -> Option<usize> {
    let bare = kind.trim_start_matches(['<', '>', '|', '=']);
    let number: usize = bare.get(1..)?.split('[').next()?.parse().ok()?;
    let letters = if bare.starts_with('U') { 4 } else { 1 };
    number.checked_mul(letters).filter(|size| *size < 1 << 20)
}

/// The number that an element is, and its unit where it is a time.
fn cell(kind: &str) -> Result<(Cell, Option<&'static str>), String> {
    let bare = kind.trim_start_matches(['<', '>', '|', '=']);
    let coding = match bare {
        "f2" | "f4" | "f8" => Coding::Float,
        "i1" | "i2" | "i4" | "i8" => Coding::Signed,
        "b1" | "u1" | "u2" | "u4" | "u8" => Coding::Unsigned,
        _ if bare.starts_with("M8") || bare.starts_with("m8") => Coding::Signed,
        _ => return Err(no_number(kind)),
    };
    let time = bare.split_once('[').map(|(_, unit)| match unit {
        "ns]" => Ok("ns"),
        "us]" => Ok("us"),
        "ms]" => Ok("ms"),
        "s]" => Ok("s"),
        _ => Err(no_number(kind)),
    });
    let size = size(kind).ok_or_else(|| no_number(kind))?;
    Ok((Cell::new(0, size, coding, kind.starts_with('>')), time.transpose()?))
}

fn no_number(kind: &str) -> String {
    let what = match kind.trim_start_matches(['<', '>', '|', '=']).chars().next() {
        Some('c') => "complex numbers; save .real or .imag of it",
        Some('O') => "Python objects, which are not unpacked; save it with .astype(float)",
        Some('U' | 'S') => "texts",
        Some('M' | 'm') => "times of another unit than s, ms, us or ns",
        _ => "float64, float32, float16, integers and bool are read",
    };
    format!("holds values of type {kind:?}: {what}")
}

/// A literal of Python as JSON: its quotes and brackets, its truths, and no comma before an end.
fn json(literal: &str) -> String {
    let mut json = String::with_capacity(literal.len());
    let mut letters = literal.chars();
    while let Some(letter) = letters.next() {
        match letter {
            '\'' | '"' => {
                json.push('"');
                while let Some(within) = letters.next().filter(|within| *within != letter) {
                    match within {
                        '"' => json.push_str("\\\""),
                        '\\' => match letters.next() {
                            Some('\'') => json.push('\''),
                            Some('x') => json.push_str("\\u00"),
                            escaped => json.extend(['\\'].into_iter().chain(escaped)),
                        },
                        plain => json.push(plain),
                    }
                }
                json.push('"');
            }
            '(' => json.push('['),
            ')' | ']' | '}' => {
                let kept = json.trim_end().strip_suffix(',').map(str::len);
                json.truncate(kept.unwrap_or(json.len()));
                json.push(if letter == ')' { ']' } else { letter });
            }
            // A long of Python 2.
            'L' => {}
            'T' | 'F' => json.push(letter.to_ascii_lowercase()),
            plain => json.push(plain),
        }
    }
    json
}

/// Writes an array of one dimension of floating-point numbers of `N` bytes, as NumPy does.
pub(crate) fn write<const N: usize>(
    out: impl Write,
    numbers: impl ExactSizeIterator<Item = [u8; N]>,
) -> std::io::Result<()> {
    let rows = numbers.len();
    let header = format!("{{'descr': '<f{N}', 'fortran_order': False, 'shape': ({rows},), }}");
    // All that stands before the numbers takes a multiple of 64 bytes: 128 with any count of rows.
    let mut out = BufWriter::new(out);
    out.write_all(b"\x93NUMPY\x01\x00\x76\x00")?;
    writeln!(out, "{header:<117}")?;
    for number in numbers {
        out.write_all(&number)?;
    }
    out.flush()
}

/// The bytes of a header, with those before it.
fn header(input: &mut impl Read) -> Result<Vec<u8>, String> {
    let truncated = |_| "ends within its header".to_owned();
    let mut bytes = vec![0; 10];
    let mut found = 0;
    while let Some(rest) = bytes.get_mut(found..).filter(|rest| !rest.is_empty()) {
        match input.read(rest).map_err(truncated)? {
            0 => break,
            read => found += read,
        }
    }
    let magic = b"\x93NUMPY";
    if !bytes.starts_with(&magic[..found.min(magic.len())]) || found == 0 {
        return Err("is no .npy".to_owned());
    }
    let mut length = [0; 4];
    match bytes.get(6).filter(|_| found == bytes.len()) {
        None => return Err("ends within its header".to_owned()),
        Some(1) => length[..2].copy_from_slice(&bytes[8..10]),
        Some(2 | 3) => {
            let mut more = [0; 2];
            input.read_exact(&mut more).map_err(truncated)?;
            bytes.extend(more);
            length.copy_from_slice(&bytes[8..12]);
        }
        Some(version) => {
            return Err(format!("has version {version} of the format; 1 to 3 are read"));
        }
    }
    let length = usize::try_from(u32::from_le_bytes(length)).unwrap_or(usize::MAX);
    if length > MOST_HEADER {
        return Err(format!("has a header of {length} bytes; {MOST_HEADER} are read"));
    }
    let start = bytes.len();
    bytes.resize(start + length, 0);
    input.read_exact(&mut bytes[start..]).map_err(truncated)?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    #[test]
    fn literals_of_python_are_json() {
        for (python, json) in [
            (
                "{'shape': (3,), 'fortran_order': False, }",
                r#"{"shape": [3], "fortran_order": false}"#,
            ),
            (
                r#"[(('a title', "x'y"), '<f4', (2, 3)), ('(,T"', 'i1' , )]"#,
                r#"[[["a title", "x'y"], "<f4", [2, 3]], ["(,T\"", "i1"]]"#,
            ),
            (r"'\'\\\n\xe9\u00fcü'", r#""'\\\n\u00e9\u00fcü""#),
            ("()", "[]"),
            ("(2000L,)", "[2000]"),
            ("'open", r#""open""#),
        ] {
            let understood = super::json(python);
            let value = serde_json::from_str::<serde_json::Value>(&understood).unwrap();
            assert_eq!(value, serde_json::from_str::<serde_json::Value>(json).unwrap(), "{python}");
        }
    }

    #[test]
    fn a_shape_of_a_field_may_be_a_number() {
        for (shape, size) in [("3", 20), ("[3]", 20), ("[2, 2]", 24), ("[]", 12)] {
            let mut fields = super::Fields::default();
            let descr = format!(r#"[["t", "<f8"], ["x", "<f4", {shape}]]"#);
            fields.take(&serde_json::from_str(&descr).unwrap(), "").unwrap();
            assert_eq!((fields.size, fields.fields.len()), (size, (size - 8) / 4 + 1), "{shape}");
        }
        for shape in ["null", "-3", "\"3\"", "[[3]]"] {
            let descr = format!(r#"[["x", "<f4", {shape}]]"#);
            let descr = serde_json::from_str(&descr).unwrap();
            assert!(super::Fields::default().take(&descr, "").is_err(), "{shape}");
        }
    }
}
