//! The last minutes of a value, as high as a row.

use super::Seen;
use crate::grippers::{COLUMNS, Row, Spark};
use eframe::egui::{Mesh, Painter, Rangef, Rect, Shape, Stroke, vec2};
use grip_scope::Span;
use gripmon::num;
use gripmon::palette::Tone;
use gripmon::plot::{Frame, Kind, Scale};

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
pub(super) fn force(painter: &Painter, cell: Rect, row: &Row, seen: Seen<'_>, scales: &Scales) {
    let frame = frame(cell, scales.force);
    curve(painter, &frame, columns(&row.force, seen, |low, high| (low, high)), seen, Tone::Sky);
}

/// The highest statistic of each column, from the bottom, and where it is a slip.
pub(super) fn statistic(painter: &Painter, cell: Rect, row: &Row, seen: Seen<'_>, scales: &Scales) {
    let frame = frame(cell, scales.statistic);
    let y = painter.round_to_pixel_center(frame.y(1.0));
    painter.hline(frame.rect.x_range(), y, Stroke::new(1.0, seen.palette.edge));
    let bars = columns(&row.statistic, seen, |_, high| (0.0, high));
    curve(painter, &frame, bars, seen, Tone::Blue);
}

fn frame(cell: Rect, scale: Scale) -> Frame {
    let span = Span { from_s: 0.0, to_s: num::count(COLUMNS) };
    Frame { rect: cell.shrink2(vec2(0.0, 3.0)), span, scale }
}

/// The number of each column that has values, and from where to where it reaches.
fn columns<'a>(
    spark: &'a Spark,
    seen: Seen<'_>,
    edges: impl Fn(f32, f32) -> (f32, f32) + 'a,
) -> impl Iterator<Item = (f64, (f32, f32))> + 'a {
    let numbered = spark.until(seen.roster.now_s()).enumerate();
    numbered.filter_map(move |(at, column)| {
        column.map(|(low, high)| (num::count(at), edges(low, high)))
    })
}

/// Draws bars that touch, each at least a line high, as one shape.
fn curve(
    painter: &Painter,
    frame: &Frame,
    columns: impl Iterator<Item = (f64, (f32, f32))>,
    seen: Seen<'_>,
    tone: Tone,
) {
    let mut mesh = Mesh::default();
    for (at, (low, high)) in columns {
        let (top, bottom) = (frame.y(high.into()) - 0.6, frame.y(low.into()) + 0.6);
        let across = Rangef::new(frame.x(at), frame.x(at + 1.0));
        let bar = Rect::from_x_y_ranges(across, Rangef::new(top, bottom));
        mesh.add_colored_rect(bar, seen.palette.tone(tone));
    }
    let inside = frame.rect.expand(1.0).intersect(painter.clip_rect());
    painter.with_clip_rect(inside).add(Shape::mesh(mesh));
}
