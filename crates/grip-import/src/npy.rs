//! An array of NumPy in: one signal a column.

use crate::{
    ImportOptions,
    error::ImportError,
    stream::{Stream, Times, reading},
};
use grip_record::{clock, files, parse_npy};
use std::path::Path;

/// More rows than columns is what a recording has; an array of at most so many rows lies on its side.
const MOST_SIDEWAYS: usize = 300;

pub(crate) fn read(file: &Path, options: &ImportOptions) -> Result<Vec<Stream>, ImportError> {
    let bytes = files::read(file, files::MOST_TABLE).map_err(ImportError::unreadable(file))?;
    let (values, width) = parse_npy(&bytes)
        .map_err(|fault| ImportError::nothing(file, &format!("the array {fault}")))?;
    drop(bytes);
    let rows = values.len() / width.max(1);
    let sideways = rows < width && rows <= MOST_SIDEWAYS;
    let (rows, width) = if sideways { (width, rows) } else { (rows, width) };
    let value = |row: usize, column: usize| {
        let at = if sideways { column * rows + row } else { row * width + column };
        values.get(at).copied().unwrap_or(f64::NAN)
    };
    let column = |column: usize| (0..rows).map(move |row| value(row, column));
    // A first column that never decreases is times, or counts rows; with a rate it is no signal either.
    let first: Vec<f64> = column(0).collect();
    let first_is_time = width > 1 && first.is_sorted() && first.first() < first.last();
    let from = usize::from(first_is_time);
    let mut stream = Stream::new("", (from..width).map(|k| format!("column_{k}")).collect());
    if sideways {
        stream.notes.push(format!(
            "an array of {width} x {rows}, taken as {rows} samples of {width} columns"
        ));
    }
    match clock::stamps("column_0", &first, options.time_unit) {
        Ok((unit, stamps)) if first_is_time => {
            stream.clock = format!("column_0 ({})", unit.name());
            stream.times = Times::Stamps(stamps);
        }
        _ if options.rate_hz.is_some() => {}
        Err(fault) if first_is_time => return Err(ImportError::nothing(file, &fault)),
        _ => {
            let what = "no column of times, which would be a first one that never decreases; give --rate HZ";
            return Err(ImportError::nothing(file, what));
        }
    }
    stream.values = (from..width).map(|k| column(k).map(reading).collect()).collect();
    Ok(vec![stream.without_names()])
}
