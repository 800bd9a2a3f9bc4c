//! Channels of a span in, a CSV file out: one row for each time at which any of them has a sample.
//!
//! `t_s` is the device's time on the axis of the model; a channel without a sample at a time has an empty cell, so rows of samples and
//! states stand in one file. Where samples are thinned out, the file states in which columns: `NAME_min` and `NAME_max` of 32 samples each.

use super::pieces::{Rest, SAME_S, reach};
use super::{ExportError, fill};
use crate::model::{Bucket, Info, Series};
use crate::{channel::Channel, model::Model, span::Span};
use core::ops::Deref;
use grip_record::outputs::OutputFile;
use std::io::Write as _;
use std::path::Path;

/// A channel with more samples than this in the span is reported by its extremes: a file of some hundred MB helps nobody.
const MOST: u64 = 20_000_000;
/// Parts of thinned-out samples that are looked at in one piece.
const PARTS: usize = 1024;

/// Writes the samples of `channels` in the span as CSV: how many rows. `look` lends the model, each time for a piece of some thousand
/// samples a channel, so that whoever fills or shows it goes on.
///
/// # Errors
/// Where there is nothing to write, there is a file of this name, it cannot be written, or the samples are thinned out meanwhile.
pub fn csv<G: Deref<Target = Model>>(
    look: impl Fn() -> G,
    span: Span,
    channels: &[Channel],
    path: &Path,
) -> Result<u64, ExportError> {
    let mut curves: Vec<Curve> = {
        let model = look();
        let series = channels.iter().filter_map(|channel| model.series(*channel));
        let info = model.info();
        series.filter_map(|series| Curve::new(info, series, span)).collect()
    };
    if curves.is_empty() {
        return Err(ExportError::Empty);
    }
    fill(path, None, |file| {
        let mut rest = Rest::new(span);
        let mut out = Rows::begin(&curves, file, path)?;
        while copy(&look(), &mut rest, &mut curves)? {
            out.write(&mut curves)?;
        }
        out.finish()
    })
}

/// Copies the next piece of all curves; `false` behind the last one.
fn copy(model: &Model, rest: &mut Rest, curves: &mut [Curve]) -> Result<bool, ExportError> {
    let from_s = rest.begin_s();
    let ends = curves.iter().map(|curve| curve.reach(model, from_s));
    let Some(piece) = rest.next(ends) else { return Ok(false) };
    for curve in curves {
        curve.copy(model, piece)?;
    }
    Ok(true)
}

/// A channel in the file: one column of samples, or two of extremes.
struct Curve {
    channel: Channel,
    /// Of thinned-out samples, or too many.
    grid: Option<Grid>,
    columns: Vec<Column>,
    parts: Vec<Bucket>,
}

/// Equal parts of the stretch in which a channel has samples.
#[derive(Clone, Copy)]
struct Grid {
    from_s: f64,
    width_s: f64,
    parts: usize,
    next: usize,
}

/// One column of the file.
struct Column {
    name: String,
    points: Vec<[f64; 2]>,
    next: usize,
}

impl Curve {
    /// `None` where the channel has no sample in the span.
    fn new(info: &Info, series: &Series, span: Span) -> Option<Self> {
        let count = series.stats(span)?.count;
        let whole = series.thin_before_s().is_none_or(|thin_s| thin_s < span.from_s);
        let grid =
            if whole && count <= MOST { None } else { Some(Grid::new(series, span, count)?) };
        // A vibration that is called a stylus would be read as metres.
        let name = match series.channel() {
            Channel::Stylus => info.name(Channel::Stylus).to_owned(),
            channel => channel.column(),
        };
        let column = |name| Column { name, points: Vec::new(), next: 0 };
        let columns = match grid {
            None => vec![column(name.to_owned())],
            Some(_) => vec![column(format!("{name}_min")), column(format!("{name}_max"))],
        };
        Some(Self { channel: series.channel(), grid, columns, parts: Vec::new() })
    }

    /// Where the next piece has to end (s).
    fn reach(&self, model: &Model, from_s: f64) -> Option<f64> {
        match self.grid {
            None => reach(model.series(self.channel)?, from_s),
            Some(grid) => (grid.next + PARTS < grid.parts).then(|| grid.edge(grid.next + PARTS)),
        }
    }

    /// Copies a piece from the model.
    fn copy(&mut self, model: &Model, piece: Span) -> Result<(), ExportError> {
        let Some(series) = model.series(self.channel) else { return Ok(()) };
        match (&mut self.grid, self.columns.as_mut_slice()) {
            (None, [column]) => {
                if !series.copy(piece, &mut column.points) {
                    return Err(ExportError::Thinned);
                }
                column.points.retain(|[_, value]| !value.is_nan());
            }
            (Some(grid), [min, max]) => {
                grid.copy(series, piece, &mut self.parts);
                let point = |part: &Bucket, value: f32| [part.from_s, f64::from(value)];
                min.points = self.parts.iter().map(|part| point(part, part.min)).collect();
                max.points = self.parts.iter().map(|part| point(part, part.max)).collect();
            }
            _ => {}
        }
        self.columns.iter_mut().for_each(|column| column.next = 0);
        Ok(())
    }
}

impl Grid {
    fn new(series: &Series, span: Span, count: u64) -> Option<Self> {
        let have = series.span()?.common(span)?;
        let wanted = usize::try_from(count.min(MOST)).unwrap_or(usize::MAX) / Series::finest();
        let parts = wanted.max(1);
        #[expect(clippy::cast_precision_loss, reason = "below 2^53")]
        let width_s = have.length_s() / parts as f64;
        Some(Self { from_s: have.from_s, width_s, parts, next: 0 })
    }

    #[expect(clippy::cast_precision_loss, reason = "below 2^53")]
    fn edge(&self, part: usize) -> f64 {
        self.width_s.mul_add(part as f64, self.from_s)
    }

    /// The parts that begin in the piece.
    fn copy(&mut self, series: &Series, piece: Span, out: &mut Vec<Bucket>) {
        let from = self.next;
        while self.next < self.parts && self.edge(self.next) <= piece.to_s {
            self.next += 1;
        }
        let (from_s, to_s) = (self.edge(from), self.edge(self.next));
        series.envelope(Span { from_s, to_s }, self.next - from, out);
        out.retain(|part| part.count > 0);
    }
}

/// The file while it is written.
struct Rows<'a> {
    out: &'a mut OutputFile,
    path: &'a Path,
    rows: u64,
}

impl<'a> Rows<'a> {
    fn begin(
        curves: &[Curve],
        out: &'a mut OutputFile,
        path: &'a Path,
    ) -> Result<Self, ExportError> {
        let rows = Self { out, path, rows: 0 };
        let columns = curves.iter().flat_map(|curve| &curve.columns);
        let names: Vec<&str> = columns.map(|column| column.name.as_str()).collect();
        let header = writeln!(rows.out, "t_s,{}", names.join(","));
        rows.reported(header)?;
        Ok(rows)
    }

    /// Writes what was copied last.
    fn write(&mut self, curves: &mut [Curve]) -> Result<(), ExportError> {
        let mut columns: Vec<&mut Column> =
            curves.iter_mut().flat_map(|curve| &mut curve.columns).collect();
        while let Some(t_s) = next_time(&columns) {
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

fn next_time(columns: &[&mut Column]) -> Option<f64> {
    let next = columns.iter().filter_map(|column| column.points.get(column.next));
    next.map(|point| point[0]).min_by(f64::total_cmp)
}
