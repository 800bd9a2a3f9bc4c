//! The steps of a replay in; a picture of the statistic with its slips out.

use grip_plot::{Axis, Chart, Layer, Mark};
use slip_core::{SlipReport, Step};

/// Points of the line, at most; some for each column of the picture.
const POINTS: usize = 4096;
/// A logarithmic axis has no place for 0, and nothing is to be seen below, or above.
const LEAST: f64 = 0.01;
const MOST: f64 = 1e9;

/// What is drawn: the highest statistic of equal stretches, which grow with the recording.
#[derive(Debug)]
pub(super) struct Picture {
    points: Vec<(f64, f64)>,
    /// Steps in a stretch, and in the last one so far.
    stretch: usize,
    last: usize,
    slips: Vec<(f64, f64)>,
}

impl Picture {
    pub(super) fn new() -> Self {
        Self { points: Vec::new(), stretch: 1, last: 1, slips: Vec::new() }
    }

    pub(super) fn take(&mut self, step: &Step) {
        self.push(step.t.as_seconds(), f64::from(step.statistic));
        if let Some(SlipReport { first: true, t, statistic, .. }) = step.event {
            let level = f64::from(statistic.unwrap_or(1.0));
            self.slips.push((t.as_seconds(), shown(level).max(1.0)));
        }
    }

    fn push(&mut self, t_s: f64, level: f64) {
        let level = shown(level);
        match self.points.last_mut().filter(|_| self.last < self.stretch) {
            Some(point) => (point.1, self.last) = (point.1.max(level), self.last + 1),
            None => {
                self.halve();
                self.points.push((t_s, level));
                self.last = 1;
            }
        }
    }

    /// Joins two stretches each where there are too many.
    fn halve(&mut self) {
        if self.points.len() < POINTS {
            return;
        }
        let joined = self.points.chunks(2).filter_map(|pair| {
            let high = pair.iter().map(|point| point.1).reduce(f64::max)?;
            Some((pair.first()?.0, high))
        });
        self.points = joined.collect();
        self.stretch *= 2;
    }

    /// The picture of the recording `name`.
    pub(super) fn chart(self, name: &str) -> Chart {
        let ends = [self.points.first(), self.points.last()].into_iter().flatten();
        let threshold = ends.map(|(t_s, _)| (*t_s, 1.0)).collect();
        let slips = self.slips.len();
        let title = format!("{name}: {slips} slip{}", if slips == 1 { "" } else { "s" });
        let (x, y) = (Axis::linear("time (s)"), Axis::log("evidence over the wanted interval"));
        let mut chart = Chart::new(title, x, y)
            .with(Layer::line("statistic", self.points))
            .with(Layer::line("threshold", threshold).drawn_as(Mark::DashedLine));
        if slips > 0 {
            chart = chart.with(Layer::markers("slip", self.slips).drawn_as(Mark::TrianglesDown));
        }
        chart
    }
}

/// A level that has a place on the axis.
fn shown(level: f64) -> f64 {
    if level.is_nan() { LEAST } else { level.clamp(LEAST, MOST) }
}

#[cfg(test)]
mod tests {
    use super::{POINTS, Picture};

    #[test]
    fn a_long_recording_keeps_its_highest_statistic_in_so_many_points() {
        let mut picture = Picture::new();
        for at in 0..1_000_000_u32 {
            let statistic = if at == 777_777 { 55.0 } else { 0.1 };
            picture.push(1e-4 * f64::from(at), statistic);
        }
        assert!((POINTS / 2..=POINTS).contains(&picture.points.len()), "{}", picture.points.len());
        let (t_s, high) =
            picture.points.iter().copied().max_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
        assert!((high - 55.0).abs() < 1e-9 && (77.74..=77.7777).contains(&t_s), "{t_s} {high}");
        assert!(picture.points.windows(2).all(|pair| pair[0].0 < pair[1].0));
    }
}
