//! The model and a span in, files out.

mod csv;

pub use csv::{ExportError, csv};
