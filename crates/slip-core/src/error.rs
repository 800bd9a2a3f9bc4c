//! Why a configuration cannot be.

use crate::filter::CornerError;

/// Why a pipeline cannot be made.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum ConfigError {
    /// A value outside its range.
    #[error("{name} = {value} is outside {low} to {high}")]
    Range {
        /// Name of the value, as in the configuration file.
        name: &'static str,
        /// The value.
        value: f32,
        /// Smallest value possible.
        low: f32,
        /// Largest value possible.
        high: f32,
    },
    /// A band that the sample rate cannot carry.
    #[error("detector band: {0}")]
    Corner(#[from] CornerError),
}

impl ConfigError {
    /// # Errors
    /// [`ConfigError::Range`] where `value` is not within `low..=high`; NaN never is.
    pub fn within(name: &'static str, value: f32, low: f32, high: f32) -> Result<(), Self> {
        if value >= low && value <= high {
            Ok(())
        } else {
            Err(Self::Range { name, value, low, high })
        }
    }
}
