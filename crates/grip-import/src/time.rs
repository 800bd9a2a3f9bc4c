//! The unit of times, from their name or from the rate that they give.

slip_core::named! {
    /// Unit of a column of times.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum TimeUnit {
        fn name: "Its name.";
    }
    Seconds: "Seconds.", "s";
    Millis: "Milliseconds.", "ms";
    Micros: "Microseconds.", "us";
    Nanos: "Nanoseconds.", "ns";
}

/// Rates that a recording may have (Hz).
const RATES: core::ops::RangeInclusive<f64> = 15.0..=60_000.0;
/// From here on a number is a time since 1970 in a unit, and not since a start: 1990 in seconds, and a thousand times
/// more in each further unit.
const EPOCH_S: f64 = 6.3e8;

impl TimeUnit {
    /// Nanoseconds in one.
    #[must_use]
    pub const fn ns(self) -> f64 {
        match self {
            Self::Seconds => 1e9,
            Self::Millis => 1e6,
            Self::Micros => 1e3,
            Self::Nanos => 1.0,
        }
    }

    /// The unit that a name ends with: `t_ms`, `Time(ms)`, `timestamp [us]`, `stampNs`.
    pub(crate) fn of_name(name: &str) -> Option<Self> {
        let name = name.trim_end_matches([')', ']', ' ', '}']);
        let cut = |end: &str| {
            let stem = name.strip_suffix(end)?;
            stem.ends_with(['_', '(', '[', ' ', '/', '.', '-', '{']).then_some(())
        };
        let named = |unit: Self, ends: &[&str]| ends.iter().find_map(|end| cut(end)).map(|()| unit);
        named(Self::Nanos, &["ns", "nsec", "nanos", "nanoseconds"])
            .or_else(|| {
                named(
                    Self::Micros,
                    &["us", "\u{b5}s", "\u{3bc}s", "usec", "micros", "microseconds"],
                )
            })
            .or_else(|| named(Self::Millis, &["ms", "msec", "millis", "milliseconds"]))
            .or_else(|| named(Self::Seconds, &["s", "sec", "secs", "seconds"]))
    }

    /// The unit that the numbers themselves leave: since 1970 by their size, else by the rate that their usual step gives.
    ///
    /// # Errors
    /// What is wrong, as the end of a sentence about the times.
    pub(crate) fn of_numbers(times: &[f64]) -> Result<Self, String> {
        let ends = [times.first(), times.last()].map(|time| time.copied().unwrap_or(0.0));
        for (unit, scale) in Self::ALL.into_iter().zip([1.0, 1e3, 1e6, 1e9]) {
            // Ten seconds of nanoseconds end where seconds since 1970 lie, but do not begin there.
            if ends.iter().all(|t| (EPOCH_S * scale..EPOCH_S * scale * 20.0).contains(t)) {
                return Ok(unit);
            }
        }
        let mut steps: Vec<f64> =
            times.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| *step > 0.0).collect();
        if steps.is_empty() {
            return Err("never go on".to_owned());
        }
        let middle = steps.len() / 2;
        let (_, &mut step, _) = steps.select_nth_unstable_by(middle, f64::total_cmp);
        let fits = |unit: &Self| RATES.contains(&(1e9 / (step * unit.ns())));
        let fitting: Vec<Self> = Self::ALL.into_iter().filter(fits).collect();
        match fitting.as_slice() {
            [unit] => Ok(*unit),
            [] => Err(format!(
                "have a usual step of {step}, which gives 20 to 50,000 Hz in no unit; say --rate HZ"
            )),
            [one, other, ..] => {
                let rate = |unit: &Self| 1e9 / (step * unit.ns());
                Err(format!(
                    "have a usual step of {step}: {:.1} Hz in {}, {:.1} Hz in {}; say --time-unit",
                    rate(one),
                    one.name(),
                    rate(other),
                    other.name()
                ))
            }
        }
    }

    /// A time in this unit, in ns; `None` where it finds no room.
    #[expect(clippy::cast_possible_truncation, reason = "within the range of an i64, checked")]
    pub(crate) fn to_ns(self, time: f64) -> Option<i64> {
        let ns = time * self.ns();
        (ns.abs() < 9.2e18).then(|| ns.round() as i64)
    }
}

/// Whether `name` is that of a column of times.
pub(crate) fn is_time(name: &str) -> bool {
    let lower = name.to_lowercase();
    let stem = lower.split(['(', '[', '{']).next().unwrap_or_default().trim();
    let words = [
        "t",
        "time",
        "timestamp",
        "stamp",
        "time_stamp",
        "timestamps",
        "seconds",
        "millis",
        "micros",
    ];
    let end = stem.rsplit_once(['_', ' ']).filter(|(_, unit)| unit.len() <= 4);
    words.contains(&stem)
        || end.is_some_and(|(stem, _)| words.contains(&stem) && TimeUnit::of_name(&lower).is_some())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_reported_by_name() {
        use TimeUnit::{Micros, Millis, Nanos, Seconds};
        let cases = [
            ("t_s", Some(Seconds)),
            ("Time(ms)", Some(Millis)),
            ("timestamp [us]", Some(Micros)),
            ("time_ns", Some(Nanos)),
            ("timestamp", None),
            ("time", None),
            ("t", None),
            ("pulses", None),
        ];
        for (name, unit) in cases {
            assert_eq!(TimeUnit::of_name(name), unit, "{name}");
            assert_eq!(is_time(name), name != "pulses", "{name}");
        }
        assert!(!is_time("temperature_s") && !is_time("time_of_flight") && is_time("Time_ms"));
    }

    #[test]
    fn units_are_reported_by_the_rate_or_the_epoch() {
        let steps =
            |from: f64, step: f64| (0..9).map(|i| from + step * f64::from(i)).collect::<Vec<_>>();
        let of = |from, step| TimeUnit::of_numbers(&steps(from, step));
        assert_eq!(of(0.0, 0.001), Ok(TimeUnit::Seconds));
        assert_eq!(of(5.0, 1.0), Ok(TimeUnit::Millis));
        assert_eq!(of(0.0, 500.0), Ok(TimeUnit::Micros));
        assert_eq!(of(0.0, 500_000.0), Ok(TimeUnit::Nanos));
        let ten_seconds: Vec<_> = (0..10_000).map(|i| 1e6 * f64::from(i)).collect();
        assert_eq!(TimeUnit::of_numbers(&ten_seconds), Ok(TimeUnit::Nanos));
        assert_eq!(of(1.7e9, 0.028), Ok(TimeUnit::Seconds));
        assert_eq!(of(1.7e12, 28.0), Ok(TimeUnit::Millis));
        assert_eq!(of(1.7e18, 28.0e6), Ok(TimeUnit::Nanos));
        assert!(of(0.0, 28.0).unwrap_err().contains("--time-unit"));
        assert!(of(0.0, 1e10).unwrap_err().contains("--rate"));
        assert!(of(1.0, 0.0).unwrap_err().contains("never go on"));
    }
}
