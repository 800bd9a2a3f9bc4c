//! A workbook of Excel, its first sheet with numbers as the text of a table.

use std::{
    io::{Cursor, Read},
    path::Path,
};

use calamine::{DataRef, Reader as _, Xlsx};

use crate::TableError;

/// Most bytes of a workbook, and of the text that it becomes.
const MOST: usize = 64 << 20;
const MOST_TEXT: usize = 512 << 20;
/// Most rows of a sheet, by its format.
const MOST_ROWS: u32 = 1 << 20;

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
    let mut book = Xlsx::new(Cursor::new(bytes)).map_err(|error| fault(error.to_string()))?;
    for sheet in book.sheet_names() {
        let (text, numbers) = sheet_of(&mut book, &sheet).map_err(fault)?;
        if numbers > 0 {
            return Ok(text);
        }
    }
    Err(fault("no sheet has numbers".to_owned()))
}

fn sheet_of(book: &mut Xlsx<Cursor<Vec<u8>>>, sheet: &str) -> Result<(Vec<u8>, usize), String> {
    let mut cells = book.worksheet_cells_reader(sheet).map_err(|error| error.to_string())?;
    let (mut text, mut numbers, mut row, mut column) = (Vec::new(), 0, 0, 0);
    while let Some(cell) = cells.next_cell().map_err(|error| error.to_string())? {
        let (at_row, at_column) = cell.get_position();
        if at_row >= MOST_ROWS || at_column >= MOST_ROWS {
            return Err("a cell lies outside of every sheet".to_owned());
        }
        let written = match cell.get_value() {
            DataRef::Empty => continue,
            DataRef::Float(value) => {
                numbers += 1;
                value.to_string()
            }
            DataRef::Int(value) => {
                numbers += 1;
                value.to_string()
            }
            DataRef::String(word) => quoted(word),
            DataRef::SharedString(word) => quoted(word),
            DataRef::Error(_) => "NaN".to_owned(),
            other => quoted(&calamine::Data::from(other.clone()).to_string()),
        };
        while row < at_row {
            text.push(b'\n');
            (row, column) = (row + 1, 0);
        }
        while column < at_column {
            text.push(b'\t');
            column += 1;
        }
        text.extend_from_slice(written.as_bytes());
        if text.len() > MOST_TEXT {
            return Err(format!("its sheet has more than {MOST_TEXT} bytes of text"));
        }
    }
    text.push(b'\n');
    Ok((text, numbers))
}

fn quoted(text: &str) -> String {
    format!("\"{}\"", text.replace('"', "\"\""))
}
