//! Channels of a span in, a CSV file out: one row for each time at which any of them has a sample.
//!
//! `t_s` is the device's time on the axis of the model; a channel without a sample at a time has an empty cell, so rows of samples and
//! states stand in one file.

use super::pieces::{Rest, SAME_S};
use super::{ExportError, fill};
use crate::model::{Info, Series};
use crate::{channel::Channel, model::Model, span::Span};
use core::ops::Deref;
use grip_record::outputs::OutputFile;
use std::io::Write as _;
use std::path::Path;

/// Writes the samples of `channels` in the span as CSV: how many rows. `look` lends the model, each time for a piece of some thousand
/// samples a channel, so that whoever fills or shows it goes on.
///
/// # Errors
/// Where there is nothing to write, there is a file of this name, it cannot be written, or samples are dropped meanwhile.
pub fn csv<G: Deref<Target = Model>>(
    look: impl Fn() -> G,
    span: Span,
    channels: &[Channel],
    path: &Path,
) -> Result<u64, ExportError> {
    let (mut columns, mut rest) = {
        let model = look();
        let series = channels.iter().filter_map(|channel| model.series(*channel));
        let holds = series.filter(|series| series.stats(span).is_some());
        let columns: Vec<Column> = holds.map(|series| Column::new(model.info(), series)).collect();
        (columns, Rest::new(span, &model))
    };
    if columns.is_empty() {
        return Err(ExportError::Empty);
    }
    fill(path, None, |file| {
        let mut out = Rows::begin(&columns, file, path)?;
        while copy(&look(), &mut rest, &mut columns)? {
            out.write(&mut columns)?;
        }
        out.finish()
    })
}

/// Copies the next piece of all columns; `false` behind the last one.
fn copy(model: &Model, rest: &mut Rest, columns: &mut [Column]) -> Result<bool, ExportError> {
    let channels = columns.iter().map(|column| column.channel);
    let Some(piece) = rest.next(model, channels)? else { return Ok(false) };
    for column in columns {
        column.next = 0;
        if let Some(series) = model.series(column.channel) {
            series.copy(piece, &mut column.points);
            column.points.retain(|[_, value]| !value.is_nan());
        }
    }
    Ok(true)
}

/// One column of the file.
struct Column {
    channel: Channel,
    name: &'static str,
    points: Vec<[f64; 2]>,
    next: usize,
}

/// The file while it is written.
struct Rows<'a> {
    out: &'a mut OutputFile,
    path: &'a Path,
    rows: u64,
}

impl<'a> Rows<'a> {
    fn begin(
        columns: &[Column],
        out: &'a mut OutputFile,
        path: &'a Path,
    ) -> Result<Self, ExportError> {
        let rows = Self { out, path, rows: 0 };
        let names: Vec<&str> = columns.iter().map(|column| column.name).collect();
        let header = writeln!(rows.out, "t_s,{}", names.join(","));
        rows.reported(header)?;
        Ok(rows)
    }

    /// Writes what was copied last.
    fn write(&mut self, columns: &mut [Column]) -> Result<(), ExportError> {
        while let Some(t_s) = next_time(columns) {
            let cells: String = columns
                .iter_mut()
                .map(|column| column.take(t_s).map_or(",".to_owned(), |value| format!(",{value}")))
                .collect();
            let written = writeln!(self.out, "{t_s:.6}{cells}");
            self.reported(written)?;
            self.rows += 1;
        }
        Ok(())
    }

    fn finish(self) -> Result<u64, ExportError> {
        let flushed = self.out.flush();
        self.reported(flushed)?;
        Ok(self.rows)
    }

    fn reported(&self, done: std::io::Result<()>) -> Result<(), ExportError> {
        done.map_err(|source| ExportError::Write { file: self.path.to_owned(), source })
    }
}

impl Column {
    fn new(info: &Info, series: &Series) -> Self {
        // A vibration that is called a stylus would be read as metres.
        let name = match series.channel() {
            Channel::Stylus => info.name(Channel::Stylus),
            channel => channel.column(),
        };
        Self { channel: series.channel(), name, points: Vec::new(), next: 0 }
    }

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
