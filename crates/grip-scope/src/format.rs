//! Format of values and units as short text of a steady width.

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
const DAY_S: f64 = 86_400.0;
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
    // Evidence may stand for more than the age of the world.
    if unit == "s" && value.abs() >= DAY_S {
        let days = value / DAY_S;
        let number = match days {
            365.0.. => "> 365".to_owned(),
            ..-365.0 => "< -365".to_owned(),
            _ => number(days),
        };
        return Shown { number, unit: "days".to_owned() };
    }
    let (factor, prefix) = prefix_of(value.abs(), unit);
    Shown { number: number(value / factor), unit: format!("{prefix}{unit}") }
}

/// [`value`] in one piece.
#[must_use]
pub fn with_unit(x: f64, unit: &str) -> String {
    let shown = value(x, unit);
    if shown.unit.is_empty() { shown.number } else { format!("{} {}", shown.number, shown.unit) }
}

/// The factor and prefix in which a quantity of this size is best reported.
#[must_use]
pub fn prefix_of(size: f64, unit: &str) -> (f64, &'static str) {
    if PLAIN.contains(&unit) || !(size.is_finite() && size > 0.0) {
        return (1.0, "");
    }
    // Values that round to 1000 take the next prefix. Nobody counts in kiloseconds.
    let usual = |factor: f64| unit != "s" || factor <= 1.0;
    let found = PREFIXES.into_iter().find(|&(f, _)| usual(f) && size >= f * 0.999_95);
    match found {
        Some((factor, prefix)) if size < 1e15 => (factor, prefix),
        _ => (1.0, ""),
    }
}

/// What was typed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Typed {
    /// A number without a unit.
    Number(f64),
    /// A number with a unit, as a multiple of the unit without prefix.
    Quantity(f64),
}

/// The number in a text, with or without a unit: `0.2 mm` is 2e-4 where the unit is `m`. `None` where it is no finite number, or another unit.
#[must_use]
pub fn parse(text: &str, unit: &str) -> Option<Typed> {
    let text: String = text.chars().filter(|c| !c.is_whitespace()).collect();
    let text = text.replace('\u{2212}', "-").replace(',', ".");
    if let Ok(number) = text.parse::<f64>() {
        return Some(Typed::Number(number)).filter(|_| number.is_finite());
    }
    let rest = text.strip_suffix(unit).filter(|_| !unit.is_empty())?;
    if let Ok(number) = rest.parse::<f64>() {
        return Some(Typed::Quantity(number)).filter(|_| number.is_finite());
    }
    // People type u, and keyboards differ in the letter that they have for it.
    let rest = rest.replace(['u', '\u{3bc}'], "\u{b5}");
    let named = PREFIXES.into_iter().filter(|(_, prefix)| !prefix.is_empty());
    let number = named
        .filter_map(|(factor, prefix)| Some((factor, rest.strip_suffix(prefix)?)))
        .find_map(|(factor, number)| Some(factor * number.parse::<f64>().ok()?))?;
    number.is_finite().then_some(Typed::Quantity(number))
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
    use super::{Typed, count, duration, number, parse, value, with_unit};

    #[test]
    fn values_have_four_digits_and_a_prefix() {
        assert_eq!(with_unit(1.234e-5, "m"), "12.34 \u{b5}m");
        assert_eq!(with_unit(-0.5, "N"), "-500.0 mN");
        assert_eq!(with_unit(0.0, "N"), "0.000 N");
        assert_eq!(with_unit(999.96e-6, "m"), "1.000 mm");
        assert_eq!(with_unit(25.0, ""), "25.00");
        assert_eq!(with_unit(12_345.6, ""), "12346");
        assert_eq!([4e-3, 4800.0].map(|t_s| with_unit(t_s, "s")), ["4.000 ms", "4800 s"]);
        assert_eq!(value(1e30, "m").number, "1.00e30");
        let evidence = [2.5e5, 1.12e34, -1e30, f64::INFINITY].map(|t_s| with_unit(t_s, "s"));
        assert_eq!(evidence, ["2.894 days", "> 365 days", "< -365 days", "> 365 days"]);
    }

    #[test]
    fn what_is_no_number_is_reported() {
        assert_eq!(number(f64::NAN), "-");
        assert_eq!(number(f64::INFINITY), "inf");
        assert_eq!(with_unit(f64::NAN, "N"), "- N");
    }

    #[test]
    fn a_number_may_be_typed_with_its_unit() {
        assert_eq!(parse(" 2 ", "m"), Some(Typed::Number(2.0)));
        assert_eq!(parse("\u{2212}1,5", "N"), Some(Typed::Number(-1.5)));
        for (text, unit, wanted) in [
            ("0.2 mm", "m", 2e-4),
            ("20um", "m", 2e-5),
            ("20 \u{3bc}m", "m", 2e-5),
            ("5e-6 m", "m", 5e-6),
            ("3 mm/s", "m/s", 3e-3),
            ("1.5kN", "N", 1500.0),
        ] {
            let Some(Typed::Quantity(got)) = parse(text, unit) else { panic!("{text}") };
            assert!((got / wanted - 1.0).abs() < 1e-12, "{text}: {got}");
        }
        for (text, unit) in [("2 N", "m"), ("x", "m"), ("", ""), ("nan", ""), ("2 xm", "m")] {
            assert_eq!(parse(text, unit), None, "{text}");
        }
    }

    #[test]
    fn durations_and_counts() {
        assert_eq!(duration(0.0123), "12.30 ms");
        assert_eq!(duration(125.0), "2 min 5 s");
        assert_eq!(count(1_234_567), "1,234,567");
        assert_eq!(count(12), "12");
    }
}
