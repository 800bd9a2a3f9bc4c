//! A quantity of a scene: a number or a distribution to draw it from.

use crate::random;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

/// A quantity of a scene: `0.4`, `{ uniform = [0.2, 0.5] }`, `{ log_uniform = [0.2, 1.0] }` or
/// `{ log_normal = [0.3, 0.8], within = [0.02, 5.0] }`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(
    untagged,
    deny_unknown_fields,
    expecting = "expected a number, { uniform = [low, high] }, { log_uniform = [low, high] } or { log_normal = [median, spread], within = [low, high] }"
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
    /// A heavy tail: normal in the logarithm; what falls outside the bounds is drawn again, up to a thousand times, then put on the
    /// nearer bound.
    LogNormal {
        /// Median, and standard deviation of the logarithm.
        log_normal: [f64; 2],
        /// Low and high bound.
        within: [f64; 2],
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
            Self::LogNormal { within, .. } => within,
        }
    }

    /// The same quantity times `factor`, above 0.
    #[must_use]
    pub fn times(self, factor: f64) -> Self {
        match self {
            Self::Fixed(value) => Self::Fixed(factor * value),
            Self::Uniform { uniform } => Self::Uniform { uniform: uniform.map(|x| factor * x) },
            Self::LogUniform { log_uniform } => {
                Self::LogUniform { log_uniform: log_uniform.map(|x| factor * x) }
            }
            Self::LogNormal { log_normal: [median, spread], within } => Self::LogNormal {
                log_normal: [factor * median, spread],
                within: within.map(|x| factor * x),
            },
        }
    }

    pub(crate) fn sample(&self, rng: &mut ChaCha8Rng) -> f64 {
        match *self {
            Self::Fixed(value) => value,
            Self::Uniform { uniform: [low, high] } => random::uniform(rng, low, high),
            Self::LogUniform { log_uniform: [low, high] } => random::log_uniform(rng, low, high),
            Self::LogNormal { log_normal: [median, spread], within: [low, high] } => {
                let mut draw = || random::lognormal(rng, median, spread);
                let first = draw();
                let drawn = core::iter::once(first).chain((1..1000).map(|_| draw()));
                drawn
                    .into_iter()
                    .find(|x| (low..=high).contains(x))
                    .unwrap_or(first.clamp(low, high))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Draw;
    use crate::random::{Purpose, stream};

    #[test]
    fn a_heavy_tail_keeps_its_median_and_its_bounds() {
        let draw = Draw::LogNormal { log_normal: [0.3, 0.8], within: [0.02, 5.0] };
        let rng = &mut stream(1, Purpose::Object);
        let mut drawn: Vec<f64> = (0..4001).map(|_| draw.sample(rng)).collect();
        drawn.sort_by(f64::total_cmp);
        assert!((drawn[2000] / 0.3 - 1.0).abs() < 0.06, "{}", drawn[2000]);
        assert!(drawn[0] >= 0.02 && drawn[4000] <= 5.0);
        // The 97.5 % quantile lies two deviations out: more than four times the median.
        assert!(drawn[3900] > 1.2, "{}", drawn[3900]);
        let beside = Draw::LogNormal { log_normal: [100.0, 0.01], within: [1.0, 2.0] };
        assert!((beside.sample(rng) - 2.0).abs() < 1e-12);
    }
}
