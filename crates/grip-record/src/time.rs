//! The unit of times, from their name or from the rate that they give.

use grip_table::Quantity;

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

    /// The unit of this spelling; `None` where it is none of time.
    #[must_use]
    pub fn of_unit(unit: &str) -> Option<Self> {
        let (quantity, seconds) = grip_table::scale(unit)?;
        let is = |own: &Self| (own.ns() / 1e9 / seconds - 1.0).abs() < 1e-6;
        Self::ALL.into_iter().find(is).filter(|_| quantity == Quantity::Time)
    }

    /// The unit that the name of a column of times says in a word.
    pub(crate) fn of_word(name: &str) -> Option<Self> {
        match name.to_lowercase().as_str() {
            "seconds" => Some(Self::Seconds),
            "millis" => Some(Self::Millis),
            "micros" => Some(Self::Micros),
            _ => None,
        }
    }

    /// The unit that the numbers themselves leave: since 1970 by their size, else by the rate that their usual step gives.
    ///
    /// # Errors
    /// What is wrong, as the end of a sentence about the times.
    pub fn of_numbers(times: &[f64]) -> Result<Self, String> {
        if counts(times) {
            return Err(COUNTS.to_owned());
        }
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
        match Self::fitting(step).as_slice() {
            [unit] => Ok(*unit),
            [] => Err(format!(
                "have a usual step of {step}, which gives 20 to 50,000 Hz in no unit; give --rate HZ"
            )),
            [one, other, ..] => {
                let rate = |unit: &Self| 1e9 / (step * unit.ns());
                Err(format!(
                    "have a usual step of {step}: {:.1} Hz in {}, {:.1} Hz in {}; give --time-unit",
                    rate(one),
                    one.name(),
                    rate(other),
                    other.name()
                ))
            }
        }
    }

    /// The units in which this step between rows gives a rate that a recording may have.
    fn fitting(step: f64) -> Vec<Self> {
        let fits = |unit: &Self| RATES.contains(&(1e9 / (step * unit.ns())));
        Self::ALL.into_iter().filter(fits).collect()
    }

    /// What to say of a column of times `name` in this unit, rows `period_ns` apart, where only others give a rate that a recording
    /// may have.
    pub(crate) fn doubt(self, name: &str, period_ns: f64) -> Option<String> {
        let step = period_ns / self.ns();
        let fitting = Self::fitting(step);
        if fitting.is_empty() || fitting.contains(&self) {
            return None;
        }
        let other = |unit: Self| format!("{} ({:.1} Hz)", unit.name(), 1e9 / (step * unit.ns()));
        let others = fitting.into_iter().map(other).collect::<Vec<_>>().join(" or ");
        let rate_hz = 1e9 / period_ns;
        Some(format!(
            "{name:?} in {} gives {rate_hz:.3} Hz; where its numbers are in another unit: --time-unit {others}",
            self.name()
        ))
    }

    /// A time in this unit, in ns; `None` where it finds no room.
    #[expect(clippy::cast_possible_truncation, reason = "within the range of an i64, checked")]
    #[must_use]
    pub fn to_ns(self, time: f64) -> Option<i64> {
        let ns = time * self.ns();
        (ns.abs() < 9.2e18).then(|| ns.round() as i64)
    }
}

/// Why a cell is not a time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum TimeFault {
    NotANumber,
    OutOfRange,
}

/// Decimal text in `unit` to whole nanoseconds, what is below one cut off.
///
/// The digits are shifted, never multiplied as floating point: no digit of a time since 1970 is lost.
pub(crate) fn parse_stamp(text: &str, unit: TimeUnit) -> Result<i64, TimeFault> {
    let value: f64 = text.parse().map_err(|_| TimeFault::NotANumber)?;
    let exponent = match unit {
        TimeUnit::Seconds => 9,
        TimeUnit::Millis => 6,
        TimeUnit::Micros => 3,
        TimeUnit::Nanos => 0,
    };
    unit.to_ns(value).ok_or(TimeFault::OutOfRange)?;
    let ns = shifted_digits(text.trim_start_matches(['+', '-']), exponent);
    let ns = ns.ok_or(TimeFault::OutOfRange)?;
    Ok(if value < 0.0 { -ns } else { ns })
}

/// The decimal `digits[.digits][e[+-]digits]` times 10^`shift`; `None` beyond 64 bits.
fn shifted_digits(decimal: &str, shift: i64) -> Option<i64> {
    let (mantissa, exponent) = match decimal.split_once(['e', 'E']) {
        Some((mantissa, exponent)) => (mantissa, exponent.parse().unwrap_or(i64::MIN)),
        None => (decimal, 0_i64),
    };
    let (whole, fraction) = mantissa.split_once('.').unwrap_or((mantissa, ""));
    let kept = i64::try_from(whole.len()).ok()?.saturating_add(exponent).saturating_add(shift);
    let digits = whole.bytes().chain(fraction.bytes());
    let mut shifted = 0_i64;
    let mut position = 0;
    for digit in digits.map(|byte| i64::from(byte.wrapping_sub(b'0'))) {
        if position >= kept {
            return Some(shifted);
        }
        shifted = shifted.checked_mul(10)?.checked_add(digit)?;
        position += 1;
    }
    while position < kept && shifted != 0 {
        shifted = shifted.checked_mul(10)?;
        position += 1;
    }
    Some(shifted)
}

const COUNTS: &str = "go up by exactly 1: give --rate HZ where they count rows, or --time-unit ms (or s) where they are times";

/// Whether numbers count their rows.
#[expect(clippy::float_cmp, reason = "counts are whole")]
pub(crate) fn counts(times: &[f64]) -> bool {
    times.len() > 1
        && times.first().is_some_and(|first| first.fract() == 0.0 && first.abs() < 1e9)
        && times.windows(2).all(|pair| pair[1] - pair[0] == 1.0)
}

/// Whether `name`, with its unit if it has one, is that of a column of times.
pub(crate) fn is_time(name: &str, unit: Option<&str>) -> bool {
    const WORDS: [&str; 15] = [
        "t",
        "time",
        "timestamp",
        "stamp",
        "time_stamp",
        "timestamps",
        "seconds",
        "millis",
        "micros",
        "zeit",
        "zeitstempel",
        "temps",
        "tiempo",
        "tempo",
        "tijd",
    ];
    let lower = name.to_lowercase();
    let stem = lower.split(['(', '[', '{']).next().unwrap_or_default().trim();
    let cut = unit.and_then(|unit| stem.strip_suffix(&unit.to_lowercase()));
    let cut = cut.map(|stem| stem.trim_end_matches(['_', ' ', '/', '.', '-']));
    let is_unit = unit.is_none_or(|unit| TimeUnit::of_unit(unit).is_some());
    WORDS.contains(&stem) || (is_unit && cut.is_some_and(|stem| WORDS.contains(&stem)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_reported_by_name() {
        use TimeUnit::{Micros, Millis, Nanos, Seconds};
        let cases = [
            ("t_s", Some("s"), Some(Seconds)),
            ("Time(ms)", Some("ms"), Some(Millis)),
            ("timestamp [\u{b5}s]", Some("\u{b5}s"), Some(Micros)),
            ("time_ns", Some("ns"), Some(Nanos)),
            ("Zeit", None, None),
            ("t", None, None),
        ];
        for (name, unit, expected) in cases {
            assert_eq!(unit.and_then(TimeUnit::of_unit), expected, "{name}");
            assert!(is_time(name, unit), "{name}");
        }
        assert_eq!(["Micros", "time"].map(TimeUnit::of_word), [Some(Micros), None]);
        for (name, unit) in [("temperature_s", Some("s")), ("time_of_flight", None), ("mm", None)] {
            assert!(!is_time(name, unit), "{name}");
        }
        assert_eq!((TimeUnit::of_unit("mm"), TimeUnit::of_unit("min")), (None, None));
    }

    #[test]
    fn stamps_keep_their_digits() {
        let cases = [
            ("0", TimeUnit::Seconds, 0),
            ("-0", TimeUnit::Seconds, 0),
            ("0.000455", TimeUnit::Seconds, 455_000),
            ("0.00045449999", TimeUnit::Seconds, 454_499),
            ("+1.5", TimeUnit::Seconds, 1_500_000_000),
            ("-1.5", TimeUnit::Seconds, -1_500_000_000),
            (".5", TimeUnit::Millis, 500_000),
            ("2.", TimeUnit::Micros, 2000),
            ("12.5E1", TimeUnit::Seconds, 125_000_000_000),
            ("4.9e-7", TimeUnit::Seconds, 490),
            ("0e99999999999999999999", TimeUnit::Seconds, 0),
            ("1e-99999999999999999999", TimeUnit::Seconds, 0),
            ("1700000000.123456789", TimeUnit::Seconds, 1_700_000_000_123_456_789),
            ("1700000000123456789", TimeUnit::Nanos, 1_700_000_000_123_456_789),
        ];
        for (text, unit, ns) in cases {
            assert_eq!(parse_stamp(text, unit), Ok(ns), "{text}");
        }
        for text in ["", "abc", "1,5", "0x10", "1e", "--1", "1 2"] {
            assert_eq!(parse_stamp(text, TimeUnit::Seconds), Err(TimeFault::NotANumber), "{text}");
        }
        for text in ["NaN", "inf", "-inf", "1e400", "1e30", "9300000000"] {
            assert_eq!(parse_stamp(text, TimeUnit::Seconds), Err(TimeFault::OutOfRange), "{text}");
        }
    }

    #[test]
    fn units_are_reported_by_the_rate_or_the_epoch() {
        let steps =
            |from: f64, step: f64| (0..9).map(|i| from + step * f64::from(i)).collect::<Vec<_>>();
        let of = |from, step| TimeUnit::of_numbers(&steps(from, step));
        assert_eq!(of(0.0, 0.001), Ok(TimeUnit::Seconds));
        assert_eq!(of(5.0, 2.0), Ok(TimeUnit::Millis));
        assert!(of(5.0, 1.0).unwrap_err().contains("--rate HZ where they count"));
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

    #[test]
    fn a_stated_unit_that_gives_no_rate_is_doubted() {
        let doubt = |unit: TimeUnit, step: f64| unit.doubt("Zeit (s)", step * unit.ns());
        assert_eq!(
            doubt(TimeUnit::Seconds, 0.2).unwrap(),
            "\"Zeit (s)\" in s gives 5.000 Hz; where its numbers are in another unit: --time-unit ms (5000.0 Hz)"
        );
        assert!(
            doubt(TimeUnit::Seconds, 28.0).unwrap().ends_with("ms (35.7 Hz) or us (35714.3 Hz)")
        );
        assert!(doubt(TimeUnit::Millis, 1e-3).unwrap().ends_with("--time-unit s (1000.0 Hz)"));
        for (unit, step) in
            [(TimeUnit::Seconds, 1e-3), (TimeUnit::Millis, 0.2), (TimeUnit::Seconds, 1e10)]
        {
            assert_eq!(doubt(unit, step), None, "{step} {}", unit.name());
        }
    }

    proptest::proptest! {
        #[test]
        fn every_digit_counts(ns in 0_i64..9_000_000_000_000_000_000) {
            let (whole, part) = (ns / 1_000_000_000, ns % 1_000_000_000);
            proptest::prop_assert_eq!(parse_stamp(&format!("{whole}.{part:09}"), TimeUnit::Seconds), Ok(ns));
            proptest::prop_assert_eq!(parse_stamp(&format!("{ns}e-3"), TimeUnit::Micros), Ok(ns));
        }
    }
}
