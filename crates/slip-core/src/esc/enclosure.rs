//! The tangent of an angle with a bound on its error, and what is certain of it.

use super::{double::Double, real::Real};

/// tan of an angle that is known within a bound.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tangent<T> {
    /// The value to two digit widths where the path has them.
    pub(super) value: Double<T>,
    /// Below every possible value.
    pub(super) lo: T,
    /// Above every possible value.
    pub(super) hi: T,
    /// A pole may lie within the bound: every value is possible.
    pub(super) pole: bool,
}

impl<T: Real> Tangent<T> {
    /// tan of `x` (-pi/2 to pi/2) in one digit width, where the true angle lies within `bound` of it.
    pub(super) fn single(x: Double<T>, bound: T) -> Self {
        let magnitude = if x.hi < T::ZERO { x.neg() } else { x };
        let t = if magnitude.hi <= T::of(core::f32::consts::FRAC_PI_4) {
            T::tan_first(magnitude.hi, magnitude.lo)
        } else {
            T::ONE
                / away_from_zero({
                    let rest = magnitude.complement();
                    T::tan_first(rest.hi, rest.lo)
                })
        };
        let t = if x.hi < T::ZERO { -t } else { t };
        Self::around(Double::from(t), T::of(8.0) * T::ROUNDOFF, bound)
    }

    /// The same in two digit widths.
    pub(super) fn double(x: Double<T>, bound: T) -> Self {
        let t = x.tan();
        let limit = T::ONE / (T::ROUNDOFF * T::ROUNDOFF);
        let t = if t.hi.abs() <= limit {
            t
        } else {
            Double::from(if x.hi < T::ZERO { -limit } else { limit })
        };
        Self::around(t, T::ROUNDOFF, bound)
    }

    /// From a tangent with relative error `relative` and an angle with error `bound`:
    /// tan(x + b) = t + (1 + t^2) tan b / (1 - t tan b), so one tangent gives both ends.
    fn around(value: Double<T>, relative: T, bound: T) -> Self {
        let t = value.hi;
        let rise = T::ONE + t * t;
        // An error of the tangent is an error of the angle: d tan x = (1 + t^2) dx.
        let angle = (bound + relative * (t.abs() / rise)) * T::of(1.001);
        let pole = !(angle < T::of(0.5) && t.abs() * angle < T::of(0.75));
        if pole {
            let everything = T::ONE / T::ZERO;
            return Self { value, lo: -everything, hi: everything, pole };
        }
        // tan b < b (1 + b^2) up to 0.5.
        let b = angle * (T::ONE + angle * angle);
        let away = rise * b * (T::ONE + T::of(64.0) * T::ROUNDOFF);
        let hi = (t + away / (T::ONE - t * b)).next_up().next_up();
        let lo = (t - away / (T::ONE + t * b)).next_down().next_down();
        Self { value, lo, hi, pole }
    }
}

/// A divisor that is not zero: next to a pole the tangent ends at 1/u^2.
fn away_from_zero<T: Real>(x: T) -> T {
    let least = T::ROUNDOFF * T::ROUNDOFF;
    if x.abs() >= least {
        x
    } else if x < T::ZERO {
        -least
    } else {
        least
    }
}

/// Both ends times `scale`, which is known within 4 roundoffs and the smallest number, rounded outwards.
pub(super) fn scaled<T: Real>(lo: T, hi: T, scale: T) -> (T, T) {
    let (a, b) = if scale < T::ZERO { (hi, lo) } else { (lo, hi) };
    (outwards(a, scale, -T::ONE), outwards(b, scale, T::ONE))
}

fn outwards<T: Real>(end: T, scale: T, direction: T) -> T {
    if scale == T::ZERO && !end.is_finite() {
        return T::ZERO;
    }
    let product = end * scale;
    let margin = T::of(8.0) * T::ROUNDOFF * product.abs() + (end.abs() + T::of(2.0)) * T::TINIEST;
    if margin.is_finite() { product + direction * margin } else { product }
}
