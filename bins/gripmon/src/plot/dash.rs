//! Places of a line in; which of them dashes cover out.
//!
//! Dashes stand still on the screen: they are counted from the left edge of the plot, wherever the samples under them are.

use eframe::egui::{Pos2, Rangef, Rect};

/// Length of a dash (points).
const DASH: f32 = 5.0;
/// From the start of a dash to the start of the next (points).
const STEP: f32 = 9.0;

/// The dashes of a plot whose left edge is at `left` that cover some of `across`, in order, each as far as it does.
pub(super) fn across(left: f32, across: Rangef) -> impl Iterator<Item = Rangef> {
    let first = left + ((across.min - left) / STEP).floor() * STEP;
    let starts = core::iter::successors(Some(first), |start| Some(start + STEP));
    let dashes = starts.take_while(move |start| *start < across.max);
    let covered = move |start: f32| Rangef::new(start, start + DASH).intersection(across);
    dashes.map(covered).filter(|dash| dash.min < dash.max)
}

/// The pieces of a line that its dashes cover, as long on a steep part as on a level one; what lies far above or below the plot is drawn
/// right beside it.
pub(super) fn along(line: &[Pos2], plot: Rect) -> Vec<Vec<Pos2>> {
    let near = |p: &Pos2| Pos2::new(p.x, p.y.clamp(plot.top() - STEP, plot.bottom() + STEP));
    let mut points = line.iter().map(near);
    let Some(mut last) = points.next() else { return Vec::new() };
    // How far into a dash and the space behind it the line is.
    let mut at = (last.x - plot.left()).rem_euclid(STEP);
    let (mut pieces, mut piece) = (Vec::new(), Vec::new());
    if at < DASH {
        piece.push(last);
    }
    for point in points {
        let length = last.distance(point);
        let mut done = if at < DASH { DASH - at } else { STEP - at };
        while length > 0.0 && done <= length {
            let border = last.lerp(point, done / length);
            if at < DASH {
                piece.push(border);
                pieces.push(core::mem::take(&mut piece));
                (at, done) = (DASH, done + STEP - DASH);
            } else {
                piece.push(border);
                (at, done) = (0.0, done + DASH);
            }
        }
        at = if at < DASH { DASH } else { STEP } - (done - length);
        if at < DASH && piece.last() != Some(&point) {
            piece.push(point);
        }
        last = point;
    }
    pieces.push(piece);
    pieces.retain(|piece| piece.len() > 1);
    pieces
}

#[cfg(test)]
mod tests {
    use super::{across, along};
    use eframe::egui::{Pos2, Rangef, Rect, pos2};

    fn plot() -> Rect {
        Rect::from_min_max(pos2(10.0, 0.0), pos2(110.0, 100.0))
    }

    #[test]
    fn dashes_are_counted_from_the_left_edge_whatever_is_asked_for() {
        let whole: Vec<Rangef> = across(10.0, Rangef::new(10.0, 40.0)).collect();
        let expected = [(10.0, 15.0), (19.0, 24.0), (28.0, 33.0), (37.0, 40.0)];
        assert_eq!(whole, expected.map(|(from, to)| Rangef::new(from, to)));
        let part: Vec<Rangef> = across(10.0, Rangef::new(12.5, 20.0)).collect();
        assert_eq!(part, [Rangef::new(12.5, 15.0), Rangef::new(19.0, 20.0)]);
        assert_eq!(across(10.0, Rangef::new(15.5, 18.5)).count(), 0);
        assert_eq!(across(10.0, Rangef::new(0.5, 1.5)).count(), 1);
    }

    #[test]
    fn a_dash_is_one_piece_however_close_its_points_are() {
        for step in [0.3, 1.0, 1.7, 4.0, 30.0, 100.0] {
            let points = core::iter::successors(Some(10.0_f32), |x| Some(x + step));
            let line: Vec<Pos2> =
                points.take_while(|x| *x < 110.5).map(|x| pos2(x, 50.0)).collect();
            let pieces = along(&line, plot());
            let length = line[line.len() - 1].x - 10.0;
            let expected = across(10.0, Rangef::new(10.0, 10.0 + length)).count();
            assert!(pieces.len().abs_diff(expected) <= 1, "{} at {step}", pieces.len());
            for (piece, k) in pieces.iter().zip(0_u8..) {
                let from = 10.0 + 9.0 * f32::from(k);
                let to = (from + 5.0).min(10.0 + length);
                let (first, last) = (piece[0].x, piece[piece.len() - 1].x);
                assert!((first - from).abs() < 0.01 && (last - to).abs() < 0.01, "{k} at {step}");
            }
        }
    }

    #[test]
    fn a_steep_part_has_as_many_dashes_as_it_is_long() {
        let steep = [pos2(10.0, 0.0), pos2(10.0, 90.0)];
        assert_eq!(along(&steep, plot()).len(), 10);
        let wild = [pos2(-1000.0, -1e9), pos2(20.0, 1e9), pos2(20.0, 1e9), pos2(1200.0, 50.0)];
        assert!(along(&wild, plot()).len() < 300);
        assert!(along(&[], plot()).is_empty());
    }
}
