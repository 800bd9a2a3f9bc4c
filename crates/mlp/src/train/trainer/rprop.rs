//! Resilient propagation: steps of adapted length from the signs of the gradient.
//!
//! Riedmiller and Braun (1993), variants after Igel and Huesken (2003).

use pulp::{Simd, WithSimd};

use super::{Isa, Objective, Real, StepReport, Trainer, norm};

mlp_core::named! {
    "variant",
    /// What happens to a weight whose gradient changed its sign, besides a shorter next step.
    #[derive(Default)]
    pub enum RpropVariant {
        /// Rprop-: it moves on with the shorter step.
        Minus = "rprop-",
        /// Rprop+: its last move is undone.
        Plus = "rprop+",
        /// iRprop-: it rests for one epoch.
        #[default]
        ImprovedMinus = "irprop-",
        /// iRprop+: its last move is undone if the error rose, otherwise it rests.
        ImprovedPlus = "irprop+",
    }
}

/// Shortest step.
const MIN: f64 = 1e-6;

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
}

impl Default for RpropConfig {
    fn default() -> Self {
        Self {
            variant: RpropVariant::ImprovedMinus,
            initial: 0.07,
            increase: 1.2,
            decrease: 0.5,
            max: 50.0,
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
    /// Lengths of the weights' steps.
    lengths: Vec<T>,
    /// Signs of the gradients of the last epoch, or 0 where the rule forgets them.
    signs: Vec<T>,
    /// Last moves.
    steps: Vec<T>,
    last_mse: f64,
}

impl<T: Real> Rprop<T> {
    /// Ready for the first step on `weights` weights.
    #[must_use]
    pub fn new(config: RpropConfig, weights: usize) -> Self {
        let zeros = vec![T::default(); weights];
        Self {
            isa: Isa::detect(),
            config,
            gradient: zeros.clone(),
            lengths: vec![T::of(config.initial); weights],
            signs: zeros.clone(),
            steps: zeros,
            last_mse: f64::INFINITY,
        }
    }
}

/// The moves of all weights. No branch depends on a weight, so that compilers turn the loop into vectors.
struct Advance<'a, T> {
    rule: &'a mut Rprop<T>,
    /// The error rose since the last epoch.
    rose: bool,
    weights: &'a mut [T],
}

impl<T: Real> WithSimd for Advance<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { rule: Rprop { config, gradient, lengths, signs, steps, .. }, rose, weights } =
            self;
        let (zero, one) = (T::of(0.0), T::of(1.0));
        let (increase, decrease) = (T::of(config.increase), T::of(config.decrease));
        let (min, max) = (T::of(MIN), T::of(config.max));
        let forgets = config.variant != RpropVariant::Minus;
        // What a weight does whose gradient turned, as a share of its last move.
        let back = match config.variant {
            RpropVariant::Plus => -one,
            RpropVariant::ImprovedPlus if rose => -one,
            _ => zero,
        };
        let memories = lengths.iter_mut().zip(signs).zip(steps).zip(gradient);
        for (weight, (((length, last), step), g)) in weights.iter_mut().zip(memories) {
            let sign = if *g > zero { one } else { zero };
            let sign = if *g < zero { -one } else { sign };
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
        let mse = objective.gradient(weights, &mut self.gradient);
        let rose = mse > self.last_mse;
        self.last_mse = mse;
        self.isa.dispatch(Advance { rule: &mut *self, rose, weights });
        StepReport::moved(mse, norm(&self.gradient))
    }
}
