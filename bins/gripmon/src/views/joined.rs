//! Stretches of time, however many, joined to as few rectangles across a plot as can be distinguished.

use crate::plot::Frame;
use eframe::egui::{Color32, Mesh, Painter, Rangef, Rect, Shape};
use grip_scope::model::Stretch;

/// What begins within so much of a narrow one is joined with it (points).
const NEAR: f32 = 2.0;

/// A stretch, or several that cannot be distinguished.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Piece<T> {
    /// From its left to its right edge (points).
    pub(super) across: Rangef,
    /// What it means: of joined ones the worst.
    pub(super) what: T,
}

/// The pieces of stretches in order of time, each at least a point wide where the plot goes on; `worst` decides between two. Pieces do not
/// overlap, and there are not more of them than the plot has points.
pub(super) fn joined<'a, T: Copy + 'a>(
    stretches: impl Iterator<Item = &'a Stretch<T>>,
    frame: &Frame,
    worst: impl Fn(T, T) -> T,
) -> Vec<Piece<T>> {
    let mut pieces: Vec<Piece<T>> = Vec::new();
    for Stretch { span, what } in stretches {
        let mut left = frame.x(span.from_s).max(frame.rect.left());
        let right = frame.x(span.to_s).max(left + 1.0).min(frame.rect.right());
        if let Some(last) = pieces.last_mut() {
            let narrow = right <= last.across.min + NEAR;
            if narrow && left < last.across.max {
                last.across.max = last.across.max.max(right);
                last.what = worst(last.what, *what);
                continue;
            }
            left = left.max(last.across.max);
        }
        if left < right {
            pieces.push(Piece { across: Rangef::new(left, right), what: *what });
        }
    }
    pieces
}

/// Draws rectangles of one height as one shape: each by itself costs ten times as much, most of it for edges that fade.
pub(super) fn fill(painter: &Painter, height: Rangef, of: impl Iterator<Item = (Rangef, Color32)>) {
    let mut mesh = Mesh::default();
    for (across, colour) in of {
        mesh.add_colored_rect(Rect::from_x_y_ranges(across, height), colour);
    }
    painter.add(Shape::mesh(mesh));
}

#[cfg(test)]
mod tests {
    use super::joined;
    use crate::plot::{Frame, Kind, Scale};
    use eframe::egui::{Rect, pos2};
    use grip_scope::Span;
    use grip_scope::model::Stretch;

    fn frame() -> Frame {
        let rect = Rect::from_min_max(pos2(10.0, 0.0), pos2(1010.0, 50.0));
        let span = Span { from_s: 0.0, to_s: 10.0 };
        Frame { rect, span, scale: Scale::new(Kind::Linear, 0.0, 1.0) }
    }

    fn stretch(from_s: f64, to_s: f64, what: u8) -> Stretch<u8> {
        Stretch { span: Span { from_s, to_s }, what }
    }

    #[test]
    fn stretches_that_can_be_told_apart_stay_as_they_are() {
        let all = [stretch(1.0, 2.0, 1), stretch(2.0, 3.0, 2), stretch(5.0, 5.0, 3)];
        let pieces = joined(all.iter(), &frame(), u8::max);
        let edges: Vec<(f32, f32, u8)> =
            pieces.iter().map(|p| (p.across.min, p.across.max, p.what)).collect();
        assert_eq!(edges, [(110.0, 210.0, 1), (210.0, 310.0, 2), (510.0, 511.0, 3)]);
    }

    #[test]
    fn a_hundred_thousand_are_as_few_as_the_plot_has_points_and_the_worst_is_reported() {
        let all: Vec<Stretch<u8>> = (0..100_000_u32)
            .map(|k| {
                let from_s = 1e-4 * f64::from(k);
                stretch(from_s, from_s + 2e-5, u8::from(k == 50_017))
            })
            .collect();
        let pieces = joined(all.iter(), &frame(), u8::max);
        assert!(pieces.len() <= 1001 && pieces.len() >= 400, "{}", pieces.len());
        assert!(pieces.windows(2).all(|two| two[0].across.max <= two[1].across.min));
        let worst: Vec<f32> =
            pieces.iter().filter(|piece| piece.what == 1).map(|piece| piece.across.min).collect();
        assert!(worst.len() == 1 && (worst[0] - 510.2).abs() < 2.1, "{worst:?}");
        // Where something stands everywhere, no hole is left.
        let covered: f32 = pieces.iter().map(|piece| piece.across.span()).sum();
        assert!(covered > 990.0, "{covered}");
    }
}
