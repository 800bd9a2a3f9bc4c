//! Units in names and below them.

/// What a unit measures, in the unit that 1 is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Seconds.
    Time,
    /// Metres.
    Length,
    /// Newtons.
    Force,
    /// Metres a second.
    Speed,
    /// Metres a second squared.
    Acceleration,
    /// Volts.
    Voltage,
    /// Pascals.
    Pressure,
}

impl Quantity {
    /// What it is, with units that are read.
    #[must_use]
    pub const fn words(self) -> &'static str {
        match self {
            Self::Time => "a time (s, ms, us, ns)",
            Self::Length => "a length (m, mm, um, nm, in)",
            Self::Force => "a force (N, mN, kN, gf)",
            Self::Speed => "a speed (m/s, mm/s)",
            Self::Acceleration => "an acceleration (m/s2, g, mg)",
            Self::Voltage => "a voltage (V, mV, uV)",
            Self::Pressure => "a pressure (Pa, kPa, bar)",
        }
    }
}

use Quantity::{Acceleration, Force, Length, Pressure, Speed, Time, Voltage};

/// Spellings, what they measure, and how much of the base unit one is.
const UNITS: [(&str, Quantity, f64); 61] = [
    ("s", Time, 1.0),
    ("sec", Time, 1.0),
    ("secs", Time, 1.0),
    ("second", Time, 1.0),
    ("seconds", Time, 1.0),
    ("ms", Time, 1e-3),
    ("msec", Time, 1e-3),
    ("millis", Time, 1e-3),
    ("millisecond", Time, 1e-3),
    ("milliseconds", Time, 1e-3),
    ("us", Time, 1e-6),
    ("usec", Time, 1e-6),
    ("micros", Time, 1e-6),
    ("microseconds", Time, 1e-6),
    ("ns", Time, 1e-9),
    ("nsec", Time, 1e-9),
    ("nanos", Time, 1e-9),
    ("nanoseconds", Time, 1e-9),
    ("min", Time, 60.0),
    ("m", Length, 1.0),
    ("meter", Length, 1.0),
    ("metre", Length, 1.0),
    ("cm", Length, 1e-2),
    ("mm", Length, 1e-3),
    ("millimeter", Length, 1e-3),
    ("um", Length, 1e-6),
    ("micron", Length, 1e-6),
    ("microns", Length, 1e-6),
    ("micrometer", Length, 1e-6),
    ("nm", Length, 1e-9),
    ("pm", Length, 1e-12),
    ("in", Length, 0.0254),
    ("inch", Length, 0.0254),
    ("mil", Length, 25.4e-6),
    ("N", Force, 1.0),
    ("newton", Force, 1.0),
    ("newtons", Force, 1.0),
    ("mN", Force, 1e-3),
    ("uN", Force, 1e-6),
    ("kN", Force, 1e3),
    ("gf", Force, 9.806_65e-3),
    ("kgf", Force, 9.806_65),
    ("lbf", Force, 4.448_221_615_260_5),
    ("m/s", Speed, 1.0),
    ("mm/s", Speed, 1e-3),
    ("um/s", Speed, 1e-6),
    ("m/s2", Acceleration, 1.0),
    ("m/s^2", Acceleration, 1.0),
    ("mm/s2", Acceleration, 1e-3),
    ("g", Acceleration, 9.806_65),
    ("mg", Acceleration, 9.806_65e-3),
    ("V", Voltage, 1.0),
    ("volt", Voltage, 1.0),
    ("volts", Voltage, 1.0),
    ("mV", Voltage, 1e-3),
    ("millivolts", Voltage, 1e-3),
    ("uV", Voltage, 1e-6),
    ("Pa", Pressure, 1.0),
    ("kPa", Pressure, 1e3),
    ("MPa", Pressure, 1e6),
    ("bar", Pressure, 1e5),
];

/// What `unit` measures and how much of its base unit one is; `None` where it is not known. Both signs for micro,
/// `\u{b2}` and words in any case are taken, symbols in their own case or all in lower case.
#[must_use]
pub fn scale(unit: &str) -> Option<(Quantity, f64)> {
    let unit = unit.trim().replace(['\u{b5}', '\u{3bc}'], "u").replace('\u{b2}', "2");
    let found = UNITS.iter().find(|(spelling, ..)| *spelling == unit).or_else(|| {
        let lower = unit.to_lowercase();
        UNITS.iter().find(|(spelling, ..)| {
            let is_word = spelling.len() > 3;
            (is_word && *spelling == lower) || (lower == unit && spelling.to_lowercase() == unit)
        })
    });
    found.map(|(_, quantity, factor)| (*quantity, *factor))
}

/// The unit in a name: in brackets (any), or a known one behind `/`, `_` or a blank at its end. With it the name
/// without.
#[must_use]
pub fn of_name(name: &str) -> Option<(String, String)> {
    for (open, close) in [('(', ')'), ('[', ']'), ('{', '}')] {
        if let Some((before, unit)) =
            name.strip_suffix(close).and_then(|name| name.rsplit_once(open))
            && !unit.trim().is_empty()
        {
            return Some((before.trim_end().to_owned(), unit.trim().to_owned()));
        }
    }
    let is_unit = |(before, unit): &(&str, &str)| !before.is_empty() && scale(unit).is_some();
    // m/s stands whole behind an underscore or a blank.
    let cut = name
        .rsplit_once(['_', ' '])
        .filter(is_unit)
        .or_else(|| name.split_once('/').filter(is_unit));
    let cut = cut.or_else(|| name.rsplit_once('/').filter(is_unit));
    cut.map(|(before, unit)| (before.trim_end().to_owned(), unit.to_owned()))
}

/// The unit in a cell below a name: in brackets, or a known one.
pub(crate) fn of_cell(cell: &str) -> Option<String> {
    let bare = [("(", ")"), ("[", "]"), ("{", "}")]
        .into_iter()
        .find_map(|(open, close)| cell.strip_prefix(open)?.strip_suffix(close));
    match bare {
        Some(unit) => Some(unit.trim().to_owned()),
        None => scale(cell).map(|_| cell.to_owned()),
    }
}
