//! Single samples in; a line with its points, or a level of dashes, out.

use super::Frame;
use eframe::egui::{Color32, Painter, Pos2, Shape, Stroke, vec2};

/// Points on the line are shown where they are at least so far apart (points of the window).
const DOTS_FROM: f32 = 7.0;

/// How a curve is drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Style {
    /// A line.
    #[default]
    Solid,
    /// Dashes: limits and thresholds.
    Dashed,
}

/// Draws samples `[t_s, value]` in rising time; what is not finite interrupts the line.
pub fn polyline(
    painter: &Painter,
    frame: &Frame,
    samples: &[[f64; 2]],
    (colour, style): (Color32, Style),
) {
    let mut part: Vec<Pos2> = Vec::with_capacity(samples.len());
    let apart =
        frame.rect.width() * 2.0 / crate::num::narrow(crate::num::count(samples.len().max(1)));
    for &[t_s, value] in samples {
        if !value.is_finite() {
            stretch(painter, &mut part, colour, style);
        } else {
            part.push(frame.at(t_s, value));
        }
    }
    if style == Style::Solid && apart > DOTS_FROM * 2.0 {
        let dots =
            samples.iter().filter(|[t_s, value]| value.is_finite() && frame.span.holds(*t_s));
        let dot =
            |&[t_s, value]: &[f64; 2]| Shape::circle_filled(frame.at(t_s, value), 1.9, colour);
        painter.extend(dots.map(dot).collect::<Vec<_>>());
    }
    stretch(painter, &mut part, colour, style);
}

fn stretch(painter: &Painter, part: &mut Vec<Pos2>, colour: Color32, style: Style) {
    let points = core::mem::take(part);
    match (points.as_slice(), style) {
        ([], _) => {}
        ([alone], _) => {
            painter.line_segment(
                [*alone - vec2(1.5, 0.0), *alone + vec2(1.5, 0.0)],
                Stroke::new(1.4, colour),
            );
        }
        (_, Style::Solid) => {
            painter.line(points, Stroke::new(1.3, colour));
        }
        (_, Style::Dashed) => {
            painter.extend(Shape::dashed_line(&points, Stroke::new(1.2, colour), 5.0, 4.0));
        }
    }
}
