//! An array of NumPy in: one signal a column.

use crate::{
    ImportOptions,
    error::ImportError,
    stream::{Stream, Times, reading},
    time::TimeUnit,
};
use grip_record::{files, parse_npy};
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
    let first_is_time = options.rate_hz.is_none();
    let from = usize::from(first_is_time);
    let mut stream = Stream::new("", (from..width).map(|k| format!("column_{k}")).collect());
    if sideways {
        stream.notes.push(format!(
            "an array of {width} x {rows}, taken as {rows} samples of {width} columns"
        ));
    }
    if first_is_time {
        if width < 2 {
            return Err(ImportError::nothing(file, "one column without times; give --rate HZ"));
        }
        let times: Vec<f64> = column(0).collect();
        if !times.is_sorted() {
            let what = "column_0 never decreasing would be its times, but it does; give --rate HZ where there are none";
            return Err(ImportError::nothing(file, what));
        }
        let unit = options.time_unit.map_or_else(|| TimeUnit::of_numbers(&times), Ok);
        let unit = unit.map_err(|fault| {
            ImportError::nothing(file, &format!("the times in column_0 {fault}"))
        })?;
        stream.clock = format!("column_0 ({})", unit.name());
        let stamps: Option<Vec<i64>> = times.into_iter().map(|t| unit.to_ns(t)).collect();
        let stamps =
            stamps.ok_or_else(|| ImportError::nothing(file, "a time in column_0 is no number"))?;
        stream.times = Times::Stamps(stamps);
    }
    stream.values = (from..width).map(|k| column(k).map(reading).collect()).collect();
    Ok(vec![stream.without_names()])
}
