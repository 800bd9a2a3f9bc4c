//! Values and units in, short text of a steady width out.

/// Powers of ten that have a name.
const PREFIXES: [(f64, &str); 9] = [
    (1e9, "G"),
    (1e6, "M"),
    (1e3, "k"),
    (1.0, ""),
    (1e-3, "m"),
    (1e-6, "\u{b5}"),
    (1e-9, "n"),
    (1e-12, "p"),
    (1e-15, "f"),
];
/// Units that take no prefix.
const PLAIN: [&str; 4] = ["", "%", "dB", "s^-1"];

/// A number and its unit, ready to be shown.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Shown {
    /// Four digits, with sign where negative.
    pub number: String,
    /// The unit with its prefix.
    pub unit: String,
}

/// What stands where there is no value.
pub const NOTHING: &str = "-";

/// A value of a unit with four digits: `1.234e-5 m` is `12.34` and `um`.
#[must_use]
pub fn value(value: f64, unit: &str) -> Shown {
    let (factor, prefix) = prefix_of(value.abs(), unit);
    Shown { number: number(value / factor), unit: format!("{prefix}{unit}") }
}

/// [`value`] in one piece.
#[must_use]
pub fn with_unit(x: f64, unit: &str) -> String {
    let shown = value(x, unit);
    if shown.unit.is_empty() { shown.number } else { format!("{} {}", shown.number, shown.unit) }
}

/// The factor and prefix in which a quantity of this size is best told.
#[must_use]
pub fn prefix_of(size: f64, unit: &str) -> (f64, &'static str) {
    if PLAIN.contains(&unit) || !(size.is_finite() && size > 0.0) {
        return (1.0, "");
    }
    // Values that round to 1000 take the next prefix.
    let found = PREFIXES.into_iter().find(|&(factor, _)| size >= factor * 0.999_95);
    match found {
        Some((factor, prefix)) if size < 1e15 => (factor, prefix),
        _ => (1.0, ""),
    }
}

/// Four digits of a number; powers of ten where it is very large or small.
#[must_use]
pub fn number(x: f64) -> String {
    if x.is_nan() {
        return NOTHING.to_owned();
    }
    if x.is_infinite() {
        return if x > 0.0 { "inf" } else { "-inf" }.to_owned();
    }
    let size = x.abs();
    if size != 0.0 && !(9.5e-4..99_999.5).contains(&size) {
        return format!("{x:.2e}");
    }
    let decimals = match size {
        s if s >= 999.95 => 0,
        s if s >= 99.995 => 1,
        s if s >= 9.9995 => 2,
        _ => 3,
    };
    format!("{x:.decimals$}")
}

/// A duration (s) with its unit.
#[must_use]
pub fn duration(s: f64) -> String {
    if s.abs() >= 120.0 {
        let minutes = (s.abs() / 60.0).floor();
        let sign = if s < 0.0 { "-" } else { "" };
        return format!("{sign}{minutes:.0} min {:.0} s", s.abs() - minutes * 60.0);
    }
    with_unit(s, "s")
}

/// A count with a thin gap between thousands.
#[must_use]
pub fn count(n: u64) -> String {
    let digits = n.to_string();
    let mut text = String::with_capacity(digits.len() + digits.len() / 3);
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::{count, duration, number, value, with_unit};

    #[test]
    fn values_have_four_digits_and_a_prefix() {
        assert_eq!(with_unit(1.234e-5, "m"), "12.34 \u{b5}m");
        assert_eq!(with_unit(-0.5, "N"), "-500.0 mN");
        assert_eq!(with_unit(0.0, "N"), "0.000 N");
        assert_eq!(with_unit(999.96e-6, "m"), "1.000 mm");
        assert_eq!(with_unit(25.0, ""), "25.00");
        assert_eq!(with_unit(12_345.6, ""), "12346");
        assert_eq!(value(1e30, "m").number, "1.00e30");
    }

    #[test]
    fn what_is_no_number_is_told() {
        assert_eq!(number(f64::NAN), "-");
        assert_eq!(number(f64::INFINITY), "inf");
        assert_eq!(with_unit(f64::NAN, "N"), "- N");
    }

    #[test]
    fn durations_and_counts() {
        assert_eq!(duration(0.0123), "12.30 ms");
        assert_eq!(duration(125.0), "2 min 5 s");
        assert_eq!(count(1_234_567), "1,234,567");
        assert_eq!(count(12), "12");
    }
}
