//! Range check of a setting's value: an error with its name and range if it lies outside.

/// A setting that can not work.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("{name} is {value}: it must be {range}")]
pub struct SettingError {
    /// Name of the field.
    pub name: &'static str,
    /// Its value.
    pub value: f64,
    /// What is possible.
    pub range: &'static str,
}

pub(super) fn positive(name: &'static str, value: f64) -> Result<(), SettingError> {
    require(name, value, value > 0.0, "a positive number")
}

pub(super) fn not_negative(name: &'static str, value: f64) -> Result<(), SettingError> {
    require(name, value, value >= 0.0, "0 or a positive number")
}

pub(super) fn above_one(name: &'static str, value: f64) -> Result<(), SettingError> {
    require(name, value, value > 1.0, "a number above 1")
}

pub(super) fn at_least_one(name: &'static str, value: usize) -> Result<(), SettingError> {
    require(name, super::objective::count(value), value >= 1, "1 or more")
}

/// Above 0 and below 1.
pub(super) fn share(name: &'static str, value: f64) -> Result<(), SettingError> {
    require(name, value, value > 0.0 && value < 1.0, "between 0 and 1")
}

fn require(
    name: &'static str,
    value: f64,
    inside: bool,
    range: &'static str,
) -> Result<(), SettingError> {
    if inside && value.is_finite() { Ok(()) } else { Err(SettingError { name, value, range }) }
}
