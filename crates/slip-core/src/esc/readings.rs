//! The readings of E_sc beside the literal one: running sums in constant memory, values with enclosures.
//!
//! All terms are positive, so nothing cancels: the sums of slopes, heights and delta^2/s are certain to a few
//! roundoffs, and so is the sum of arccotangents S = n pi/2 - sum atan(delta/s), whose tangent is -tan A for even and cot A for
//! odd n with A = sum atan. Lengths shorter than 1e-120 m or longer than 1e120 m leave the
//! enclosures of the proportional readings open.

use super::{
    Esc, Flag, Flags, Reading, Trial,
    double::{Double, two_sum},
    enclosure::{Tangent, scaled},
    literal::TangentSum,
    real::Real as _,
};

const U: f64 = f64::ROUNDOFF;
/// Terms are exact to 2 roundoffs, the constant, the products and the rounded sum to another 8.
const RELATIVE: f64 = 12.0 * U;
/// Lengths from here to the inverse of it neither over- nor underflow in any term.
const LEAST_M: f64 = 1e-120;

/// Counts, and the figures common to every sum of positive terms.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Terms {
    n: u32,
    degenerate: u32,
    open: bool,
    sum: Double<f64>,
    squares: f64,
}

impl Terms {
    /// Whether the lengths make an irregularity; counted if not.
    fn admits(&mut self, delta_m: f64, spacing_m: f64) -> bool {
        let valid = |length: f64| length > 0.0 && length.is_finite();
        if !(valid(delta_m) && valid(spacing_m)) {
            self.degenerate = self.degenerate.saturating_add(1);
            return false;
        }
        let ordinary = |length: f64| (LEAST_M..=1.0 / LEAST_M).contains(&length);
        self.open |= !(ordinary(delta_m) && ordinary(spacing_m));
        true
    }

    /// Adds a term, and how it answers to a relative error of the ratio.
    fn add(&mut self, term: f64, answer: f64) {
        let (hi, rest) = two_sum(self.sum.hi, term);
        self.sum = Double { hi, lo: self.sum.lo + rest };
        self.squares += answer * answer;
        self.n = self.n.saturating_add(1);
    }

    /// `scale` times the sum; `None` where nothing was added or the value is not finite.
    fn proportional(&self, reading: Reading, scale: f64, trial: &Trial) -> Option<Esc> {
        let sum = self.sum.total();
        let value = scale * sum;
        if self.n == 0 || !(value.is_finite() && scale.is_finite() && sum.is_finite()) {
            return None;
        }
        let (lo, hi) = if self.open {
            let everything = if scale < 0.0 { f64::NEG_INFINITY } else { f64::INFINITY };
            (everything.min(0.0), everything.max(0.0))
        } else {
            scaled(sum * (1.0 - RELATIVE), sum * (1.0 + RELATIVE), scale)
        };
        let sigma_s = trial.noise.deviation(self.squares / (sum * sum), 1.0);
        let flags = Flags::default()
            .with(Flag::SignUnknown, lo <= 0.0 && hi >= 0.0)
            .with(Flag::NoInformation, sigma_s > 1.0 || !sigma_s.is_finite())
            .with(Flag::Degenerate, self.degenerate > 0);
        let (n, degenerate) = (self.n, self.degenerate);
        Some(Esc { reading, value, lo, hi, n, degenerate, sum, condition: 1.0, sigma_s, flags })
    }
}

/// n F v tan(sum arccot(delta/s)) (W).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ArcCotSum {
    terms: Terms,
    answers: f64,
}

impl ArcCotSum {
    /// Adds an irregularity; `false` where it is degenerate and left out.
    pub fn push(&mut self, delta_m: f64, spacing_m: f64) -> bool {
        let open = self.terms.open;
        if !self.terms.admits(delta_m, spacing_m) {
            return false;
        }
        let r = delta_m / spacing_m;
        // Only the ratio counts here, and a normal one is rounded once.
        self.terms.open = open || !r.is_normal();
        // d arccot(r) / d ln r; for steep r written so that r^2 does not overflow.
        let answer = if r > 1.0 { 1.0 / (r + 1.0 / r) } else { r / (1.0 + r * r) };
        self.terms.add(libm::atan(r), answer);
        self.answers += answer;
        true
    }

    /// The value (W); `None` before the first irregularity and where a number is not finite.
    #[must_use]
    pub fn value(&self, trial: &Trial) -> Option<Esc> {
        let Terms { n, degenerate, open, sum, squares } = self.terms;
        if n == 0 {
            return None;
        }
        let total = sum.total();
        let (rest, _) = sum.normal().reduced();
        // The arctangent of libm is good to one last digit, the ratio to half of one.
        let bound = if open { f64::INFINITY } else { 4.0 * U * total + U * U * f64::from(n) };
        let angle = if n % 2 == 0 {
            rest.neg()
        } else if rest.hi < 0.0 {
            rest.neg().complement().neg()
        } else {
            rest.complement()
        };
        TangentSum {
            reading: Reading::ArcCot,
            n,
            degenerate,
            sum: f64::from(n) * core::f64::consts::FRAC_PI_2 - total,
            tangent: Tangent::single(angle, bound),
            sigma_s: trial.noise.deviation(squares, self.answers),
        }
        .times(trial)
    }
}

macro_rules! proportional_reading {
    ($(#[$doc:meta])* $name:ident, $reading:ident, |$delta:ident, $spacing:ident| $term:expr, |$trial:ident| $scale:expr) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, Default, PartialEq)]
        pub struct $name {
            terms: Terms,
        }

        impl $name {
            /// Adds an irregularity; `false` where it is degenerate and left out.
            pub fn push(&mut self, $delta: f64, $spacing: f64) -> bool {
                if !self.terms.admits($delta, $spacing) {
                    return false;
                }
                let term = $term;
                self.terms.add(term, term);
                true
            }

            /// The value; `None` before the first irregularity and where a number is not finite.
            #[must_use]
            pub fn value(&self, $trial: &Trial) -> Option<Esc> {
                self.terms.proportional(Reading::$reading, $scale, $trial)
            }
        }
    };
}

proportional_reading!(
    /// F v sum 2 delta/s (W).
    SlopePowerSum, SlopePower,
    |delta_m, spacing_m| 2.0 * (delta_m / spacing_m),
    |trial| trial.force_n * trial.speed_m_s
);
proportional_reading!(
    /// F sum delta (J).
    LiftWorkSum, LiftWork,
    |delta_m, spacing_m| delta_m,
    |trial| trial.force_n
);
proportional_reading!(
    /// (pi^2/2) c v sum delta^2/s (J).
    ViscousWorkSum, ViscousWork,
    |delta_m, spacing_m| delta_m * (delta_m / spacing_m),
    |trial| 0.5 * core::f64::consts::PI * core::f64::consts::PI * trial.damping_n_s_m * trial.speed_m_s
);
