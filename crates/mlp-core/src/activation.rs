//! Activation functions: the output of a neuron from the sum of its weighted inputs.

use core::ops::{Add, Div, Mul, Neg};

use crate::tanh;

crate::named! {
    "activation function",
    /// Function applied to the weighted sum of a neuron.
    #[cfg_attr(feature = "file", derive(serde::Serialize, serde::Deserialize))]
    #[cfg_attr(feature = "file", serde(rename_all = "lowercase"))]
    pub enum Activation {
        /// Hyperbolic tangent, range (-1, 1).
        Tanh = "tanh",
        /// Identity, unlimited range.
        Linear = "linear",
        /// Logistic sigmoid `1 / (1 + exp(-x))`, range (0, 1).
        Logistic = "logistic",
        /// `max(0, x)`, range [0, inf).
        Relu = "relu",
    }
}

impl Activation {
    /// The function's value at `x` with [`tanh::rational`]; NaN stays NaN.
    #[must_use]
    pub fn value(self, x: f32) -> f32 {
        self.by(x, tanh::rational)
    }

    /// The function's value at `x` in double precision; NaN stays NaN.
    #[must_use]
    pub fn double(self, x: f64) -> f64 {
        self.by(x, tanh::double)
    }

    #[inline(always)]
    fn by<N: Number>(self, x: N, tanh: impl Fn(N) -> N) -> N {
        match self {
            Self::Tanh => tanh(x),
            Self::Linear => x,
            Self::Logistic => logistic(x, tanh),
            Self::Relu => relu(x),
        }
    }

    /// Replaces every sum in `layer` by the function's value.
    #[inline(always)]
    pub(crate) fn apply<N: Number>(self, layer: &mut [N], tanh: impl Fn(N) -> N) {
        match self {
            Self::Tanh => by_four(layer, tanh),
            Self::Linear => {}
            Self::Logistic => by_four(layer, |x| logistic(x, &tanh)),
            Self::Relu => layer.iter_mut().for_each(|x| *x = relu(*x)),
        }
    }
}

/// A precision of the forward pass: `f32` or `f64`.
pub trait Number:
    Copy
    + PartialOrd
    + Add<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// Zero.
    const ZERO: Self;
    /// One.
    const ONE: Self;
    /// A half.
    const HALF: Self;

    /// The same value, exactly.
    fn from_single(value: f32) -> Self;

    /// Natural logarithm.
    #[must_use]
    fn ln(self) -> Self;

    /// Exponential.
    #[must_use]
    fn exp(self) -> Self;
}

macro_rules! number {
    ($type:ident, $ln:ident, $exp:ident) => {
        impl Number for $type {
            const ZERO: Self = 0.0;
            const ONE: Self = 1.0;
            const HALF: Self = 0.5;

            #[inline(always)]
            fn from_single(value: f32) -> Self {
                value.into()
            }

            fn ln(self) -> Self {
                libm::$ln(self)
            }

            fn exp(self) -> Self {
                libm::$exp(self)
            }
        }
    };
}

number!(f32, logf, expf);
number!(f64, log, exp);

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
                    (f64::from(activation.by(x, tanh::exact)), 6.1e-8),
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
        let error = "Tanh".parse::<Activation>().unwrap_err().to_string();
        assert_eq!(error, "unknown activation function (known: tanh, linear, logistic, relu)");
    }
}
