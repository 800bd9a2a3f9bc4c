//! A number or a distribution in, one value out.

use crate::random;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

/// A quantity of a scene: `0.4`, `{ uniform = [0.2, 0.5] }` or `{ log_uniform = [0.2, 1.0] }`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(
    untagged,
    deny_unknown_fields,
    expecting = "expected a number, { uniform = [low, high] } or { log_uniform = [low, high] }"
)]
pub enum Draw {
    /// Always this value.
    Fixed(f64),
    /// Uniform between two bounds.
    Uniform {
        /// Low and high bound.
        uniform: [f64; 2],
    },
    /// Uniform in the logarithm between two positive bounds.
    LogUniform {
        /// Low and high bound.
        log_uniform: [f64; 2],
    },
}

impl Draw {
    /// Lowest and highest value; equal for a fixed one.
    #[must_use]
    pub fn bounds(&self) -> [f64; 2] {
        match *self {
            Self::Fixed(value) => [value, value],
            Self::Uniform { uniform } => uniform,
            Self::LogUniform { log_uniform } => log_uniform,
        }
    }

    pub(crate) fn sample(&self, rng: &mut ChaCha8Rng) -> f64 {
        match *self {
            Self::Fixed(value) => value,
            Self::Uniform { uniform: [low, high] } => random::uniform(rng, low, high),
            Self::LogUniform { log_uniform: [low, high] } => random::log_uniform(rng, low, high),
        }
    }
}
