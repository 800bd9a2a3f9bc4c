//! Numbers as they are in, values of E_sc to 67 digits out: the reference of the accuracy and the stress programs.
//!
//! Everything goes through `dashu-float`, whose functions are correctly rounded at any precision, and shares no
//! formula with the evaluators it judges: cot is cos/sin of the ratio itself. [`angle`] makes it fast enough for millions.

pub mod angle;
pub mod pool;
pub mod trial;

use dashu_float::{FBig, round::mode::HalfEven};

/// A number of [`BITS`] binary digits.
pub type Exact = FBig<HalfEven, 2>;

/// 224 binary digits are 67 decimal ones.
pub const BITS: usize = 224;

/// `value` itself.
///
/// # Panics
/// For a number that is not finite.
#[must_use]
#[expect(clippy::expect_used, reason = "the programs draw finite numbers only")]
pub fn exact(value: f64) -> Exact {
    Exact::try_from(value).expect("a finite number").with_precision(BITS).value()
}

/// delta/s.
#[must_use]
pub fn ratio(delta: f64, spacing: f64) -> Exact {
    exact(delta) / exact(spacing)
}

/// cot(delta/s).
#[must_use]
pub fn cot(delta: f64, spacing: f64) -> Exact {
    angle::cot(&ratio(delta, spacing))
}

/// The angle below pi/2 whose cotangent is delta/s.
#[must_use]
pub fn arc_cot(delta: f64, spacing: f64) -> Exact {
    angle::arc_tan(&ratio(spacing, delta))
}

/// The nearest `f64`.
#[must_use]
pub fn to_f64(value: &Exact) -> f64 {
    value.to_f64().value()
}

/// |got - wanted| / |wanted|, and 1 where that is not a number.
#[must_use]
pub fn relative_error(got: f64, wanted: &Exact) -> f64 {
    if !got.is_finite() {
        return 1.0;
    }
    let error = to_f64(&((exact(got) - wanted) / wanted)).abs();
    if error.is_finite() { error } else { 1.0 }
}
