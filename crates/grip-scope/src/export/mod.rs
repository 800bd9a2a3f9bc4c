//! Files of a span: CSV of what is kept, an MCAP slice of a recording or of what is kept, a page about a grasp.

mod csv;
mod mcap;
mod part;
mod slice;

pub use csv::csv;
pub use mcap::mcap;
pub use part::Part;
pub use slice::mcap_slice;

use grip_plot::report::{Report, ReportError};
use grip_record::mcap::{McapError, McapWriteError};
use grip_record::outputs::{OutputError, OutputFile, OutputKind, OutputPath};
use std::io::{self, Write as _};
use std::path::Path;

/// Who writes.
const PROGRAM: &str = concat!("grip-scope ", env!("CARGO_PKG_VERSION"));

/// What a recording that was written holds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sliced {
    /// Samples.
    pub samples: u64,
    /// Messages of all kinds, samples included.
    pub messages: u64,
    /// Damaged parts of the recording that were left out of it; one of them may be its end.
    pub damaged: u32,
}

/// Why nothing, or not all, was written.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// The file cannot, or must not, be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// Rows, a picture or a page cannot be written.
    #[error("the file cannot be written ({0})")]
    Write(#[from] io::Error),
    /// A recording cannot be written.
    #[error(transparent)]
    Record(#[from] McapWriteError),
    /// The recording that the slice comes from cannot be read.
    #[error(transparent)]
    Read(#[from] McapError),
    /// The page cannot be made.
    #[error(transparent)]
    Page(#[from] ReportError),
    /// There are no samples.
    #[error("there are no samples in this span to write")]
    Empty,
}

impl ExportError {
    /// The sentence, which names the file once: some errors name it themselves.
    #[must_use]
    pub fn about(&self, path: &Path) -> String {
        let (name, text) = (path.display().to_string(), self.to_string());
        if text.contains(&name) { text } else { format!("{name}: {text}") }
    }
}

/// Writes a page as one HTML file that needs nothing from elsewhere: the bytes of it.
///
/// # Errors
/// Where there is no page, there is a file of this name, or it cannot be written.
pub fn html(page: Option<&Report>, path: &Path) -> Result<usize, ExportError> {
    let page = page.ok_or(ExportError::Empty)?.html()?;
    fill(path, None, |file| {
        file.write_all(page.as_bytes())?;
        Ok(page.len())
    })
}

/// Makes the file and lets `write` fill it: nothing is replaced, least of all the recording `from`, and nothing is left behind where
/// writing fails.
///
/// # Errors
/// Where there is a file of this name, it cannot be made, or `write` fails.
pub fn fill<T>(
    path: &Path,
    from: Option<&Path>,
    write: impl FnOnce(&mut OutputFile) -> Result<T, ExportError>,
) -> Result<T, ExportError> {
    let mut file = OutputPath::new(path, OutputKind::ANY, from, None)?.create()?;
    let written = write(&mut file)?;
    file.finish()?;
    Ok(written)
}

#[cfg(test)]
mod tests {
    use super::{ExportError, OutputError};
    use std::path::Path;

    #[test]
    fn an_error_names_its_file_once() {
        let file = Path::new("run-0001.csv");
        let there = OutputError::Exists { file: file.to_owned(), has_force: false };
        let full = std::io::Error::from(std::io::ErrorKind::StorageFull);
        for error in [there.into(), ExportError::Empty, full.into()] {
            let text = error.about(file);
            assert!(
                text.starts_with("run-0001.csv: ") && text.matches("run-0001").count() == 1,
                "{text}"
            );
        }
    }
}
