//! The reciprocal split in two digit widths throughout.

use super::{
    TangentSum,
    ratio::{Cot, Term},
};
use crate::esc::{Esc, Reading, Trial, double::Double, enclosure::Tangent, real::Real};

/// The running sum of Eq. 1 in two numbers of the format `T`: with `f64` about 31 digits of S, and the value rounded once.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PreciseSum<T = f64> {
    n: u32,
    degenerate: u32,
    unknown: bool,
    sum: Double<T>,
    turns: T,
    error: Double<T>,
    sensitivity: Double<T>,
    sensitivity_squared: Double<T>,
}

impl<T: Real> PreciseSum<T> {
    /// Adds an irregularity as [`super::LiteralSum::push`] does.
    pub fn push(&mut self, delta_m: T, spacing_m: T) -> bool {
        match Term::of(delta_m, spacing_m) {
            Term::Degenerate => {
                self.degenerate = self.degenerate.saturating_add(1);
                return false;
            }
            Term::Unknown => self.unknown = true,
            Term::Known(Cot { value, error, sensitivity }) => {
                self.sum = self.sum.plus(value);
                let rounding = T::ROUNDOFF * T::ROUNDOFF * T::of(8.0);
                self.error.tally(error + rounding * (T::ONE + self.sum.hi.abs()));
                self.sensitivity.tally(sensitivity);
                self.sensitivity_squared.tally(sensitivity * sensitivity);
            }
        }
        self.n = self.n.saturating_add(1);
        if self.sum.hi.abs() > T::REDUCE_ABOVE {
            self.reduce();
        }
        true
    }

    fn reduce(&mut self) {
        let (rest, turns) = self.sum.reduced();
        self.sum = rest;
        self.turns = self.turns + turns;
    }

    /// Irregularities in the sum.
    #[must_use]
    pub fn n(&self) -> u32 {
        self.n
    }

    /// E_sc as printed (W), as [`super::LiteralSum::value`].
    #[must_use]
    pub fn value(&self, trial: &Trial<T>) -> Option<Esc<T>> {
        if self.n == 0 {
            return None;
        }
        let mut last = *self;
        last.reduce();
        let u2 = T::ROUNDOFF * T::ROUNDOFF;
        // A relative error d of tan x is that of an angle off by at most d |x|.
        let bound = last.error.total() * T::of(1.001) + T::of(1024.0) * u2 * last.sum.hi.abs();
        let bound = if last.unknown { T::ONE / T::ZERO } else { bound };
        let [pi, ..] = T::PI;
        let squares = last.sensitivity_squared.total();
        TangentSum {
            reading: Reading::Literal,
            n: last.n,
            degenerate: last.degenerate,
            sum: last.sum.hi + last.turns * pi,
            tangent: Tangent::double(last.sum, bound),
            sigma_s: if last.unknown {
                T::ONE / T::ZERO
            } else {
                trial.noise.deviation(squares, last.sensitivity.total())
            },
        }
        .times(trial)
    }
}
