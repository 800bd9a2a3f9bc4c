//! The model and a span in, files out: CSV of what is kept, an MCAP slice of a recording or of what is kept.

mod csv;
mod mcap;

pub use csv::csv;
pub use mcap::{Sliced, mcap, mcap_slice};

use grip_record::mcap::{McapError, McapWriteError};
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

/// Why nothing, or not all, was written.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// The file cannot be written.
    #[error("{}: cannot be written ({source})", file.display())]
    Write {
        /// The file.
        file: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// There is a file of this name.
    #[error("{}: is there already and is not replaced; choose another name", file.display())]
    Exists {
        /// The file.
        file: PathBuf,
    },
    /// A recording cannot be written.
    #[error("{}: {source}", file.display())]
    Record {
        /// The file.
        file: PathBuf,
        /// Why.
        source: McapWriteError,
    },
    /// The recording that the slice comes from cannot be read.
    #[error(transparent)]
    Read(#[from] McapError),
    /// The slice would replace the recording it comes from.
    #[error("{}: is the recording itself; choose another name", file.display())]
    Same {
        /// The file.
        file: PathBuf,
    },
    /// There are no samples.
    #[error("there are no samples in this span to write")]
    Empty,
    /// The samples of the span are gone but for their extremes.
    #[error(
        "the samples of this span are thinned out to extremes of 32: a recording needs all of them; write CSV, or slice the file"
    )]
    Thin,
}

/// Makes the file and lets `write` fill it: nothing is replaced, and nothing is left behind where writing fails.
fn fill<T>(
    path: &Path,
    write: impl FnOnce(File) -> Result<T, ExportError>,
) -> Result<T, ExportError> {
    let file = File::create_new(path).map_err(|source| match source.kind() {
        io::ErrorKind::AlreadyExists => ExportError::Exists { file: path.to_owned() },
        _ => ExportError::Write { file: path.to_owned(), source },
    })?;
    let written = write(file);
    if written.is_err() {
        // A file without its end would look like one that was cut off.
        let _gone = fs::remove_file(path);
    }
    written
}
