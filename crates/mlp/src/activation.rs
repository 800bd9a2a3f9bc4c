//! Sum of a neuron's weighted inputs in, its output out.

use core::fmt;
use core::str::FromStr;

/// Function applied to the weighted sum of a neuron.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Activation {
    /// Hyperbolic tangent, range (-1, 1).
    Tanh,
    /// Identity, unlimited range.
    Linear,
    /// Logistic sigmoid `1 / (1 + exp(-x))`, range (0, 1).
    Logistic,
    /// `max(0, x)`, range [0, inf).
    Relu,
}

impl Activation {
    /// All functions, for tables and tests.
    pub const ALL: [Self; 4] = [Self::Tanh, Self::Linear, Self::Logistic, Self::Relu];

    /// The function's value at `x`; NaN stays NaN.
    #[must_use]
    pub fn value(self, x: f32) -> f32 {
        match self {
            Self::Tanh => tanh(x),
            Self::Linear => x,
            Self::Logistic => logistic(x),
            Self::Relu => relu(x),
        }
    }

    /// Replaces every sum in `layer` by the function's value, as [`value`](Self::value) does.
    pub fn apply(self, layer: &mut [f32]) {
        match self {
            Self::Tanh => layer.iter_mut().for_each(|x| *x = tanh(*x)),
            Self::Linear => {}
            Self::Logistic => layer.iter_mut().for_each(|x| *x = logistic(*x)),
            Self::Relu => layer.iter_mut().for_each(|x| *x = relu(*x)),
        }
    }

    /// The name used in model files: `tanh`, `linear`, `logistic` or `relu`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Tanh => "tanh",
            Self::Linear => "linear",
            Self::Logistic => "logistic",
            Self::Relu => "relu",
        }
    }
}

impl fmt::Display for Activation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A text that names no activation function.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("unknown activation function (known: tanh, linear, logistic, relu)")]
pub struct UnknownActivation;

impl FromStr for Activation {
    type Err = UnknownActivation;

    fn from_str(text: &str) -> Result<Self, UnknownActivation> {
        Self::ALL.into_iter().find(|known| known.name() == text).ok_or(UnknownActivation)
    }
}

/// The one tanh of the 32-bit forward pass.
#[inline]
fn tanh(x: f32) -> f32 {
    libm::tanhf(x)
}

#[inline]
fn logistic(x: f32) -> f32 {
    0.5 + 0.5 * tanh(0.5 * x)
}

#[inline]
fn relu(x: f32) -> f32 {
    if x < 0.0 { 0.0 } else { x }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reference(activation: Activation, x: f64) -> f64 {
        match activation {
            Activation::Tanh => x.tanh(),
            Activation::Linear => x,
            Activation::Logistic => 1.0 / (1.0 + (-x).exp()),
            Activation::Relu => x.max(0.0),
        }
    }

    #[test]
    fn values_agree_with_the_definitions_in_double_precision() {
        for activation in Activation::ALL {
            for step in -400_i16..=400 {
                let x = f32::from(step) * 0.05;
                let error = f64::from(activation.value(x)) - reference(activation, f64::from(x));
                assert!(error.abs() < 1.2e-7, "{activation} at {x}: error {error:e}");
            }
        }
    }

    #[test]
    fn the_extremes_are_finite_and_nan_stays_nan() {
        for activation in Activation::ALL {
            for x in [f32::MAX, f32::MIN, f32::MIN_POSITIVE, 1e-45, -0.0] {
                assert!(activation.value(x).is_finite(), "{activation} at {x}");
            }
            assert!(activation.value(f32::NAN).is_nan(), "{activation} of NaN");
        }
    }

    #[test]
    fn names_are_read_back() {
        for activation in Activation::ALL {
            assert_eq!(activation.name().parse(), Ok(activation));
        }
        assert_eq!("Tanh".parse::<Activation>(), Err(UnknownActivation));
    }
}
