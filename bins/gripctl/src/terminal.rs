//! Curves for a terminal, in Unicode's Braille patterns: two dots across and four down in each cell.

use core::ops::Range;

/// Cells across a plot, without the numbers beside it.
pub(crate) const COLUMNS: usize = 66;
/// Dots across.
const DOTS: usize = 2 * COLUMNS;
/// Width of the numbers beside a plot.
const MARGIN: usize = 9;

/// Bit of a Braille pattern for the dot in `[column][row]` of its cell.
const BITS: [[u32; 4]; 2] = [[0x01, 0x02, 0x04, 0x40], [0x08, 0x10, 0x20, 0x80]];

/// A curve over time.
#[derive(Debug)]
pub(crate) struct Plot<'a> {
    /// What it shows, with the unit.
    pub(crate) title: &'a str,
    /// Time (s) and value of each point, times rising.
    pub(crate) points: &'a [(f64, f64)],
    /// Times at the left and the right edge (s).
    pub(crate) time: Range<f64>,
    /// Cells down.
    pub(crate) rows: usize,
    /// A value that is marked by a dotted line.
    pub(crate) level: Option<f64>,
}

impl Plot<'_> {
    /// Its lines: the title, then the curve with its largest and its least value beside it. Each column of dots reaches from the lowest
    /// to the highest point in it, so that no peak is lost.
    pub(crate) fn lines(&self) -> Vec<String> {
        let values = || self.points.iter().map(|&(_, y)| y).chain(self.level);
        let (low, high) = (values().fold(f64::MAX, f64::min), values().fold(f64::MIN, f64::max));
        let mut cells = vec![vec![0_u32; COLUMNS]; self.rows];
        let height = 4 * self.rows;
        let row = |y: f64| dot(if high > low { (high - y) / (high - low) } else { 0.5 }, height);
        let mut draw = |column: usize, row: usize| {
            let cell = cells.get_mut(row / 4).and_then(|line| line.get_mut(column / 2));
            let bit = BITS.get(column % 2).and_then(|bits| bits.get(row % 4));
            if let (Some(cell), Some(bit)) = (cell, bit) {
                *cell |= bit;
            }
        };
        if let Some(level) = self.level {
            (0..DOTS).step_by(4).for_each(|column| draw(column, row(level)));
        }
        let mut before = None;
        for &(t, y) in self.points {
            let column = dot((t - self.time.start) / (self.time.end - self.time.start), DOTS);
            let at = row(y);
            let from = before.unwrap_or(at);
            (from.min(at)..=from.max(at)).for_each(|row| draw(column, row));
            before = Some(at);
        }
        let mut lines = vec![format!("{:MARGIN$} {}", "", self.title)];
        for (number, line) in cells.iter().enumerate() {
            let beside = match number {
                0 => short(high),
                _ if number + 1 == self.rows => short(low),
                _ => String::new(),
            };
            let dots: String =
                line.iter().filter_map(|bits| char::from_u32(0x2800 + bits)).collect();
            lines.push(format!("{beside:>MARGIN$} {dots}"));
        }
        lines
    }
}

/// An axis of seconds with a number at every whole `step`, and above it an arrow at each of `marks`.
pub(crate) fn time_axis(time: &Range<f64>, step: f64, marks: &[f64]) -> [String; 2] {
    let column = |t: f64| dot((t - time.start) / (time.end - time.start), COLUMNS);
    let mut arrows = vec![' '; COLUMNS];
    for &mark in marks {
        if let Some(cell) = arrows.get_mut(column(mark)) {
            *cell = '^';
        }
    }
    let mut numbers = String::new();
    let mut t = time.start;
    while t <= time.end {
        let text = format!("{t:.1}");
        let gap = column(t).saturating_sub(numbers.len());
        numbers.push_str(&" ".repeat(gap));
        numbers.push_str(&text);
        t += step;
    }
    let left = " ".repeat(MARGIN + 1);
    [format!("{left}{}", arrows.into_iter().collect::<String>()), format!("{left}{numbers} s")]
        .map(|line| line.trim_end().to_owned())
}

/// The dot of a share of 0 to 1, of so many.
fn dot(share: f64, count: usize) -> usize {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a share of some hundred dots"
    )]
    let dot = (share.clamp(0.0, 1.0) * count as f64) as usize;
    dot.min(count.saturating_sub(1))
}

/// A number of few digits.
fn short(value: f64) -> String {
    if value.abs() < 0.005 {
        return "0".to_owned();
    }
    let digits = if value.abs() < 10.0 { 2 } else { 0 };
    format!("{value:.digits$}")
}

#[cfg(test)]
mod tests {
    use super::{COLUMNS, Plot, time_axis};

    fn plot(points: &[(f64, f64)], rows: usize, level: Option<f64>) -> Vec<String> {
        Plot { title: "t", points, time: 0.0..1.0, rows, level }.lines()
    }

    #[test]
    fn a_peak_of_one_point_reaches_the_top_and_numbers_stand_at_the_edges() {
        let mut points: Vec<(f64, f64)> = (0..1000).map(|n| (f64::from(n) / 1e3, 0.0)).collect();
        points[500].1 = 12.0;
        let lines = plot(&points, 3, None);
        assert_eq!(lines.len(), 4);
        let middle = 10 + COLUMNS / 2;
        assert_ne!(lines[1].chars().nth(middle), Some('\u{2800}'), "{}", lines[1]);
        assert_eq!(lines[1].matches('\u{2800}').count(), COLUMNS - 1);
        assert!(lines[1].starts_with("       12 ") && lines[3].starts_with("        0 "));
        assert_eq!(lines[3].matches('\u{2800}').count(), 0, "the curve is drawn everywhere");
    }

    #[test]
    fn a_flat_curve_and_one_without_points_are_drawn() {
        assert!(plot(&[(0.0, 3.0), (0.9, 3.0)], 1, None)[1].starts_with("     3.00 "));
        assert_eq!(plot(&[], 2, Some(1.0)).len(), 3);
    }

    #[test]
    fn marks_stand_above_their_time() {
        let [marks, numbers] = time_axis(&(0.0..2.0), 1.0, &[1.0]);
        assert_eq!(marks.find('^'), numbers.find("1.0"));
        assert!(numbers.ends_with("2.0 s"));
    }
}
