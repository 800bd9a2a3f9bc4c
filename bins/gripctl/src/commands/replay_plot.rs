//! Chart of the samples and steps of a replay: signal and statistic with the slips shaded.

use grip_plot::{Axis, Chart, Layer, Mark};
use slip_core::{Phase, Sample, SlipReport, Step};

/// Stretches of the lines, at most; some for each column of the picture.
const POINTS: usize = 4096;
/// A logarithmic axis has no place for 0, and nothing is to be seen below, or above.
const LEAST: f64 = 0.01;
const MOST: f64 = 1e9;

/// What is drawn of equal stretches, which grow with the recording.
#[derive(Debug, Default)]
pub(super) struct Picture {
    stretches: Vec<Stretch>,
    /// Steps in a stretch but for the first `1 <<`, and in the last one so far.
    doubled: u32,
    last: usize,
    /// Where each slip begins and, once it has, ends.
    slips: Vec<(f64, Option<f64>)>,
}

/// Some steps that follow each other.
#[derive(Clone, Copy, Debug)]
struct Stretch {
    t_s: f64,
    /// Highest statistic.
    statistic: f64,
    /// Lowest and highest reading; infinite where none was a number.
    signal: [f64; 2],
}

impl Stretch {
    fn joined(self, other: Self) -> Self {
        let [low, high] = self.signal;
        Self {
            t_s: self.t_s,
            statistic: self.statistic.max(other.statistic),
            signal: [low.min(other.signal[0]), high.max(other.signal[1])],
        }
    }
}

impl Picture {
    pub(super) fn take(&mut self, sample: &Sample, step: &Step) {
        let t_s = step.t.as_seconds();
        let stylus = f64::from(sample.stylus);
        let signal =
            if stylus.is_finite() { [stylus; 2] } else { [f64::INFINITY, f64::NEG_INFINITY] };
        self.push(Stretch { t_s, statistic: shown(f64::from(step.statistic)), signal });
        match (step.event, self.slips.last_mut()) {
            (Some(SlipReport { phase: Phase::Ended, .. }), Some((_, end @ None))) => {
                *end = Some(t_s);
            }
            (Some(SlipReport { first: true, .. }), _) => self.slips.push((t_s, None)),
            _ => {}
        }
    }

    fn push(&mut self, new: Stretch) {
        match self.stretches.last_mut().filter(|_| self.last < 1 << self.doubled) {
            Some(last) => (*last, self.last) = (last.joined(new), self.last + 1),
            None => {
                // Two each become one where there are too many.
                if self.stretches.len() >= POINTS {
                    let pairs = self.stretches.chunks(2);
                    let joined =
                        pairs.filter_map(|pair| pair.iter().copied().reduce(Stretch::joined));
                    self.stretches = joined.collect();
                    self.doubled += 1;
                }
                self.stretches.push(new);
                self.last = 1;
            }
        }
    }

    /// The picture of the recording `name`, whose readings are of `signal`, named with its unit.
    pub(super) fn chart(self, name: &str, signal: Option<&str>) -> Chart {
        let ends = [self.stretches.first(), self.stretches.last()].into_iter().flatten();
        let threshold: Vec<_> = ends.map(|stretch| (stretch.t_s, 1.0)).collect();
        let end = self.stretches.last().map_or(0.0, |stretch| stretch.t_s);
        let slips = self.slips.len();
        let title = format!("{name}: {slips} slip{}", if slips == 1 { "" } else { "s" });
        let time = || Axis::linear("time (s)");
        let statistic = self.stretches.iter().map(|stretch| (stretch.t_s, stretch.statistic));
        let evidence = Chart::new("", time(), Axis::log("evidence (1: a slip)"))
            .with(Layer::line("statistic", statistic.collect()))
            .with(Layer::line("threshold", threshold).drawn_as(Mark::DashedLine));
        let readings = self.stretches.iter().filter(|stretch| stretch.signal[0].is_finite());
        let readings: Vec<_> =
            readings.flat_map(|stretch| stretch.signal.map(|value| (stretch.t_s, value))).collect();
        let spans = self.slips.iter().map(|(from, to)| (*from, to.unwrap_or(end))).collect();
        let Some(signal) = signal.filter(|_| !readings.is_empty()) else {
            return Chart { title, ..evidence }.shaded(spans);
        };
        let signal = Chart::new(title, time(), Axis::linear(signal));
        signal.with(Layer::line("signal", readings)).above(evidence).shaded(spans)
    }
}

/// A level that has a place on the axis.
fn shown(level: f64) -> f64 {
    if level.is_nan() { LEAST } else { level.clamp(LEAST, MOST) }
}

#[cfg(test)]
mod tests {
    use super::{POINTS, Picture, Stretch};

    #[test]
    fn a_long_recording_keeps_its_highest_statistic_in_so_many_points() {
        let mut picture = Picture::default();
        for at in 0..1_000_000_u32 {
            let statistic = if at == 777_777 { 55.0 } else { 0.1 };
            let reading = if at == 123_456 { -3.0 } else { f64::from(at % 2) };
            picture.push(Stretch { t_s: 1e-4 * f64::from(at), statistic, signal: [reading; 2] });
        }
        let stretches = &picture.stretches;
        assert!((POINTS / 2..=POINTS).contains(&stretches.len()), "{}", stretches.len());
        let loud: Vec<_> = stretches.iter().filter(|stretch| stretch.statistic > 1.0).collect();
        assert!(loud.len() == 1 && loud[0].statistic == 55.0, "{loud:?}");
        assert!((77.74..=77.7777).contains(&loud[0].t_s), "{loud:?}");
        let low: Vec<_> = stretches.iter().filter(|stretch| stretch.signal[0] < 0.0).collect();
        assert!(low.len() == 1 && low[0].signal == [-3.0, 1.0], "{low:?}");
        assert!(stretches.windows(2).all(|pair| pair[0].t_s < pair[1].t_s));
    }
}
