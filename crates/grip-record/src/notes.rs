//! Counts of what is odd about samples; nothing here is an error.

use core::fmt;

use std::collections::BTreeMap;

use crate::find::Use;
use slip_core::{sample::FURTHER_AXES, units::Micros};

/// From here on a finite reading is counted as huge: beyond any 32-bit counter, and no length, force or speed
/// of a gripper in SI units.
pub const HUGE_READING: f32 = 1e10;

/// What was odd in a recording. Readings are counted over all sensor columns used.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Notes {
    /// Readings written as NaN.
    pub nan: usize,
    /// Readings that are infinite, or too large for `f32`.
    pub infinite: usize,
    /// Finite readings of at least [`HUGE_READING`].
    pub huge: usize,
    /// Empty stylus cells, read as NaN.
    pub empty_stylus: usize,
    /// Rows with the same time as the row before.
    pub repeated_times: usize,
    /// Steps above zero that are more than 50 % away from the median step; includes `gaps`.
    pub irregular_steps: usize,
    /// Steps longer than 1.5 median steps: at least one sample is missing.
    pub gaps: usize,
    /// The longest step.
    pub longest_step: Micros,
    /// Rate of the times (Hz); `None` without a time column or where most times repeat.
    pub measured_rate_hz: Option<f32>,
    /// The rate given by the caller, if any (Hz).
    pub given_rate_hz: Option<f32>,
    /// Blank lines between rows.
    pub blank_lines: usize,
    /// Whether every line ends with a comma (an unnamed last column).
    pub trailing_comma: bool,
    /// Columns of the file nothing is read from.
    pub ignored_columns: Vec<String>,
    /// What the columns are taken for.
    pub uses: Vec<Use>,
    /// Whether rows at the end of the file are lost.
    pub cut: bool,
    /// What the axes of stylus or vibration show at the end of their range.
    pub(crate) ends: [RangeEnd; 1 + FURTHER_AXES],
    /// What else is to be known: of the clock, of lines that were left out.
    pub remarks: Vec<String>,
}

impl Notes {
    /// Counts `value` if it is not what a working sensor sends.
    pub(crate) fn count_reading(&mut self, value: f32) {
        if value.is_nan() {
            self.nan += 1;
        } else if value.is_infinite() {
            self.infinite += 1;
        } else if value.abs() >= HUGE_READING {
            self.huge += 1;
        }
    }

    /// Takes over what the steps between the times show.
    pub(crate) fn take_steps(&mut self, steps: &Steps) {
        let Some(median) = steps.median() else { return };
        self.longest_step = Micros(steps.counts.keys().next_back().copied().unwrap_or_default());
        self.repeated_times = steps.counts.get(&0).copied().unwrap_or_default();
        if median == 0 {
            return;
        }
        let (twice, thrice) = (|step: u64| u128::from(step) * 2, u128::from(median) * 3);
        let count = |wanted: &dyn Fn(u64) -> bool| {
            steps.counts.iter().filter(|(step, _)| wanted(**step)).map(|(_, count)| count).sum()
        };
        self.gaps = count(&|step| twice(step) > thrice);
        let short: usize = count(&|step| step > 0 && twice(step) < u128::from(median));
        self.irregular_steps = self.gaps + short;
        self.measured_rate_hz = Some(steps.rate_near(median));
    }
}

/// The largest magnitude of an axis: where a signal leaps there again and again and stays, the sensor can show no more.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct RangeEnd {
    last: f32,
    most: f32,
    least_step: f32,
    /// Readings with the largest magnitude since a leap to it, and how often there were [`RangeEnd::RUN`].
    run: usize,
    runs: usize,
}

impl RangeEnd {
    /// So many readings in a row, so often, show an end of the range.
    const RUN: usize = 3;
    const RUNS: usize = 3;
    /// A leap, in smallest steps: noise of a coarse sensor and the crest of a slow wave come there by single ones.
    const LEAP: f32 = 8.0;

    /// Takes the next reading.
    pub(crate) fn push(&mut self, value: f32) {
        let (size, step) = (value.abs(), (value - self.last).abs());
        let leaps = step >= Self::LEAP * self.least_step;
        if step > 0.0 && (self.least_step == 0.0 || step < self.least_step) {
            self.least_step = step;
        }
        self.last = value;
        if size > self.most {
            *self = Self { most: size, run: usize::from(leaps), runs: 0, ..*self };
        } else if size < self.most {
            self.run = 0;
        } else if self.run > 0 || leaps {
            self.run += 1;
            self.runs += usize::from(self.run == Self::RUN);
        }
    }

    /// The largest magnitude, where it is an end of the range.
    fn reached(&self) -> Option<f32> {
        (self.runs >= Self::RUNS).then_some(self.most)
    }
}

/// How often each step between times occurred.
///
/// The rate is that of the mean of the steps which are regular, within half of the median: the median alone is as coarse as the
/// times are rounded (455 us for 2200 Hz, 600 us for 1600 Hz); lost or late samples do not enter.
#[derive(Clone, Debug, Default)]
pub(crate) struct Steps {
    last: Option<Micros>,
    counts: BTreeMap<u64, usize>,
    all: usize,
}

/// Different steps that are counted apart; beyond, steps within 1 part in 2000 are taken together, so that stamps of any kind take no room.
const MOST_STEPS: usize = 1 << 16;

impl Steps {
    /// Takes the next time, which is not before the last one.
    pub(crate) fn push(&mut self, t: Micros) {
        let Some(last) = self.last.replace(t) else { return };
        let step = t.since(last).0;
        let known = self.counts.len() < MOST_STEPS || self.counts.contains_key(&step);
        *self.counts.entry(if known { step } else { coarse(step) }).or_default() += 1;
        self.all += 1;
    }

    fn median(&self) -> Option<u64> {
        let middle = self.all / 2;
        let mut below = 0;
        self.counts.iter().find_map(|(step, count)| {
            below += count;
            (below > middle).then_some(*step)
        })
    }

    #[expect(clippy::cast_possible_truncation, reason = "a rate in Hz is given as f32")]
    fn rate_near(&self, median: u64) -> f32 {
        let near = self.counts.range(median.div_ceil(2)..=median.saturating_add(median / 2));
        let (sum, count) = near.fold((0.0, 0.0), |(sum, all), (step, count)| {
            (sum + *step as f64 * *count as f64, all + *count as f64)
        });
        (1e6 * count / sum) as f32
    }
}

/// The 12 highest bits of a step.
fn coarse(step: u64) -> u64 {
    let low = (u64::BITS - step.leading_zeros()).saturating_sub(12);
    step >> low << low
}

impl fmt::Display for Notes {
    /// One phrase for each count above zero, separated by `; `; nothing at all for a clean recording.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let counts = [
            (self.nan, "NaN readings"),
            (self.infinite, "infinite readings"),
            (self.huge, "huge readings"),
            (self.empty_stylus, "empty cells of stylus or vibration"),
            (self.repeated_times, "repeated times"),
            (self.irregular_steps, "irregular steps"),
            (self.gaps, "gaps"),
            (self.blank_lines, "blank lines"),
        ];
        let mut phrases: Vec<String> = counts
            .into_iter()
            .filter(|(count, _)| *count > 0)
            .map(|(count, what)| format!("{what}: {count}"))
            .collect();
        if self.gaps > 0 {
            phrases.push(format!("longest step: {:.6} s", self.longest_step.as_seconds()));
        }
        if let (Some(given), Some(measured)) = (self.given_rate_hz, self.measured_rate_hz)
            && (given - measured).abs() > 0.01 * measured
        {
            phrases.push(format!("rate given: {given} Hz, by the times: {measured} Hz"));
        }
        if let Some(most) = self.ends.iter().find_map(RangeEnd::reached) {
            phrases.push(format!(
                "stylus or vibration stops at {most} again and again: where that is the end of its range, slips look weaker than they are"
            ));
        }
        if self.trailing_comma {
            phrases.push("every line ends with a comma".to_owned());
        }
        if !self.ignored_columns.is_empty() {
            phrases.push(format!("columns not used: {}", self.ignored_columns.join(", ")));
        }
        phrases.extend(self.remarks.iter().cloned());
        f.write_str(&phrases.join("; "))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn notes(times: &[u64]) -> Notes {
        let (mut steps, mut notes) = (Steps::default(), Notes::default());
        times.iter().for_each(|t| steps.push(Micros(*t)));
        notes.take_steps(&steps);
        notes
    }

    #[test]
    fn a_rounded_rate_is_recovered() {
        let times: Vec<u64> = (0..2200_u64).map(|i| (i * 10_000 + 11) / 22).collect();
        let rate = notes(&times).measured_rate_hz.unwrap();
        assert!((rate - 2200.0).abs() < 0.05, "{rate}");
    }

    #[test]
    fn steps_of_tenths_of_a_millisecond_give_the_mean_rate() {
        for (rate, unit) in [(1600, 100), (800, 100), (1344, 100), (18_000, 10), (12_000, 10)] {
            let times =
                (0..4000).filter(|i| i % 500 != 7).map(|i| i * 1_000_000 / rate / unit * unit);
            let notes = notes(&times.collect::<Vec<u64>>());
            let measured = notes.measured_rate_hz.unwrap();
            assert!((measured / rate as f32 - 1.0).abs() < 0.005, "{rate} {measured}");
            assert_eq!(notes.gaps, 8);
        }
    }

    #[test]
    fn gaps_repeats_and_short_steps_are_told_apart() {
        let notes = notes(&[0, 1000, 2000, 2000, 3000, 3100, 4100, 5100, 8100, 9100, 10_100]);
        assert_eq!((notes.repeated_times, notes.gaps, notes.irregular_steps), (1, 1, 2));
        assert_eq!(notes.longest_step, Micros(3000));
        assert_eq!(notes.measured_rate_hz, Some(1000.0));
        assert_eq!(
            notes.to_string(),
            "repeated times: 1; irregular steps: 2; gaps: 1; longest step: 0.003000 s"
        );
    }

    #[test]
    fn a_range_that_ends_is_reported() {
        let noise = |i: u16| {
            let mixed = (u64::from(i) + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
            let mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            0.06 * (mixed >> 48) as f32 / 65_536.0 - 0.03
        };
        let slip = |i: u16| if i % 1000 < 200 { 20.0 } else { 1.0 };
        let reached = |of: &dyn Fn(u16) -> f32| {
            let mut end = RangeEnd::default();
            (0..4000).for_each(|i| end.push(of(i)));
            end.reached()
        };
        let loud = |i| slip(i) * noise(i);
        assert_eq!(reached(&|i| loud(i).clamp(-0.15, 0.15)), Some(0.15));
        assert_eq!(reached(&|i| (9.81 + loud(i)).min(10.0)), Some(10.0));
        // What does not end; a coarse sensor, its magnitude, one that is dead, one that jams once.
        assert_eq!(reached(&loud), None);
        assert_eq!(reached(&|i| (200.0 * noise(i)).round()), None);
        assert_eq!(reached(&|i| (200.0 * noise(i)).round().abs()), None);
        assert_eq!(reached(&|_| 0.5), None);
        // Counts of a quiet sensor with an offset, each read four times; the crest of a slow wave.
        assert_eq!(reached(&|i| 16_384.0 + (60.0 * noise(i / 4)).round()), None);
        assert_eq!(reached(&|i| (100.0 * (0.01 * f32::from(i)).sin()).round()), None);
        assert_eq!(reached(&|i| if i < 3000 { noise(i) } else { 1.0 }), None);
    }

    #[test]
    fn stamps_that_never_repeat_take_no_room() {
        let (mut steps, mut state, mut t) = (Steps::default(), 1_u64, 0);
        for _ in 0..400_000 {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            t += 900_000 + (state >> 40) % 200_000;
            steps.push(Micros(t));
        }
        assert!(steps.counts.len() < 2 * MOST_STEPS, "{}", steps.counts.len());
        let median = steps.median().unwrap();
        assert!(median.abs_diff(1_000_000) < 2_000, "{median}");
    }

    #[test]
    fn no_rate_where_time_stands_still() {
        assert_eq!(notes(&[]).measured_rate_hz, None);
        assert_eq!(notes(&[5]).measured_rate_hz, None);
        assert_eq!(notes(&[5, 5, 5, 9]).measured_rate_hz, None);
        assert_eq!(notes(&[0, u64::MAX]).gaps, 0);
    }
}
