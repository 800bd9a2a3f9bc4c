//! The reciprocal split with the rest h in one digit width.

use super::{
    TangentSum,
    ratio::{Cot, Term},
};
use crate::esc::{
    Esc, Reading, Trial,
    cotangent::SERIES_UP_TO,
    double::{Double, two_prod, two_sum},
    enclosure::Tangent,
    real::Real,
};

/// The running sum of Eq. 1 in the format `T`. See [`super`] for method and bound.
///
/// Its median relative error on ratios of machined surfaces is 5e-17 to 8e-17 in `f64` up to ten irregularities and grows
/// with their number as the condition does; `docs/results.md` has the table.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LiteralSum<T = f64> {
    n: u32,
    degenerate: u32,
    unknown: bool,
    /// Reciprocals since the last reduction.
    quotients: Double<T>,
    /// h since the last reduction.
    series: Double<T>,
    /// What was reduced away, in units of pi.
    turns: T,
    all_quotients: Double<T>,
    all_series: Double<T>,
    steep_error: Double<T>,
    sensitivity: Double<T>,
    sensitivity_squared: Double<T>,
}

impl<T: Real> LiteralSum<T> {
    /// Adds an irregularity of height `delta_m` (m) and spacing `spacing_m` (m) and reports it; one without positive finite
    /// lengths is counted as degenerate and left out.
    #[inline]
    pub fn push(&mut self, delta_m: T, spacing_m: T) -> bool {
        let inverse = T::ONE / delta_m;
        let q = spacing_m * inverse;
        let r = delta_m / spacing_m;
        let shallow = r <= T::of(SERIES_UP_TO) && r > T::ONE / T::HOPELESS;
        // NaN fails every comparison; two negative lengths fail the second.
        if !(shallow && spacing_m > T::ONE / T::ORDINARY && spacing_m < T::ORDINARY) {
            return self.push_any(delta_m, spacing_m);
        }
        let (product, product_lo) = two_prod(q, delta_m);
        let q_lo = ((spacing_m - product) - product_lo) * inverse;
        let h = r.h();
        let (sum, rest) = two_sum(self.quotients.hi, q);
        self.quotients = Double { hi: sum, lo: self.quotients.lo + (rest + q_lo) };
        let (sum, rest) = two_sum(self.series.hi, h);
        self.series = Double { hi: sum, lo: self.series.lo + rest };
        let cot = q - h;
        self.count(r * (T::ONE + cot * cot));
        if self.quotients.hi > T::REDUCE_ABOVE {
            self.reduce();
        }
        true
    }

    #[inline]
    fn count(&mut self, sensitivity: T) {
        self.n = self.n.saturating_add(1);
        self.sensitivity.tally(sensitivity);
        self.sensitivity_squared.tally(sensitivity * sensitivity);
    }

    /// Steep, huge or tiny ratios: in two digit widths.
    #[cold]
    fn push_any(&mut self, delta_m: T, spacing_m: T) -> bool {
        match Term::of(delta_m, spacing_m) {
            Term::Degenerate => {
                self.degenerate = self.degenerate.saturating_add(1);
                return false;
            }
            Term::Unknown => {
                self.unknown = true;
                self.n = self.n.saturating_add(1);
            }
            Term::Known(Cot { value, error, sensitivity }) => {
                self.reduce();
                self.quotients = self.quotients.plus(value);
                let rounding = T::ROUNDOFF * T::ROUNDOFF * T::of(8.0);
                self.steep_error.tally(error + rounding * self.quotients.hi.abs());
                self.count(sensitivity);
                self.reduce();
            }
        }
        true
    }

    /// Brings the sum to -pi/2..pi/2.
    #[cold]
    fn reduce(&mut self) {
        self.all_quotients.tally(self.quotients.hi.abs() + T::of(4.0));
        self.all_series.tally(self.series.hi);
        let sum = self.quotients.normal().minus(self.series.normal());
        let (rest, turns) = sum.reduced();
        self.quotients = rest;
        self.series = Double::default();
        self.turns = self.turns + turns;
    }

    /// Irregularities in the sum.
    #[must_use]
    pub fn n(&self) -> u32 {
        self.n
    }

    /// Irregularities that were left out.
    #[must_use]
    pub fn degenerate(&self) -> u32 {
        self.degenerate
    }

    /// The bound B on the error of S (rad); infinite where a ratio was unknown mod pi.
    #[must_use]
    pub fn bound(&self) -> T {
        let mut last = *self;
        last.reduce();
        last.reduced_bound()
    }

    fn reduced_bound(&self) -> T {
        if self.unknown {
            return T::ONE / T::ZERO;
        }
        let u = T::ROUNDOFF;
        let folds = T::of(3.0) * T::REDUCE_ABOVE * T::REDUCE_ABOVE * T::from_count(self.n);
        let second = T::of(96.0) * self.all_quotients.total() + folds;
        let first = T::of(8.0) * u * self.all_series.total();
        (first + u * u * second + self.steep_error.total()) * T::of(1.001)
    }

    /// E_sc as printed (W) for the force, speed and noise of `trial`; `None` before the first irregularity and where the
    /// value or a number of the trial is not finite.
    #[must_use]
    pub fn value(&self, trial: &Trial<T>) -> Option<Esc<T>> {
        if self.n == 0 {
            return None;
        }
        let mut last = *self;
        last.reduce();
        let bound = last.reduced_bound();
        let [pi, ..] = T::PI;
        let squares = last.sensitivity_squared.total();
        TangentSum {
            reading: Reading::Literal,
            n: last.n,
            degenerate: last.degenerate,
            sum: last.quotients.hi + last.turns * pi,
            tangent: Tangent::single(last.quotients, bound),
            sigma_s: if last.unknown {
                T::ONE / T::ZERO
            } else {
                trial.noise.deviation(squares, last.sensitivity.total())
            },
        }
        .times(trial)
    }
}
