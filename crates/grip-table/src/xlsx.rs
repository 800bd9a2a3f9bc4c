//! A workbook of Excel, its first sheet with numbers as the text of a table.

use std::{
    io::{self, Cursor, Read},
    path::Path,
};

use calamine::{DataRef, Reader as _, Xlsx};
use zip::ZipArchive;

use crate::TableError;

/// Most bytes of a workbook, and of the text that it becomes.
const MOST: usize = 64 << 20;
const MOST_TEXT: usize = 512 << 20;
/// Most bytes of all its parts unpacked, and of its shared strings, which are held one by one.
const MOST_UNPACKED: u64 = 256 << 20;
const MOST_STRINGS: u64 = 64 << 20;
/// Beyond so many bytes a part that was packed to less than a hundredth is no sheet that a program has written.
const ANY_RATIO: u64 = 16 << 20;
const MOST_RATIO: u64 = 100;
/// Most cells between the first and the last that is filled.
const MOST_CELLS: u64 = 1 << 26;
/// Most rows and columns of a sheet, by its format.
const MOST_ROWS: u32 = 1 << 20;
const MOST_COLUMNS: u32 = 1 << 14;

/// Whether a file that begins so is one.
pub(crate) fn is_workbook(head: &[u8]) -> bool {
    let has = |name: &[u8]| memchr::memmem::find(head, name).is_some();
    head.starts_with(b"PK\x03\x04")
        && (has(b"[Content_Types].xml") || has(b"xl/") || has(b"_rels/"))
}

/// The cells of a workbook between tabs. `head` and `input` are its bytes.
pub(crate) fn text_of(file: &Path, head: &[u8], input: impl Read) -> Result<Vec<u8>, TableError> {
    let fault = |reason: String| TableError::Workbook { file: file.to_owned(), reason };
    let mut bytes = head.to_vec();
    input.take(MOST as u64).read_to_end(&mut bytes).map_err(|error| fault(error.to_string()))?;
    if bytes.len() > MOST {
        return Err(fault(format!("it has more than {MOST} bytes")));
    }
    bound(&bytes).map_err(fault)?;
    let mut book = Xlsx::new(Cursor::new(bytes)).map_err(|error| fault(error.to_string()))?;
    for sheet in book.sheet_names() {
        let (text, numbers) = sheet_of(&mut book, &sheet).map_err(fault)?;
        if numbers > 0 {
            return Ok(text);
        }
    }
    Err(fault("no sheet has numbers".to_owned()))
}

/// Unpacks every part once and keeps none of it: the sizes that a file states of itself may be wrong.
fn bound(bytes: &[u8]) -> Result<(), String> {
    let mut parts = ZipArchive::new(Cursor::new(bytes)).map_err(|error| error.to_string())?;
    let mut all = 0;
    for at in 0..parts.len() {
        let part = parts.by_index(at).map_err(|error| error.to_string())?;
        let name = part.name().map_err(|error| error.to_string())?.to_ascii_lowercase();
        let packed = part.compressed_size();
        let most = if name.ends_with("sharedstrings.xml") { MOST_STRINGS } else { MOST_UNPACKED };
        let most = most.min(ANY_RATIO.max(packed.saturating_mul(MOST_RATIO)));
        let size = io::copy(&mut part.take(most + 1), &mut io::sink())
            .map_err(|error| format!("{name:?}: {error}"))?;
        all += size;
        if size > most || all > MOST_UNPACKED {
            return Err(format!(
                "its part {name:?} unpacks to more than {} MiB, more than is read",
                size.min(most) >> 20
            ));
        }
    }
    Ok(())
}

fn sheet_of(book: &mut Xlsx<Cursor<Vec<u8>>>, sheet: &str) -> Result<(Vec<u8>, usize), String> {
    let mut cells = book.worksheet_cells_reader(sheet).map_err(|error| error.to_string())?;
    let mut lines: Vec<Line> = Vec::new();
    let (mut bytes, mut numbers, mut width) = (0, 0, 0);
    while let Some(cell) = cells.next_cell().map_err(|error| error.to_string())? {
        let (row, column) = cell.get_position();
        let is_number = matches!(cell.get_value(), DataRef::Float(_) | DataRef::Int(_));
        let written = match cell.get_value() {
            DataRef::Empty => continue,
            DataRef::Float(value) => value.to_string(),
            DataRef::Int(value) => value.to_string(),
            DataRef::String(word) => quoted(word),
            DataRef::SharedString(word) => quoted(word),
            DataRef::Error(_) => "NaN".to_owned(),
            other => quoted(&calamine::Data::from(other.clone()).to_string()),
        };
        if row >= MOST_ROWS || column >= MOST_COLUMNS {
            return Err("a cell lies outside of every sheet".to_owned());
        }
        width = width.max(u64::from(column) + 1);
        let height = lines.len().max(row as usize + 1);
        if width.saturating_mul(height as u64) > MOST_CELLS {
            return Err(format!(
                "sheet {sheet:?} has more than {MOST_CELLS} cells between its first and its last; delete what stands \
                 far from the table"
            ));
        }
        lines.resize_with(height, Line::default);
        let Some(line) = lines.get_mut(row as usize) else { continue };
        bytes += written.len() + column.saturating_sub(line.column) as usize;
        if bytes > MOST_TEXT {
            return Err(format!("its sheet has more than {MOST_TEXT} bytes of text"));
        }
        line.go_to(column);
        line.text.push_str(&written);
        line.has_number |= is_number;
        numbers += usize::from(is_number);
    }
    // Cells at the end of a row that were never filled are not in the file.
    let last = lines.iter().filter(|line| line.has_number).map(|line| line.column).max();
    let mut text = Vec::new();
    for mut line in lines {
        if line.has_number {
            line.go_to(last.unwrap_or(0));
        }
        text.extend_from_slice(line.text.as_bytes());
        text.push(b'\n');
        if text.len() > MOST_TEXT {
            return Err(format!("its sheet has more than {MOST_TEXT} bytes of text"));
        }
    }
    Ok((text, numbers))
}

/// The cells of one row between tabs.
#[derive(Default)]
struct Line {
    text: String,
    /// The column at its end.
    column: u32,
    has_number: bool,
}

impl Line {
    fn go_to(&mut self, column: u32) {
        while self.column < column {
            self.text.push('\t');
            self.column += 1;
        }
    }
}

fn quoted(text: &str) -> String {
    format!("\"{}\"", text.replace('"', "\"\""))
}
