//! Column specs like `force_n:ln`: column name, transform and unit.

use core::fmt;
use core::str::FromStr;

use crate::{model::Transform, named::Unknown};

/// A column of a data set and what is done to it before scaling. Written `name`, `name:ln` or `name:reciprocal`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ColumnSpec {
    /// Name in the header row.
    pub name: String,
    /// Applied before scaling.
    pub transform: Transform,
}

/// Why a text is no column spec.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ColumnSpecError {
    /// No name before the colon.
    #[error("\"{text}\" names no column")]
    Unnamed {
        /// The text given.
        text: String,
    },
    /// Something other than a known transform behind the colon.
    #[error("\"{text}\": {source}")]
    UnknownTransform {
        /// The text given.
        text: String,
        /// The transforms there are.
        source: Unknown,
    },
}

impl FromStr for ColumnSpec {
    type Err = ColumnSpecError;

    fn from_str(text: &str) -> Result<Self, ColumnSpecError> {
        let (name, transform) = match text.rsplit_once(':') {
            None => (text, Transform::Identity),
            Some((name, suffix)) => {
                let unknown =
                    |source| ColumnSpecError::UnknownTransform { text: text.to_owned(), source };
                let transform = suffix.trim().parse().map_err(unknown)?;
                (name, transform)
            }
        };
        let name = name.trim().to_owned();
        if name.is_empty() {
            return Err(ColumnSpecError::Unnamed { text: text.to_owned() });
        }
        Ok(Self { name, transform })
    }
}

impl fmt::Display for ColumnSpec {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.transform {
            Transform::Identity => f.write_str(&self.name),
            transform => write!(f, "{}:{transform}", self.name),
        }
    }
}

/// Name endings and the SI units they stand for, the longer ones first.
const UNITS: [(&str, &str); 11] = [
    ("_m_s2", "m/s^2"),
    ("_m_s", "m/s"),
    ("_mm", "mm"),
    ("_um", "um"),
    ("_hz", "Hz"),
    ("_kg", "kg"),
    ("_n", "N"),
    ("_m", "m"),
    ("_s", "s"),
    ("_w", "W"),
    ("_j", "J"),
];

/// The unit that a column's name ends in (`force_n`: `N`), empty when it has none.
#[must_use]
pub fn unit_of(name: &str) -> &'static str {
    UNITS.iter().find(|(ending, _)| name.ends_with(ending)).map_or("", |(_, unit)| unit)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn specs_are_read_and_written_back() {
        for text in ["force_n", "force_n:ln", "force_n:reciprocal"] {
            assert_eq!(text.parse::<ColumnSpec>().unwrap().to_string(), text);
        }
        let spaced: ColumnSpec = " speed : ln ".parse().unwrap();
        assert_eq!(spaced, ColumnSpec { name: "speed".to_owned(), transform: Transform::Ln });
    }

    #[test]
    fn wrong_specs_are_named() {
        let error = "force:log".parse::<ColumnSpec>().unwrap_err();
        assert_eq!(
            error.to_string(),
            "\"force:log\": unknown transform (known: identity, ln, reciprocal)"
        );
        assert!(matches!(":ln".parse::<ColumnSpec>(), Err(ColumnSpecError::Unnamed { .. })));
    }

    #[test]
    fn units_come_from_the_name_ending() {
        let units = ["f_n", "v_m_s", "a_m_s2", "t_s", "e_w", "d_m", "x1"].map(unit_of);
        assert_eq!(units, ["N", "m/s", "m/s^2", "s", "W", "m", ""]);
    }
}
