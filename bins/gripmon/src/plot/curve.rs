//! Curves and areas of a plot, from at most two points a column of pixels.

use super::Frame;
use eframe::egui::{Color32, Stroke};
use egui_plot::{FilledArea, Line, LineStyle, PlotPoint, PlotPoints, PlotUi, Points};
use grip_scope::Bucket;

/// Points on the line are shown where they are at least so far apart (points of the window).
const DOTS_FROM: f32 = 7.0;

/// How limits and thresholds are drawn.
pub const DASHED: LineStyle = LineStyle::Dashed { length: 5.0 };

/// Adds points `[t_s, value]` in rising time as a line; a value that is not finite interrupts it.
pub fn line(plot: &mut PlotUi<'_>, frame: &Frame, points: &[[f64; 2]], look: (Color32, LineStyle)) {
    let (colour, style) = look;
    let placed = |[t_s, value]: &[f64; 2]| PlotPoint::new(*t_s, frame.scale.drawn(*value));
    let is_open = |at: Option<&[f64; 2]>| at.is_none_or(|[_, value]| !value.is_finite());
    let apart =
        2.0 * frame.rect.width() / crate::num::narrow(crate::num::count(points.len().max(1)));
    let dotted = style == LineStyle::Solid && apart > 2.0 * DOTS_FROM;
    let shown = |k: usize| {
        let alone =
            is_open(k.checked_sub(1).and_then(|k| points.get(k))) && is_open(points.get(k + 1));
        (dotted || alone) && !is_open(points.get(k))
    };
    let dots: Vec<PlotPoint> = points
        .iter()
        .enumerate()
        .filter(|(k, _)| shown(*k))
        .map(|(_, point)| placed(point))
        .collect();
    // Dashes go over whole stretches: of pieces as short as a column only faded ends would be seen.
    let inside = |k: usize| {
        let value = |k: usize| points.get(k).map(|[_, value]| *value);
        k > 0 && value(k - 1) == value(k) && value(k) == value(k + 1)
    };
    let all = points.iter().enumerate().filter(|(k, _)| style == LineStyle::Solid || !inside(*k));
    let all: Vec<PlotPoint> = all.map(|(_, point)| placed(point)).collect();
    let stroke = Stroke::new(1.3, colour);
    let line = Line::new("", PlotPoints::Owned(all)).stroke(stroke).style(style);
    // Few points are joined exactly; a band a pixel wide stands for many.
    let many = crate::num::count(points.len()) > f64::from(frame.rect.width());
    plot.line(line.allow_band(many).allow_hover(false));
    if !dots.is_empty() {
        let dots = Points::new("", PlotPoints::Owned(dots)).radius(1.9).color(colour);
        plot.points(dots.allow_hover(false));
    }
}

/// The points of a line through the lowest and the highest value of each column, so that a spike of one sample is a bar of its own; NaN
/// where samples are missing for a column or more: shorter gaps cannot be seen.
#[must_use]
pub fn runs(buckets: &[Bucket]) -> Vec<[f64; 2]> {
    let mut points = Vec::with_capacity(2 * buckets.len());
    let mut end_s = f64::NEG_INFINITY;
    for bucket in buckets {
        let quarter_s = (bucket.to_s - bucket.from_s) / 4.0;
        if bucket.count == 0 || (bucket.broken && bucket.from_s > end_s + quarter_s) {
            points.push([bucket.from_s, f64::NAN]);
        }
        if bucket.count > 0 && bucket.min <= bucket.max {
            points.push([bucket.from_s + quarter_s, bucket.min.into()]);
            points.push([bucket.to_s - quarter_s, bucket.max.into()]);
        }
        end_s = bucket.to_s;
    }
    points
}

/// Adds the area between two curves, given as columns of the same times: the lowest of the one to the highest of the other, where both have
/// samples.
pub fn area(plot: &mut PlotUi<'_>, frame: &Frame, [low, high]: [&[Bucket]; 2], colour: Color32) {
    for [times, lows, highs] in stretches(low, high) {
        let drawn = |values: &[f64]| -> Vec<f64> {
            values.iter().map(|value| frame.scale.drawn(*value)).collect()
        };
        let area = FilledArea::new("", &times, &drawn(&lows), &drawn(&highs));
        plot.add(area.fill_color(colour).allow_hover(false));
    }
}

/// Times, lowest and highest values of each stretch without a gap.
fn stretches(low: &[Bucket], high: &[Bucket]) -> Vec<[Vec<f64>; 3]> {
    let mut stretches: Vec<[Vec<f64>; 3]> = Vec::new();
    let mut above = high.iter().peekable();
    let mut joined = false;
    for below in low {
        while let Some(alone) = above.next_if(|above| above.from_s < below.from_s) {
            joined &= !alone.broken;
        }
        let both = above.next_if(|above| above.from_s <= below.from_s);
        joined &= !below.broken && both.is_none_or(|above| !above.broken);
        let known =
            both.filter(|above| above.count > 0 && below.count > 0 && below.min <= above.max);
        let Some(above) = known else {
            joined &= both.is_none();
            continue;
        };
        if !joined {
            stretches.push([const { Vec::new() }; 3]);
        }
        if let Some([times, lows, highs]) = stretches.last_mut() {
            times.push(f64::midpoint(below.from_s, below.to_s));
            lows.push(below.min.into());
            highs.push(above.max.into());
        }
        joined = true;
    }
    stretches
}

#[cfg(test)]
mod tests {
    use super::{runs, stretches};
    use grip_scope::Bucket;

    fn buckets(values: &[(f32, f32)]) -> Vec<Bucket> {
        let bucket = |(i, &(min, max)): (u8, &(f32, f32))| Bucket {
            from_s: f64::from(i),
            to_s: f64::from(i) + 1.0,
            min,
            max,
            count: u32::from(min.is_finite()).into(),
            broken: false,
        };
        (0..).zip(values).map(bucket).collect()
    }

    #[test]
    fn a_column_shows_its_lowest_and_highest_and_gaps_stay_open() {
        let gap = (f32::NAN, f32::NAN);
        let values = [(0.1, 0.2), gap, (0.7, 0.8), (0.7, 9.0), (0.1, 0.2), (0.1, 0.2)];
        let mut columns = buckets(&values);
        columns.iter_mut().skip(3).for_each(|column| column.broken = true);
        columns.remove(4);
        let points = runs(&columns);
        let open: Vec<f64> = points.iter().filter(|p| p[1].is_nan()).map(|p| p[0]).collect();
        // Within a column and the next a gap cannot be seen; a column without samples is one.
        assert_eq!(open, [1.0, 5.0]);
        assert!(points.iter().any(|[_, value]| (value - 9.0).abs() < 1e-6));
        assert!(points.is_sorted_by(|a, b| a[0] <= b[0]));
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
        let found = stretches(&low, &high);
        let [[times, lows, highs]] = found.as_slice() else { panic!("{found:?}") };
        assert_eq!((times.len(), times[0]), (47, 0.5));
        assert!(lows.iter().zip(highs).all(|(low, high)| (high - low - 0.3).abs() < 1e-6));
        // A lone column that does not join the one before it interrupts the area.
        high[20].broken = true;
        assert_eq!(stretches(&low, &high).len(), 2);
    }
}
