//! Channels of a span in, a CSV file out: one row for each time at which any of them has a sample.
//!
//! `t_s` is the device's time on the axis of the model; a channel without a sample at a time has an empty cell, so rows of samples and
//! states stand in one file. Where samples are thinned out, the file says in which columns: `NAME_min` and `NAME_max` of 32 samples each.

use super::{ExportError, fill};
use crate::model::{Bucket, Series};
use crate::{channel::Channel, model::Model, span::Span};
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

/// Rows beyond this are not written: a file of some hundred MB helps nobody.
const MOST: usize = 20_000_000;

/// One column of the file.
struct Column {
    name: String,
    points: Vec<[f64; 2]>,
    next: usize,
}

/// Writes the samples of `channels` in the span as CSV: how many rows.
///
/// # Errors
/// Where there is nothing to write, too much, there is a file of this name, or it cannot be written.
pub fn csv(
    model: &Model,
    span: Span,
    channels: &[Channel],
    path: &Path,
) -> Result<u64, ExportError> {
    let series = channels.iter().filter_map(|channel| model.series(*channel));
    let mut columns: Vec<Column> = series.flat_map(|series| columns_of(series, span)).collect();
    columns.retain(|column| !column.points.is_empty());
    if columns.is_empty() {
        return Err(ExportError::Empty);
    }
    fill(path, |file| {
        rows(&mut columns, file)
            .map_err(|source| ExportError::Write { file: path.to_owned(), source })
    })
}

/// Writes the columns: how many rows.
fn rows(columns: &mut [Column], file: File) -> io::Result<u64> {
    let mut out = BufWriter::new(file);
    let names: Vec<&str> = columns.iter().map(|column| column.name.as_str()).collect();
    writeln!(out, "t_s,{}", names.join(","))?;
    let mut rows = 0;
    while let Some(t_s) = next_time(columns) {
        write!(out, "{t_s:.6}")?;
        for column in columns.iter_mut() {
            match column.take(t_s) {
                Some(value) => write!(out, ",{value}")?,
                None => write!(out, ",")?,
            }
        }
        writeln!(out)?;
        rows += 1;
    }
    out.flush()?;
    Ok(rows)
}

/// The samples of a channel; lowest and highest of each finest part, where they are thinned out or too many.
fn columns_of(series: &Series, span: Span) -> Vec<Column> {
    let name = series.channel().column();
    let mut points = Vec::new();
    if series.points(span, MOST, &mut points) {
        points.retain(|[t_s, value]| span.holds(*t_s) && !value.is_nan());
        return vec![Column { name, points, next: 0 }];
    }
    let Some(have) = series.span().and_then(|have| have.common(span)) else { return Vec::new() };
    let mut parts = Vec::new();
    let count = series.stats(have).map_or(0, |stats| stats.count);
    let wanted = usize::try_from(count).unwrap_or(usize::MAX) / Series::finest();
    series.envelope(have, wanted.clamp(1, MOST), &mut parts);
    let column = |suffix: &str, value: fn(&Bucket) -> f32| Column {
        name: format!("{name}_{suffix}"),
        points: parts.iter().map(|part| [part.from_s, f64::from(value(part))]).collect(),
        next: 0,
    };
    vec![column("min", |part| part.min), column("max", |part| part.max)]
}

/// Times that differ by less than this (s) are one row.
const SAME_S: f64 = 1e-6;

impl Column {
    /// The value at this time, where there is one.
    fn take(&mut self, t_s: f64) -> Option<f32> {
        let [at_s, value] = *self.points.get(self.next)?;
        if at_s > t_s + SAME_S {
            return None;
        }
        self.next += 1;
        #[expect(clippy::cast_possible_truncation, reason = "it was kept as f32")]
        Some(value as f32)
    }
}

fn next_time(columns: &[Column]) -> Option<f64> {
    let next = columns.iter().filter_map(|column| column.points.get(column.next));
    next.map(|point| point[0]).min_by(f64::total_cmp)
}
