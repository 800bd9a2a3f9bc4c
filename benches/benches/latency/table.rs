//! Histograms of nanoseconds and limits in, a Markdown table out.

use core::time::Duration;
use hdrhistogram::{CreationError, Histogram};

/// Times up to a second, three digits.
pub(crate) fn histogram() -> Result<Histogram<u64>, CreationError> {
    Histogram::new_with_max(1_000_000_000, 3)
}

/// Counts `time`; what is longer than a second counts as a second.
pub(crate) fn record(times: &mut Histogram<u64>, time: Duration) {
    times.saturating_record(u64::try_from(time.as_nanos()).unwrap_or(u64::MAX));
}

/// What a row promises.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Limits {
    /// Half of the times are shorter (us).
    pub(crate) p50_us: Option<f64>,
    /// 99.9 % of the times are shorter (us).
    pub(crate) p99_9_us: Option<f64>,
}

impl Limits {
    /// Nothing.
    pub(crate) const NONE: Self = Self { p50_us: None, p99_9_us: None };
}

/// The rows so far.
#[derive(Debug, Default)]
pub(crate) struct Table {
    rows: Vec<String>,
    /// Limits that are not kept.
    over: usize,
}

impl Table {
    /// Adds the percentiles of `times` (ns) and whether they keep `limits`.
    pub(crate) fn add(&mut self, what: &str, times: &Histogram<u64>, limits: Limits) {
        let [p50, p99, p99_9, max] = [
            times.value_at_quantile(0.5),
            times.value_at_quantile(0.99),
            times.value_at_quantile(0.999),
            times.max(),
        ]
        .map(micros);
        let mut verdicts = Vec::new();
        for (name, time, limit) in [("p50", p50, limits.p50_us), ("p99.9", p99_9, limits.p99_9_us)]
        {
            let Some(limit) = limit else { continue };
            let kept = time <= limit;
            self.over += usize::from(!kept);
            verdicts.push(format!("{name} <= {limit} {}", if kept { "PASS" } else { "over" }));
        }
        let verdict = verdicts.join(", ");
        let count = times.len();
        self.rows.push(format!(
            "| {what} | {count} | {p50:.2} | {p99:.2} | {p99_9:.2} | {max:.1} | {verdict} |"
        ));
    }

    /// How many limits are not kept.
    pub(crate) fn over(&self) -> usize {
        self.over
    }

    /// Prints the table on standard output.
    #[expect(clippy::print_stdout, reason = "the result of the program")]
    pub(crate) fn print(&self) {
        println!("| what (us) | times | p50 | p99 | p99.9 | max | limit |");
        println!("|---|---|---|---|---|---|---|");
        self.rows.iter().for_each(|row| println!("{row}"));
    }
}

/// Nanoseconds in microseconds.
fn micros(ns: u64) -> f64 {
    Duration::from_nanos(ns).as_secs_f64() * 1e6
}
