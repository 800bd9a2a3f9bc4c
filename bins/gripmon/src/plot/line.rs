//! Single samples in; a line with its points, or a level of dashes, out.

use super::{Frame, dash};
use eframe::egui::{Color32, Painter, Pos2, Rect, Shape, Stroke, vec2};

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
    colour: Color32,
    style: Style,
) {
    let mut part: Vec<Pos2> = Vec::with_capacity(samples.len());
    let apart =
        frame.rect.width() * 2.0 / crate::num::narrow(crate::num::count(samples.len().max(1)));
    for &[t_s, value] in samples {
        if !value.is_finite() {
            stretch(painter, frame.rect, &mut part, colour, style);
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
    stretch(painter, frame.rect, &mut part, colour, style);
}

fn stretch(painter: &Painter, plot: Rect, part: &mut Vec<Pos2>, colour: Color32, style: Style) {
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
            // A line for each dash: of pieces as short as the way between two samples only their faded ends would be seen.
            let stroke = Stroke::new(1.2, colour);
            painter.extend(
                dash::along(&points, plot).into_iter().map(|dash| Shape::line(dash, stroke)),
            );
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Frame, Style, polyline};
    use crate::plot::{Kind, Scale};
    use eframe::egui::{self, Color32, Rect, Shape, pos2};
    use grip_scope::Span;

    /// Lengths of the pieces that are drawn of a level curve of so many samples over 600 points.
    fn pieces(samples: u32) -> Vec<f32> {
        let rect = Rect::from_min_max(pos2(0.0, 0.0), pos2(600.0, 100.0));
        let span = Span { from_s: 0.0, to_s: 1.0 };
        let frame = Frame { rect, span, scale: Scale::new(Kind::Linear, 0.0, 1.0) };
        let curve: Vec<[f64; 2]> =
            (0..=samples).map(|k| [f64::from(k) / f64::from(samples), 0.5]).collect();
        let mut output = egui::Context::default().run_ui(egui::RawInput::default(), |ui| {
            let painter = ui.painter().with_clip_rect(rect);
            polyline(&painter, &frame, &curve, Color32::RED, Style::Dashed);
        });
        output.textures_delta.clear();
        let length = |shape: &Shape| match shape {
            Shape::Path(path) => Some(path.points[path.points.len() - 1].x - path.points[0].x),
            Shape::LineSegment { points, .. } => Some(points[1].x - points[0].x),
            _ => None,
        };
        output.shapes.iter().filter_map(|clipped| length(&clipped.shape)).collect()
    }

    #[test]
    fn dashes_are_whole_however_close_the_samples_are() {
        for samples in [1, 60, 400, 690] {
            let pieces = pieces(samples);
            let whole = pieces.iter().filter(|length| (**length - 5.0).abs() < 0.01).count();
            assert_eq!((pieces.len(), whole), (67, 66 + usize::from(pieces[66] > 4.99)));
        }
    }
}
