//! Signs of the gradient in, steps of adapted length out: resilient propagation.
//!
//! Riedmiller and Braun (1993), variants after Igel and Huesken (2003).

use core::fmt;
use core::str::FromStr;

use pulp::{Simd, WithSimd};

use super::{Isa, Objective, Real, StepReport, Trainer, norm};

/// What happens to a weight whose gradient changed its sign, besides a shorter next step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum RpropVariant {
    /// Rprop-: it moves on with the shorter step.
    Minus,
    /// Rprop+: its last move is undone.
    Plus,
    /// iRprop-: it rests for one epoch.
    #[default]
    ImprovedMinus,
    /// iRprop+: its last move is undone if the error rose, otherwise it rests.
    ImprovedPlus,
}

impl RpropVariant {
    /// All variants.
    pub const ALL: [Self; 4] = [Self::Minus, Self::Plus, Self::ImprovedMinus, Self::ImprovedPlus];

    /// The usual name: `rprop-`, `rprop+`, `irprop-` or `irprop+`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Minus => "rprop-",
            Self::Plus => "rprop+",
            Self::ImprovedMinus => "irprop-",
            Self::ImprovedPlus => "irprop+",
        }
    }
}

impl fmt::Display for RpropVariant {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A text that names no variant of RPROP.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("unknown variant \"{text}\" (known: rprop-, rprop+, irprop-, irprop+)")]
pub struct UnknownVariant {
    /// The text given.
    pub text: String,
}

impl FromStr for RpropVariant {
    type Err = UnknownVariant;

    fn from_str(text: &str) -> Result<Self, UnknownVariant> {
        Self::ALL
            .into_iter()
            .find(|known| known.name() == text)
            .ok_or_else(|| UnknownVariant { text: text.to_owned() })
    }
}

/// Settings of [`Rprop`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RpropConfig {
    /// Which rule. Default iRprop-.
    pub variant: RpropVariant,
    /// First step length. Default 0.07.
    pub initial: f64,
    /// Factor while the sign stays. Default 1.2.
    pub increase: f64,
    /// Factor when the sign changes. Default 0.5.
    pub decrease: f64,
    /// Longest step. Default 50.
    pub max: f64,
    /// Shortest step. Default 1e-6.
    pub min: f64,
}

impl Default for RpropConfig {
    fn default() -> Self {
        Self {
            variant: RpropVariant::ImprovedMinus,
            initial: 0.07,
            increase: 1.2,
            decrease: 0.5,
            max: 50.0,
            min: 1e-6,
        }
    }
}

/// Resilient propagation: step lengths per weight that grow while the gradient keeps its sign and shrink when
/// it changes; the gradient's size plays no part.
#[derive(Debug, Clone)]
pub struct Rprop<T = f64> {
    isa: Isa,
    config: RpropConfig,
    gradient: Vec<T>,
    memory: Memory<T>,
    last_mse: f64,
}

/// Memory of all weights.
#[derive(Debug, Clone)]
struct Memory<T> {
    /// Lengths of their steps.
    lengths: Vec<T>,
    /// Signs of the gradients of the last epoch, or 0 where the rule forgets them.
    signs: Vec<T>,
    /// Last moves.
    steps: Vec<T>,
}

impl<T: Real> Rprop<T> {
    /// Ready for the first step on `weights` weights.
    #[must_use]
    pub fn new(config: RpropConfig, weights: usize) -> Self {
        let zeros = vec![T::default(); weights];
        let lengths = vec![T::of(config.initial); weights];
        Self {
            isa: Isa::detect(),
            config,
            gradient: zeros.clone(),
            memory: Memory { lengths, signs: zeros.clone(), steps: zeros },
            last_mse: f64::INFINITY,
        }
    }
}

/// The moves of all weights. No branch depends on a weight, so that compilers turn the loop into vectors.
struct Advance<'a, T> {
    config: RpropConfig,
    /// The error rose since the last epoch.
    rose: bool,
    gradient: &'a [T],
    memory: &'a mut Memory<T>,
    weights: &'a mut [T],
}

impl<T: Real> WithSimd for Advance<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { config, rose, gradient, memory, weights } = self;
        let (zero, one) = (T::of(0.0), T::of(1.0));
        let (increase, decrease) = (T::of(config.increase), T::of(config.decrease));
        let (min, max) = (T::of(config.min), T::of(config.max));
        let forgets = config.variant != RpropVariant::Minus;
        // What a weight does whose gradient turned, as a share of its last move.
        let back = match config.variant {
            RpropVariant::Plus => -one,
            RpropVariant::ImprovedPlus if rose => -one,
            _ => zero,
        };
        let lengths = memory.lengths.iter_mut();
        let memories = lengths.zip(memory.signs.iter_mut()).zip(memory.steps.iter_mut());
        for ((weight, ((length, last), step)), &g) in weights.iter_mut().zip(memories).zip(gradient)
        {
            let sign = if g > zero { one } else { zero };
            let sign = if g < zero { -one } else { sign };
            let agreement = sign * *last;
            let turned = agreement < zero;
            let factor = if agreement > zero { increase } else { one };
            let factor = if turned { decrease } else { factor };
            let scaled = *length * factor;
            let scaled = if scaled > max { max } else { scaled };
            let scaled = if scaled < min { min } else { scaled };
            let forward = -(scaled * sign);
            let rest = turned && forgets;
            let moved = if rest { back * *step } else { forward };
            *length = scaled;
            *last = if rest { zero } else { sign };
            *step = moved;
            *weight += moved;
        }
    }
}

impl<T: Real> Trainer<T> for Rprop<T> {
    fn step(&mut self, objective: &mut dyn Objective<T>, weights: &mut [T]) -> StepReport {
        let Self { isa, config, gradient, memory, last_mse } = self;
        let mse = objective.gradient(weights, gradient);
        let rose = mse > *last_mse;
        *last_mse = mse;
        isa.dispatch(Advance { config: *config, rose, gradient, memory, weights });
        StepReport::moved(mse, norm(*isa, gradient))
    }
}
