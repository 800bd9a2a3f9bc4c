//! The model and a span in, files out: CSV of what is kept, an MCAP slice of a recording or of what is kept.

mod csv;
mod mcap;

pub use csv::csv;
pub use mcap::{Sliced, mcap, mcap_slice};

use grip_record::mcap::{McapError, McapWriteError};
use std::io;
use std::path::PathBuf;

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
