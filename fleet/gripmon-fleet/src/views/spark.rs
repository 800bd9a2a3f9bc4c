//! The last minutes of a value, as high as a row.

use super::TableSeen;
use crate::grippers::{COLUMNS, Row, Spark};
use eframe::egui::{Mesh, Painter, Rect, Shape, Stroke, vec2};
use grip_scope::{Bucket, Span};
use gripmon::num;
use gripmon::palette::Tone;
use gripmon::plot::{self, Frame, Kind, Scale, Style};

/// What the curves of all rows are scaled by, so that they can be compared.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scales {
    force: Scale,
    statistic: Scale,
}

/// Scales for forces up to this one (N).
pub(super) fn scale(top_n: f32) -> Scales {
    let top_n = f64::from(top_n).max(1.0);
    let force = Scale::new(Kind::Linear, 0.0, 1.05 * top_n);
    Scales { force, statistic: Scale::new(Kind::Log, 1e-6, 1e1) }
}

/// Lowest to highest force of each column.
pub(super) fn force(
    painter: &Painter,
    cell: Rect,
    row: &Row,
    seen: &TableSeen<'_>,
    scales: &Scales,
) {
    let frame = frame(cell, scales.force);
    curve(painter, &frame, &buckets(&row.force, seen, |low, high| (low, high)), seen, Tone::Sky);
}

/// The highest statistic of each column, from the bottom, and where it is a slip.
pub(super) fn statistic(
    painter: &Painter,
    cell: Rect,
    row: &Row,
    seen: &TableSeen<'_>,
    scales: &Scales,
) {
    let frame = frame(cell, scales.statistic);
    let y = painter.round_to_pixel_center(frame.y(1.0));
    painter.hline(frame.rect.x_range(), y, Stroke::new(1.0, seen.palette.edge));
    let bars = buckets(&row.statistic, seen, |_, high| (0.0, high));
    curve(painter, &frame, &bars, seen, Tone::Blue);
}

fn frame(cell: Rect, scale: Scale) -> Frame {
    let span = Span { from_s: 0.0, to_s: num::count(COLUMNS) };
    Frame { rect: cell.shrink2(vec2(0.0, 3.0)), span, scale }
}

/// The columns as a curve has them; their times are their numbers.
fn buckets(
    spark: &Spark,
    seen: &TableSeen<'_>,
    edges: impl Fn(f32, f32) -> (f32, f32),
) -> Vec<Bucket> {
    let bucket = |(at, column): (usize, Option<(f32, f32)>)| {
        let (min, max) = column.map_or((f32::NAN, f32::NAN), |(low, high)| edges(low, high));
        let from_s = num::count(at);
        let (to_s, count) = (from_s + 1.0, u64::from(column.is_some()));
        Bucket { from_s, to_s, min, max, mean: max, count, broken: false }
    };
    spark.until(seen.roster.now_s()).enumerate().map(bucket).collect()
}

fn curve(painter: &Painter, frame: &Frame, buckets: &[Bucket], seen: &TableSeen<'_>, tone: Tone) {
    let mut mesh = Mesh::default();
    plot::ribbon(&mut mesh, frame, buckets, seen.palette.tone(tone), Style::Solid);
    let inside = frame.rect.expand(1.0).intersect(painter.clip_rect());
    painter.with_clip_rect(inside).add(Shape::mesh(mesh));
}
