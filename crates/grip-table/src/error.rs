//! Why a file is no table, or a row or cell of it cannot be used: where, and what helps.

use std::{io, path::PathBuf};

/// Why a table could not be read. Lines and columns count from 1, as an editor shows them.
#[derive(Debug, thiserror::Error)]
pub enum TableError {
    /// The file cannot be read.
    #[error("{}: cannot be read ({source}); check the path and its permissions", file.display())]
    Unreadable {
        /// The file.
        file: PathBuf,
        /// What the operating system states.
        source: io::Error,
    },
    /// The file is empty, or blank.
    #[error("{}: is empty; the first line must name the columns, e.g. t_s,stylus or x_mm,height_um", file.display())]
    Empty {
        /// The file.
        file: PathBuf,
    },
    /// A file of another kind.
    #[error("{}: is no table but {kind}; {}", file.display(), remedy.replace("FILE", &file.to_string_lossy()))]
    Foreign {
        /// The file.
        file: PathBuf,
        /// What it is.
        kind: &'static str,
        /// What makes a table of it.
        remedy: &'static str,
    },
    /// Bytes that are no text.
    #[error(
        "{}: is no text; name a file by its kind (.csv, .npz, .mcap; gripctl import reads .wav and .npy too); a sound of \
         another kind becomes one with: ffmpeg -i {} sound.wav",
        file.display(), file.display()
    )]
    NoText {
        /// The file.
        file: PathBuf,
    },
    /// A workbook that cannot be read.
    #[error("{}: the workbook cannot be read ({reason}); save the sheet as CSV", file.display())]
    Workbook {
        /// The file.
        file: PathBuf,
        /// Why.
        reason: String,
    },
    /// A line longer than is believed.
    #[error("{}: it is no table: a line has more than {} bytes", file.display(), crate::LONGEST_LINE)]
    LongLine {
        /// The file.
        file: PathBuf,
    },
    /// A quotation mark that never ends.
    #[error("{}: line {line}: a quotation mark has no second one; write it twice inside of quotes", file.display())]
    OpenQuote {
        /// The file.
        file: PathBuf,
        /// The line where the quotes begin.
        line: u64,
    },
    /// Commas that may be decimal or separate cells.
    #[error(
        "{}: line {line}: {text:?} may be numbers with decimal commas, or as many cells as it has digits between commas; save \
         the table with semicolons between the columns, or write a name above each column (one name for one column of decimal \
         commas)",
        file.display()
    )]
    DecimalCommas {
        /// The file.
        file: PathBuf,
        /// The line.
        line: u64,
        /// The row, at most 40 characters of it.
        text: String,
    },
    /// A column that is not there.
    #[error(
        "{}: no column {wanted}{}; the file has: {}",
        file.display(), read_too(names), list(found)
    )]
    Missing {
        /// The file.
        file: PathBuf,
        /// The name looked for.
        wanted: String,
        /// Names of which one column with a fitting unit is read too.
        names: Vec<String>,
        /// The names there are.
        found: Vec<String>,
    },
    /// Two columns have the name of one that is wanted.
    #[error(
        "{}: line {line}: columns {first} and {second} are both named {name:?}; rename or remove one of them",
        file.display()
    )]
    Repeated {
        /// The file.
        file: PathBuf,
        /// Line of the header.
        line: u64,
        /// The repeated name.
        name: String,
        /// Number of the first such column.
        first: usize,
        /// Number of the second such column.
        second: usize,
    },
    /// A column without a unit where one is needed.
    #[error(
        "{}: column {column} has no unit; name it by its unit, for example {wanted}, or write the unit in brackets behind or below the \
         name",
        file.display()
    )]
    NoUnit {
        /// The file.
        file: PathBuf,
        /// The column as the file names it.
        column: String,
        /// A name with a unit.
        wanted: String,
    },
    /// A unit that is not known, or of something else.
    #[error("{}: column {column} is in {unit:?}, which is no known unit of {wanted}", file.display())]
    Unit {
        /// The file.
        file: PathBuf,
        /// The column as the file names it.
        column: String,
        /// Its unit.
        unit: String,
        /// What is wanted, with examples.
        wanted: &'static str,
    },
    /// A row has more or fewer cells than there are columns.
    #[error(
        "{}: line {line}: {found} fields where the header names {expected}; {}",
        file.display(),
        if found > expected { "remove the extra commas" } else { "add the missing fields (an empty one is a comma)" }
    )]
    FieldCount {
        /// The file.
        file: PathBuf,
        /// The line.
        line: u64,
        /// Fields of the header.
        expected: usize,
        /// Fields of the row.
        found: usize,
    },
    /// The header again, below rows: two recordings in one file.
    #[error("{}: line {line} is the header again: a second recording begins there; split the file above it", file.display())]
    HeaderAgain {
        /// The file.
        file: PathBuf,
        /// The line.
        line: u64,
    },
    /// A cell that must hold a number holds something else.
    #[error("{}: line {line}, column {column}: {text:?} is not a number; {remedy}", file.display())]
    NotANumber {
        /// The file.
        file: PathBuf,
        /// The line.
        line: u64,
        /// The column as the file names it.
        column: String,
        /// The cell, at most 40 characters of it.
        text: String,
        /// What to write instead.
        remedy: &'static str,
    },
    /// A number that must be finite is not.
    #[error("{}: line {line}, column {column}: {text:?} is not finite; remove the row", file.display())]
    NotFinite {
        /// The file.
        file: PathBuf,
        /// The line.
        line: u64,
        /// The column as the file names it.
        column: String,
        /// The cell, at most 40 characters of it.
        text: String,
    },
}

fn read_too(names: &[String]) -> String {
    match names {
        [_, _, ..] => {
            format!(
                "; one column named {} with its unit in brackets or below is read too",
                names.join(", ")
            )
        }
        _ => String::new(),
    }
}

/// The first names, separated by commas: a bag may have hundreds. Those with a comma stand in quotes.
#[must_use]
pub fn list(names: &[String]) -> String {
    const MOST: usize = 40;
    let shown = names.iter().filter(|name| !name.is_empty()).take(MOST);
    let quoted =
        |name: &String| if name.contains(',') { format!("{name:?}") } else { visible(name) };
    let shown = shown.map(quoted).collect::<Vec<_>>().join(", ");
    match names.len().saturating_sub(MOST) {
        0 => shown,
        more => format!("{shown} and {more} more"),
    }
}

/// A name of a file without characters that change a terminal or forge a line of a message.
#[must_use]
pub fn visible(name: &str) -> String {
    let mut shown = String::with_capacity(name.len());
    for c in name.chars() {
        match c.is_control() || matches!(c, '\u{2028}'..='\u{202e}') {
            true => shown.extend(c.escape_default()),
            false => shown.push(c),
        }
    }
    shown
}

/// The first 40 characters of a cell: enough to find it.
#[must_use]
pub fn excerpt(text: &str) -> String {
    text.chars().take(40).collect()
}
