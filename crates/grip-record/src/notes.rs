//! Samples in, counts of what is odd about them out; nothing here is an error.

use core::fmt;

use slip_core::sample::Sample;
use slip_core::units::Micros;

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

    /// Counts the steps between `samples`, whose times must not decrease, and measures the rate.
    ///
    /// The rate is that of the median step. Times rounded to 1 us make it coarse (455 us for 2200 Hz), so the
    /// mean of the steps within 1 us of the median is taken; lost or late samples do not enter.
    pub(crate) fn count_steps(&mut self, samples: &[Sample]) {
        let mut steps: Vec<u64> = samples
            .iter()
            .zip(samples.iter().skip(1))
            .map(|(one, next)| next.t.since(one.t).0)
            .collect();
        let middle = steps.len() / 2;
        if steps.is_empty() {
            return;
        }
        let (_, &mut median, _) = steps.select_nth_unstable(middle);
        self.longest_step = Micros(steps.iter().copied().max().unwrap_or_default());
        self.repeated_times = steps.iter().filter(|step| **step == 0).count();
        if median == 0 {
            return;
        }
        let (twice, thrice) = (|step: u64| u128::from(step) * 2, u128::from(median) * 3);
        self.gaps = steps.iter().filter(|step| twice(**step) > thrice).count();
        let short =
            steps.iter().filter(|step| **step > 0 && twice(**step) < u128::from(median)).count();
        self.irregular_steps = self.gaps + short;
        self.measured_rate_hz = Some(rate_near(&steps, median));
    }
}

#[expect(
    clippy::cast_precision_loss,
    reason = "a rate needs 24 bits, the sums stay far below 2^53 us"
)]
#[expect(clippy::cast_possible_truncation, reason = "a rate in Hz is given as f32")]
fn rate_near(steps: &[u64], median: u64) -> f32 {
    let near = steps.iter().filter(|step| step.abs_diff(median) <= 1);
    let (sum, count) =
        near.fold((0.0, 0.0), |(sum, count), step| (sum + *step as f64, count + 1.0));
    (1e6 * count / sum) as f32
}

impl fmt::Display for Notes {
    /// One phrase for each count above zero, separated by `; `; nothing at all for a clean recording.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let counts = [
            (self.nan, "NaN readings"),
            (self.infinite, "infinite readings"),
            (self.huge, "huge readings"),
            (self.empty_stylus, "empty stylus cells"),
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
        if self.trailing_comma {
            phrases.push("every line ends with a comma".to_owned());
        }
        if !self.ignored_columns.is_empty() {
            phrases.push(format!("columns not used: {}", self.ignored_columns.join(", ")));
        }
        f.write_str(&phrases.join("; "))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn notes(times: &[u64]) -> Notes {
        let samples: Vec<Sample> = times.iter().map(|&t| Sample::stylus(Micros(t), 0.0)).collect();
        let mut notes = Notes::default();
        notes.count_steps(&samples);
        notes
    }

    #[test]
    fn a_rounded_rate_is_recovered() {
        let times: Vec<u64> = (0..2200_u64).map(|i| (i * 10_000 + 11) / 22).collect();
        let rate = notes(&times).measured_rate_hz.unwrap();
        assert!((rate - 2200.0).abs() < 0.05, "{rate}");
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
    fn no_rate_where_time_stands_still() {
        assert_eq!(notes(&[]).measured_rate_hz, None);
        assert_eq!(notes(&[5]).measured_rate_hz, None);
        assert_eq!(notes(&[5, 5, 5, 9]).measured_rate_hz, None);
        assert_eq!(notes(&[0, u64::MAX]).gaps, 0);
    }
}
