//! A CSV file of channels: one row for each time at which any of them has a sample.
//!
//! `t_s` is the device's time on the axis of the model; a channel without a sample at a time has an empty cell, so rows of samples and
//! states stand in one file.

use super::part::{Column, Part};
use super::{ExportError, fill};
use std::io::{self, Write};
use std::path::Path;

/// Writes the samples as CSV: how many rows.
///
/// # Errors
/// Where there is nothing to write, there is a file of this name, or it cannot be written.
pub fn csv(part: Part, path: &Path) -> Result<u64, ExportError> {
    if part.columns.is_empty() {
        return Err(ExportError::Empty);
    }
    fill(path, None, |file| Ok(write(part.columns, file)?))
}

fn write(mut columns: Vec<Column>, out: &mut impl Write) -> io::Result<u64> {
    let names: Vec<&str> = columns.iter().map(|column| column.name).collect();
    writeln!(out, "t_s,{}", names.join(","))?;
    let mut rows = 0;
    while let Some(t_s) = columns.iter().filter_map(Column::next_s).min_by(f64::total_cmp) {
        write!(out, "{t_s:.6}")?;
        for column in &mut columns {
            match column.take(t_s) {
                Some((value, _)) => write!(out, ",{value}")?,
                None => write!(out, ",")?,
            }
        }
        writeln!(out)?;
        rows += 1;
    }
    out.flush()?;
    Ok(rows)
}
