//! The cotangent of the ratio of a height and a spacing of any size, to two digit widths with a bound.

use crate::esc::{cotangent::SERIES_UP_TO, double::Double, real::Real};

/// cot(delta/s).
#[derive(Clone, Copy, Debug)]
pub(super) struct Cot<T> {
    pub(super) value: Double<T>,
    /// Bound of its error.
    pub(super) error: T,
    /// r csc^2 r: its answer to a relative error of r.
    pub(super) sensitivity: T,
}

/// What a pair of lengths can give.
#[derive(Clone, Copy, Debug)]
pub(super) enum Term<T> {
    /// A length is zero, negative or not finite.
    Degenerate,
    /// The ratio is so large, so small or so close to a multiple of pi that the cotangent mod pi is not known.
    Unknown,
    Known(Cot<T>),
}

impl<T: Real> Term<T> {
    pub(super) fn of(delta: T, spacing: T) -> Self {
        let positive = delta > T::ZERO && spacing > T::ZERO;
        if !(positive && delta.is_finite() && spacing.is_finite()) {
            return Self::Degenerate;
        }
        let (delta, spacing) = rescaled(delta, spacing);
        let r = delta / spacing;
        if !(r > T::ONE / T::HOPELESS && r < T::HOPELESS) {
            return Self::Unknown;
        }
        let u2 = T::ROUNDOFF * T::ROUNDOFF;
        let ratio = Double::ratio(delta, spacing);
        if r <= T::of(SERIES_UP_TO) {
            let q = Double::ratio(spacing, delta);
            let value = q.minus(ratio.h());
            return Self::known(value, r, u2 * (T::of(16.0) * q.hi + T::of(512.0) * r));
        }
        let (rest, _) = ratio.reduced();
        let rest_error = T::of(16.0) * u2 * r;
        if rest.hi.abs() <= T::of(16.0) * rest_error {
            return Self::Unknown;
        }
        let value = rest.cot();
        let slope = T::of(1.5) * (T::ONE + value.hi * value.hi);
        Self::known(value, r, slope * rest_error + T::of(512.0) * u2 * value.hi.abs())
    }

    fn known(value: Double<T>, r: T, error: T) -> Self {
        let sensitivity = r * (T::ONE + value.hi * value.hi);
        Self::Known(Cot { value, error, sensitivity })
    }
}

/// Lengths for which no product of the division under- or overflows, with the same ratio; where that cannot be, the
/// ratio is hopeless anyway.
fn rescaled<T: Real>(delta: T, spacing: T) -> (T, T) {
    let [up, down] = T::RESCALE;
    if spacing < T::ONE / T::ORDINARY {
        (delta * up, spacing * up)
    } else if spacing > T::ORDINARY {
        (delta * down, spacing * down)
    } else {
        (delta, spacing)
    }
}
