//! Columns of lowest and highest values in; one mesh out, a ribbon that holds every sample.
//!
//! Dense curves are not drawn as lines: a column of pixels that holds thousands of samples is a bar from the lowest to the highest, stretched to touch its
//! neighbours, so that a spike of one sample is a bar of its own. Edges fade over one pixel. Four corners a column: the cost depends on the width of the
//! window only.

use super::pen::{Pen, column};
use super::{Frame, Style};
use eframe::egui::{Color32, Mesh, Rangef};
use grip_scope::Bucket;

/// Adds the ribbon of the buckets to a mesh.
pub fn ribbon(mesh: &mut Mesh, frame: &Frame, buckets: &[Bucket], colour: Color32, style: Style) {
    let dashes_from = (style == Style::Dashed).then_some(frame.rect.left());
    let mut pen = Pen::new(mesh, colour, dashes_from);
    let mut before: Option<End> = None;
    for bucket in buckets {
        if bucket.count == 0 || bucket.min > bucket.max || bucket.min.is_nan() {
            end(&mut pen, before.take());
            continue;
        }
        let x = frame.x(f64::midpoint(bucket.from_s, bucket.to_s));
        let edges = Rangef::new(edge(frame, bucket.max), edge(frame, bucket.min));
        let width = frame.x(bucket.to_s) - frame.x(bucket.from_s);
        let half = if width > 0.0 { width.max(1.0) / 2.0 } else { 0.0 };
        match before.take() {
            Some(last) if !bucket.broken => {
                // Touch the column before: a jump between two columns is a bar as well.
                let Rangef { min: above, max: below } = last.edges;
                pen.on(x, Rangef::new(edges.min.min(below), edges.max.max(above)));
            }
            other => {
                // A stretch has all of its first and last column, however short it is.
                end(&mut pen, other);
                pen.begin(x - half, edges);
                pen.on(x, edges);
            }
        }
        before = Some(End { x: x + half, edges });
    }
    end(&mut pen, before);
}

/// Where the stretch that is being drawn would end.
#[derive(Clone, Copy)]
struct End {
    x: f32,
    /// Top and bottom of its last column.
    edges: Rangef,
}

/// The right half of a stretch's last column.
fn end(pen: &mut Pen<'_>, stretch: Option<End>) {
    if let Some(End { x, edges }) = stretch {
        pen.on(x, edges);
    }
}

/// Adds the area between two curves, given as columns of the same times, to a mesh: the lowest of the one to the highest of the other, where
/// both have samples.
pub fn band(mesh: &mut Mesh, frame: &Frame, low: &[Bucket], high: &[Bucket], colour: Color32) {
    let (mut low, mut high) = (low.iter().peekable(), high.iter().peekable());
    let mut joined = false;
    while let (Some(&below), Some(&above)) = (low.peek(), high.peek()) {
        let x_s = f64::midpoint(below.from_s, below.to_s);
        // Columns without samples are left out of each list for itself.
        let alone = if above.from_s > x_s {
            low.next()
        } else if above.to_s <= x_s {
            high.next()
        } else {
            low.next();
            high.next();
            None
        };
        if let Some(alone) = alone {
            joined &= !alone.broken;
            continue;
        }
        if below.count == 0 || above.count == 0 || below.min > above.max {
            joined = false;
            continue;
        }
        let edges = Rangef::new(edge(frame, above.max), edge(frame, below.min));
        let joins = joined && !below.broken && !above.broken;
        column(mesh, frame.x(x_s), edges, colour, joins);
        joined = true;
    }
}

fn edge(frame: &Frame, value: f32) -> f32 {
    frame.y(f64::from(value)).clamp(frame.rect.top() - 4.0, frame.rect.bottom() + 4.0)
}

#[cfg(test)]
mod tests {
    use super::{Frame, band, ribbon};
    use crate::plot::{Kind, Scale, Style};
    use eframe::egui::{Color32, Mesh, Rect, epaint::Vertex, pos2};
    use grip_scope::{Bucket, Span};

    fn frame() -> Frame {
        let rect = Rect::from_min_max(pos2(0.0, 0.0), pos2(100.0, 100.0));
        let span = Span { from_s: 0.0, to_s: 1.0 };
        Frame { rect, span, scale: Scale::new(Kind::Linear, 0.0, 1.0) }
    }

    fn buckets(values: &[(f32, f32)]) -> Vec<Bucket> {
        let width = 1.0 / values.len() as f64;
        let at = |i: usize| i as f64 * width;
        let bucket = |(i, &(min, max)): (usize, &(f32, f32))| Bucket {
            from_s: at(i),
            to_s: at(i + 1),
            min,
            max,
            mean: f32::midpoint(min, max),
            count: u32::from(min.is_finite()).into(),
            broken: false,
        };
        values.iter().enumerate().map(bucket).collect()
    }

    fn covers(mesh: &Mesh, y: f32) -> bool {
        mesh.vertices.iter().any(|v| (v.pos.y - y).abs() < 1.0 && v.color != Color32::TRANSPARENT)
    }

    #[test]
    fn a_spike_of_one_column_reaches_its_height() {
        let mut values = vec![(0.1, 0.1); 50];
        values[20] = (0.1, 0.9);
        let mut mesh = Mesh::default();
        ribbon(&mut mesh, &frame(), &buckets(&values), Color32::WHITE, Style::Solid);
        assert!(mesh.is_valid() && covers(&mesh, 10.0));
    }

    #[test]
    fn neighbours_touch_and_gaps_stay_open() {
        let mut mesh = Mesh::default();
        ribbon(
            &mut mesh,
            &frame(),
            &buckets(&[(0.1, 0.2), (0.7, 0.8)]),
            Color32::WHITE,
            Style::Solid,
        );
        let joined = mesh.indices.len();
        // The second column reaches down to the first one's top.
        assert!(covers(&mesh, 80.0));
        let mut gap = Mesh::default();
        let values = [(0.1, 0.2), (f32::NAN, f32::NAN), (0.7, 0.8)];
        ribbon(&mut gap, &frame(), &buckets(&values), Color32::WHITE, Style::Solid);
        assert!(gap.is_valid() && gap.indices.len() == 36 && joined == 54);
        assert!(
            gap.indices
                .chunks(18)
                .all(|part| part.iter().all(|i| *i < 8) || part.iter().all(|i| *i >= 8))
        );
    }

    /// Whether full colour lies on this place: within a triangle all of whose corners have it.
    fn paints(mesh: &Mesh, x: f32, y: f32) -> bool {
        mesh.indices.chunks_exact(3).any(|three| {
            let [a, b, c] = [0, 1, 2].map(|k| mesh.vertices[three[k] as usize]);
            let side = |p: Vertex, q: Vertex| {
                (q.pos.x - p.pos.x) * (y - p.pos.y) - (q.pos.y - p.pos.y) * (x - p.pos.x)
            };
            let sides = [side(a, b), side(b, c), side(c, a)];
            let inside = sides.iter().all(|s| *s >= 0.0) || sides.iter().all(|s| *s <= 0.0);
            inside && [a, b, c].iter().all(|v| v.color == Color32::WHITE)
        })
    }

    #[test]
    fn a_level_stretch_costs_two_columns_and_is_as_long_as_it_was() {
        let mut values = vec![(0.5, 0.5); 100];
        values[60] = (0.5, 0.9);
        let mut mesh = Mesh::default();
        ribbon(&mut mesh, &frame(), &buckets(&values), Color32::WHITE, Style::Solid);
        assert!(mesh.is_valid() && mesh.vertices.len() < 4 * 12, "{}", mesh.vertices.len());
        for x in [0.1, 30.2, 57.7, 62.3, 80.0, 99.9] {
            assert!(paints(&mesh, x, 50.0) && !paints(&mesh, x, 40.0), "{x}");
        }
        assert!(paints(&mesh, 60.5, 12.0));
        // A gap is not bridged.
        let mut gap = buckets(&[(0.5, 0.5); 100]);
        gap[50].broken = true;
        gap.remove(49);
        let mut mesh = Mesh::default();
        ribbon(&mut mesh, &frame(), &gap, Color32::WHITE, Style::Solid);
        assert!(
            !paints(&mesh, 49.5, 50.0) && paints(&mesh, 48.5, 50.0) && paints(&mesh, 50.5, 50.0)
        );
    }

    #[test]
    fn a_column_between_gaps_covers_both_halves_of_its_pixel() {
        // Fifty columns of two points each: gaps as columns without samples, and as breaks between neighbours.
        let mut breaks = buckets(&[(0.4, 0.6); 50]);
        breaks.iter_mut().for_each(|bucket| bucket.broken = true);
        let holes: Vec<_> =
            (0..50).map(|i| if i % 2 == 0 { (0.4, 0.6) } else { (f32::NAN, f32::NAN) }).collect();
        for (columns, step) in [(breaks, 1), (buckets(&holes), 2)] {
            let mut mesh = Mesh::default();
            ribbon(&mut mesh, &frame(), &columns, Color32::WHITE, Style::Solid);
            assert!(mesh.is_valid());
            for column in (0..50).step_by(step) {
                let centre = 2.0 * column as f32 + 1.0;
                for x in [centre - 0.9, centre, centre + 0.9] {
                    assert!(paints(&mesh, x, 50.0), "column {column} at {x}");
                }
                assert_eq!(paints(&mesh, centre + 1.5, 50.0), step == 1 && column < 49);
            }
        }
    }

    #[test]
    fn dashes_stand_still_while_the_columns_under_them_move() {
        for shift in 0..6_u8 {
            let mut columns = buckets(&[(0.5, 0.5); 50]);
            for bucket in &mut columns {
                bucket.from_s -= f64::from(shift) * 0.003;
                bucket.to_s -= f64::from(shift) * 0.003;
            }
            let mut mesh = Mesh::default();
            ribbon(&mut mesh, &frame(), &columns, Color32::WHITE, Style::Dashed);
            assert!(mesh.is_valid() && mesh.vertices.len() <= 12 * 12);
            for dash in 0..10_u8 {
                let left = 9.0 * f32::from(dash);
                let painted = |x: f32| paints(&mesh, left + x, 50.0);
                assert!([0.1, 2.5, 4.9].into_iter().all(painted), "dash {dash}, {shift}");
                assert!(![5.1, 7.0, 8.9].into_iter().any(painted), "dash {dash}, {shift}");
            }
        }
    }

    #[test]
    fn an_area_has_the_ends_of_one_time_though_columns_are_left_out() {
        let values: Vec<(f32, f32)> =
            (0..50_u8).map(|k| f32::from(k) / 100.0).map(|v| (v, v)).collect();
        let mut low = buckets(&values);
        let mut high = buckets(&values.iter().map(|v| (v.0 + 0.3, v.1 + 0.3)).collect::<Vec<_>>());
        low.remove(20);
        high.remove(30);
        high.remove(30);
        let mut mesh = Mesh::default();
        band(&mut mesh, &frame(), &low, &high, Color32::WHITE);
        assert_eq!(mesh.vertices.len(), 4 * 47);
        for corners in mesh.vertices.chunks_exact(4) {
            let (top, bottom) = (corners[1].pos.y, corners[2].pos.y);
            assert!((bottom - top - 31.2).abs() < 0.01, "{} {top} {bottom}", corners[0].pos.x);
        }
        // A lone column that does not join the one before it interrupts the area.
        high[20].broken = true;
        let mut cut = Mesh::default();
        band(&mut cut, &frame(), &low, &high, Color32::WHITE);
        assert_eq!(mesh.indices.len() - cut.indices.len(), 18);
    }

    #[test]
    fn wild_values_stay_in_the_window() {
        let mut mesh = Mesh::default();
        let values = buckets(&[(-1e30, 1e30), (f32::NEG_INFINITY, f32::INFINITY), (0.5, 0.4)]);
        ribbon(&mut mesh, &frame(), &values, Color32::WHITE, Style::Solid);
        band(&mut mesh, &frame(), &values, &values, Color32::WHITE);
        assert!(mesh.vertices.iter().all(|v| v.pos.y.abs() < 200.0));
    }
}
