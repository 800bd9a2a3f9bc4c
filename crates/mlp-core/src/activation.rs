//! Sum of a neuron's weighted inputs in, its output out.

use core::fmt;
use core::str::FromStr;

use crate::tanh;

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

    /// The function's value at `x` with [`tanh::rational`]; NaN stays NaN.
    #[must_use]
    pub fn value(self, x: f32) -> f32 {
        of(self, x, tanh::rational)
    }

    /// The function's value at `x` with [`tanh::exact`]; NaN stays NaN.
    #[must_use]
    pub fn exact(self, x: f32) -> f32 {
        of(self, x, tanh::exact)
    }

    /// The function's value at `x` in double precision; NaN stays NaN.
    #[must_use]
    pub fn double(self, x: f64) -> f64 {
        of(self, x, tanh::double)
    }

    /// Replaces every sum in `layer` by the function's value, as [`value`](Self::value) does.
    #[inline]
    pub fn apply(self, layer: &mut [f32]) {
        apply(self, layer, tanh::rational);
    }

    /// The same as [`exact`](Self::exact) does.
    pub fn apply_exact(self, layer: &mut [f32]) {
        apply(self, layer, tanh::exact);
    }

    /// The same in double precision.
    pub fn apply_double(self, layer: &mut [f64]) {
        apply(self, layer, tanh::double);
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

/// A precision of the forward pass: `f32` or `f64`.
pub(crate) trait Number:
    Copy + PartialOrd + core::ops::Add<Output = Self> + core::ops::Mul<Output = Self>
{
    const ZERO: Self;
    /// Adding it changes nothing, not even the sign of a zero, so that compilers leave the addition out.
    const NOTHING: Self;
    const HALF: Self;

    fn from_weight(weight: f32) -> Self;
}

impl Number for f32 {
    const ZERO: Self = 0.0;
    const NOTHING: Self = -0.0;
    const HALF: Self = 0.5;

    #[inline(always)]
    fn from_weight(weight: f32) -> Self {
        weight
    }
}

impl Number for f64 {
    const ZERO: Self = 0.0;
    const NOTHING: Self = -0.0;
    const HALF: Self = 0.5;

    #[inline(always)]
    fn from_weight(weight: f32) -> Self {
        Self::from(weight)
    }
}

#[inline(always)]
fn of<N: Number>(activation: Activation, x: N, tanh: impl Fn(N) -> N) -> N {
    match activation {
        Activation::Tanh => tanh(x),
        Activation::Linear => x,
        Activation::Logistic => logistic(x, tanh),
        Activation::Relu => relu(x),
    }
}

#[inline(always)]
fn apply<N: Number>(activation: Activation, layer: &mut [N], tanh: impl Fn(N) -> N) {
    match activation {
        Activation::Tanh => by_four(layer, tanh),
        Activation::Linear => {}
        Activation::Logistic => by_four(layer, |x| logistic(x, &tanh)),
        Activation::Relu => layer.iter_mut().for_each(|x| *x = relu(*x)),
    }
}

/// Replaces each value, four at a time and the last ones beside zeros, so that all go through whole vectors.
#[inline(always)]
fn by_four<N: Number>(layer: &mut [N], f: impl Fn(N) -> N) {
    let (whole, rest) = layer.as_chunks_mut::<4>();
    for x in whole.as_flattened_mut() {
        *x = f(*x);
    }
    if let [a] = rest {
        *a = f(*a);
    } else if !rest.is_empty() {
        let mut four = [N::ZERO; 4];
        for (place, x) in four.iter_mut().zip(&*rest) {
            *place = *x;
        }
        // Not `map`, which is not always inlined.
        for x in &mut four {
            *x = f(*x);
        }
        for (place, y) in rest.iter_mut().zip(four) {
            *place = y;
        }
    }
}

#[inline(always)]
fn logistic<N: Number>(x: N, tanh: impl Fn(N) -> N) -> N {
    N::HALF + N::HALF * tanh(N::HALF * x)
}

#[inline(always)]
fn relu<N: Number>(x: N) -> N {
    if x < N::ZERO { N::ZERO } else { x }
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
            for step in -180_i16..=180 {
                let x = f32::from(step) * 0.05;
                let expected = reference(activation, f64::from(x));
                for (value, bound) in [
                    (f64::from(activation.value(x)), 2.1e-7),
                    (f64::from(activation.exact(x)), 6.1e-8),
                    (activation.double(f64::from(x)), 5e-16),
                ] {
                    let error = value - expected;
                    assert!(error.abs() < bound, "{activation} at {x}: error {error:e}");
                }
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
