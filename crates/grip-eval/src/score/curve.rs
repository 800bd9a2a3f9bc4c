//! False alarms, misses and latency at every threshold, from the statistic of each recording.
//!
//! At `threshold` h an alarm is a statistic above h times the configured threshold. 1 is the working point. What a recording does after its first alarm counts only in rest, where the alarms of
//! one stretch are those that lie more than [`APART_S`] apart.

use super::{LATE_S, Quantiles};
use grip_record::LabelKind;
use serde::Serialize;

/// Alarms in rest that lie closer together are one (s).
pub const APART_S: f64 = 0.05;

/// What one recording showed: all a curve needs to know of it.
#[derive(Clone, Debug)]
pub(super) struct Trace {
    /// Each time (s) at which the statistic rose above all values before it, with that value.
    pub(super) records: Vec<(f64, f32)>,
    /// The same for the time from onset - guard on.
    pub(super) late_records: Vec<(f64, f32)>,
    /// Highest statistic of the [`APART_S`] before onset - guard: above a threshold, an alarm went on there.
    before: f32,
    /// Highest statistic of each [`APART_S`] of labelled rest.
    pub(super) rest_blocks: Vec<f32>,
    pub(super) onset_s: Option<f64>,
    /// Labelled rest (s).
    pub(super) rest_s: f64,
}

impl Trace {
    pub(super) fn new(kind: LabelKind, rest_until_s: f64, statistics: &[(f64, f32)]) -> Self {
        let onset_s = match kind {
            LabelKind::Onset { at } => Some(at.as_seconds()),
            LabelKind::Steady | LabelKind::Rest => None,
        };
        let first = statistics.first().map_or(0.0, |s| s.0);
        let last = statistics.last().map_or(0.0, |s| s.0);
        let rest_s = (rest_until_s.min(last) - first).max(0.0);
        let mut rest_blocks: Vec<f32> = Vec::new();
        let mut block_end = f64::NEG_INFINITY;
        for &(t, statistic) in statistics.iter().take_while(|s| s.0 < rest_until_s) {
            if t >= block_end {
                rest_blocks.push(0.0);
                block_end = t + APART_S;
            }
            if let Some(block) = rest_blocks.last_mut() {
                *block = block.max(statistic);
            }
        }
        let late = statistics.iter().filter(|s| s.0 >= rest_until_s);
        Self {
            records: records(statistics.iter()),
            late_records: records(late),
            before: 0.0,
            rest_blocks,
            onset_s,
            rest_s,
        }
    }

    /// The same with what was shown right before onset - guard.
    pub(super) fn with_before(self, statistics: &[(f64, f32)]) -> Self {
        let before = statistics.iter().map(|(_, statistic)| *statistic).fold(0.0, f32::max);
        Self { before, ..self }
    }

    fn first_above(records: &[(f64, f32)], threshold: f32) -> Option<f64> {
        records.iter().find(|record| record.1 > threshold).map(|record| record.0)
    }

    /// Stretches of rest above the threshold.
    fn false_alarms(&self, threshold: f32) -> u32 {
        let mut alarms = 0;
        let mut above = false;
        for &block in &self.rest_blocks {
            alarms += u32::from(block > threshold && !above);
            above = block > threshold;
        }
        alarms
    }
}

fn records<'a>(statistics: impl Iterator<Item = &'a (f64, f32)>) -> Vec<(f64, f32)> {
    let mut highest = 0.0;
    let rising = statistics.filter(|(_, statistic)| {
        let rises = *statistic > highest;
        highest = f32::max(highest, *statistic);
        rises
    });
    rising.copied().collect()
}

/// A detector at one threshold.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Point {
    /// Threshold over the configured one.
    pub threshold: f32,
    /// False alarms in labelled rest.
    pub false_alarms: u32,
    /// Labelled rest (s).
    pub rest_s: f64,
    /// The same per hour; `null` without rest.
    pub false_per_hour: Option<f64>,
    /// Onsets in all.
    pub onsets: usize,
    /// Of these without an alarm from onset - guard to [`LATE_S`] after.
    pub missed: usize,
    /// Onsets with an alarm in the [`APART_S`] before onset - guard, which goes on: neither found nor missed.
    pub inside: usize,
    /// Latency of the others, from the onset.
    pub latency_ms: Quantiles,
    /// Recordings that slip all the time.
    pub steady: usize,
    /// Of these without any alarm.
    pub steady_missed: usize,
}

/// 33 thresholds from 1/8 to 32 of the configured one, a quarter octave apart.
pub(super) fn curve(traces: &[Trace]) -> Vec<Point> {
    (0..33_i16).map(|i| point(traces, (0.25 * f32::from(i - 12)).exp2())).collect()
}

fn point(traces: &[Trace], threshold: f32) -> Point {
    let false_alarms = traces.iter().map(|trace| trace.false_alarms(threshold)).sum();
    let rest_s: f64 = traces.iter().map(|trace| trace.rest_s).sum::<f64>() + 0.0;
    let onsets = traces.iter().filter_map(|trace| Some((trace, trace.onset_s?)));
    let outside = onsets.clone().filter(|(trace, _)| trace.before <= threshold);
    let found: Vec<f64> = outside
        .clone()
        .filter_map(|(trace, onset_s)| {
            let alarm = Trace::first_above(&trace.late_records, threshold)?;
            (alarm <= onset_s + LATE_S).then_some(1e3 * (alarm - onset_s))
        })
        .collect();
    let never_rest = |trace: &&Trace| trace.onset_s.is_none() && trace.rest_s <= 0.0;
    let steady = traces.iter().filter(never_rest);
    let quiet = |trace: &&Trace| Trace::first_above(&trace.records, threshold).is_none();
    let (onsets, outside) = (onsets.count(), outside.count());
    Point {
        threshold,
        false_alarms,
        rest_s,
        false_per_hour: (rest_s > 0.0).then(|| f64::from(false_alarms) * 3600.0 / rest_s),
        onsets,
        missed: outside - found.len(),
        inside: onsets - outside,
        latency_ms: Quantiles::of(found),
        steady: steady.clone().count(),
        steady_missed: steady.filter(quiet).count(),
    }
}

#[cfg(test)]
mod tests {
    use super::{Trace, curve};
    use grip_record::LabelKind;
    use slip_core::units::Micros;

    /// A statistic that rises by 1 each millisecond from 100 ms on, after one lone 2 in the rest.
    fn statistics() -> Vec<(f64, f32)> {
        (0..200_u8)
            .map(|ms| {
                let ramp = f32::from(ms.saturating_sub(100));
                (1e-3 * f64::from(ms), if ms == 20 { 2.0 } else { ramp })
            })
            .collect()
    }

    #[test]
    fn a_higher_threshold_has_fewer_false_alarms_and_comes_later() {
        let kind = LabelKind::Onset { at: Micros(110_000) };
        let points = curve(&[Trace::new(kind, 0.05, &statistics())]);
        let at = |h: f32| points.iter().find(|point| point.threshold == h).unwrap();
        let (low, high, top) = (at(1.0), at(4.0), at(32.0));
        assert_eq!((low.false_alarms, high.false_alarms), (1, 0));
        assert!((low.latency_ms.p50.unwrap() + 8.0).abs() < 1e-6, "{low:?}");
        assert!((high.latency_ms.p50.unwrap() + 5.0).abs() < 1e-6, "{high:?}");
        assert_eq!((top.missed, top.onsets, at(1.0).missed), (0, 1, 0));
        assert!((low.rest_s - 0.05).abs() < 1e-9 && low.false_per_hour.unwrap() > 7e4);
        for pair in points.windows(2) {
            assert!(pair[1].false_alarms <= pair[0].false_alarms);
            assert!(pair[1].latency_ms.p50 >= pair[0].latency_ms.p50);
        }
    }

    #[test]
    fn steady_recordings_and_rest_count_apart() {
        let steady = Trace::new(LabelKind::Steady, f64::NEG_INFINITY, &statistics());
        let rest = Trace::new(LabelKind::Rest, f64::INFINITY, &statistics());
        let points = curve(&[steady, rest]);
        let top = points.last().unwrap();
        assert_eq!((top.steady, top.steady_missed, top.false_alarms), (1, 0, 1), "{top:?}");
    }
}
