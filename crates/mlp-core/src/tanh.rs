//! Hyperbolic tangents of the sums of neurons: a fast one, an exact one and one in double precision.
//!
//! | function | precision | largest error | checked by |
//! |---|---|---|---|
//! | [`rational`] | `f32` | 3.5 ulp, fused or not | `tanh-exhaustive` of the benches, every value in [-12, 12] |
//! | [`exact`] | `f32` | 0.501 ulp | the same |
//! | [`double`] | `f64` | 3 ulp | `error_of_double_is_within_three_ulp` |
//!
//! All are odd, at most 1 in size, keep NaN, have no branch and no table and call no platform function: compilers
//! vectorise them, and results repeat bit for bit on every machine.

/// From here on the result of [`rational`] is that of this argument, which rounds to 1.
pub const LIMIT: f32 = 9.0;

/// `P(x^2)`, lowest power first. Coefficients from a weighted least-squares search (decision 0042).
pub const NUMERATOR: [f32; 3] = [0.922_147_4, 0.027_452_586, 0.000_105_296_96];

/// `Q(x^2)`, lowest power first; its first value is twice that of [`NUMERATOR`], so that `tanh x = x` for small `x`.
pub const DENOMINATOR: [f32; 4] = [1.844_294_8, 0.208_596_32, 0.002_224_575_5, 2.264_456_3e-6];

/// The hyperbolic tangent as a rational function, in 19 operations.
///
/// With `n = x P(x^2)` and `q = Q(x^2)`, `n / q` approximates `tanh(x / 2)` (relative error 7e-9 over
/// `1 / cosh x`) and `tanh x = 2 n q / (n^2 + q^2)`. The detour by half the argument costs three operations and
/// saves four, and it damps the rounding of `n` and `q` by `1 / cosh x`: a rational function of degrees 9 and 8
/// for `tanh x` itself stays at 4.8 ulp fused and 5.2 ulp without fused multiply-add. The first terms of `Q` are summed in
/// pairs, so that it takes no longer than `n`, and the sign is put back last: in a single forward pass each operation waits for the
/// one before. (Summing `P` in pairs too costs 0.4 ulp.)
#[must_use]
#[inline(always)]
pub fn rational(x: f32) -> f32 {
    let size = x.abs();
    // Not `clamp` or `min`, so that NaN stays.
    let size = if size > LIMIT { LIMIT } else { size };
    let square = size * size;
    let fourth = square * square;
    let [p0, p1, p2] = NUMERATOR;
    let [q0, q1, q2, q3] = DENOMINATOR;
    let n = size * ((p2 * square + p1) * square + p0);
    let q = ((q3 * square + q2) * fourth + q1 * square) + q0;
    let y = (n * (q + q)) / (n * n + q * q);
    (if y > 1.0 { 1.0 } else { y }).copysign(x)
}

/// The hyperbolic tangent to 0.501 ulp: [`double`], rounded. Two to four times as slow as [`rational`]; on a
/// microcontroller with single precision only, hundreds of times.
#[must_use]
#[inline]
#[expect(clippy::cast_possible_truncation, reason = "rounding to single precision is meant")]
pub fn exact(x: f32) -> f32 {
    double(f64::from(x)) as f32
}

/// Beyond this the result of [`double`] is 1.
const SATURATION: f64 = 20.0;

/// Adding it leaves a number's nearest integer in the low bits of the sum.
const ROUNDER: f64 = 6_755_399_441_055_744.0;

/// High part of ln 2, short enough that its product with `k` is exact.
const LN_2_HIGH: f64 = f64::from_bits(0x3FE6_2E42_FEFA_3800);

/// The rest of ln 2.
const LN_2_LOW: f64 = 5.497_923_018_708_371e-14;

/// Taylor series of `(r coth(r / 2) - 2) / r^2` in `r^2`, highest power first: `2 B_2n / (2n)!` for n = 6 down to 1 with
/// the Bernoulli numbers. For `|r| <= ln 2 / 2` the first term left out is below 6e-18 of `r coth(r / 2)`.
const COTH: [f64; 6] = [
    -691.0 / 653_837_184_000.0,
    1.0 / 23_950_080.0,
    -1.0 / 604_800.0,
    1.0 / 15_120.0,
    -1.0 / 360.0,
    1.0 / 6.0,
];

/// The hyperbolic tangent in double precision.
///
/// `2|x| = k ln 2 + r` with `|r| <= ln 2 / 2`; with `p = 2^k` and `A = r coth(r / 2)` the addition theorem gives
/// `tanh |x| = ((p - 1) A + (p + 1) r) / ((p + 1) A + (p - 1) r)`: a short even series and one division. `A - 2` is
/// at most 0.02, and adding the 2 last keeps its rounding out of the difference above the line.
#[must_use]
#[inline(always)]
pub fn double(x: f64) -> f64 {
    double_by(x, |a, b, c| a * b + c)
}

/// [`double`] with a given way to compute `a b + c`.
#[must_use]
#[inline(always)]
pub fn double_by(x: f64, mul_add: impl Fn(f64, f64, f64) -> f64) -> f64 {
    let size = x.abs();
    // Not `min`, which would turn NaN into the limit.
    let twice = 2.0 * if size > SATURATION { SATURATION } else { size };
    let shifted = mul_add(twice, core::f64::consts::LOG2_E, ROUNDER);
    let k = shifted - ROUNDER;
    let r = mul_add(k, -LN_2_LOW, mul_add(k, -LN_2_HIGH, twice));
    let square = r * r;
    let [first, rest @ ..] = COTH;
    let mut a = first;
    for term in rest {
        a = mul_add(a, square, term);
    }
    let a = a * square;
    let power = f64::from_bits(shifted.to_bits().wrapping_add(1023) << 52);
    let (less, more) = (power - 1.0, power + 1.0);
    let above = mul_add(2.0, less, mul_add(more, r, less * a));
    let below = mul_add(2.0, more, mul_add(less, r, more * a));
    let y = above / below;
    (if y > 1.0 { 1.0 } else { y }).copysign(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn error_of_double_is_within_three_ulp() {
        type Way = fn(f64) -> f64;
        let ways: [(&str, Way); 2] = [("plain", double), ("fused", |x| double_by(x, libm::fma))];
        for (name, tanh) in ways {
            let mut worst = (0.0, 0.0);
            // Sizes from 1e-12 to 25, finely enough to meet every k many times.
            for step in 0..400_000_u32 {
                let x = 1e-12 * (f64::from(step) * 7.71e-5).exp();
                let reference = libm::tanh(x);
                let ulp = f64::from_bits(reference.to_bits() + 1) - reference;
                let y = tanh(x);
                let error = (y - reference).abs() / ulp;
                if error > worst.0 {
                    worst = (error, x);
                }
                assert!(y <= 1.0, "{name}: {y} at {x}");
            }
            eprintln!("{name}: largest deviation from libm {} ulp at {}", worst.0, worst.1);
            assert!(worst.0 <= 3.0, "{name}: {worst:?}");
        }
    }

    #[test]
    fn odd_bounded_and_nan() {
        for x in [0.0, 1e-300, 5e-324, 0.3, 19.9, 20.1, 1e308, f64::INFINITY] {
            assert_eq!(double(-x).to_bits(), (-double(x)).to_bits(), "{x}");
            assert!((0.0..=1.0).contains(&double(x)), "{x}");
        }
        assert_eq!(double(5e-324).to_bits(), 1, "denormals stay");
        assert!(double(f64::NAN).is_nan());
    }

    /// Error of `y` in units of the last place of the rounded reference.
    fn ulp(y: f32, reference: f64) -> f64 {
        #[expect(
            clippy::cast_possible_truncation,
            reason = "the unit is that of the rounded value"
        )]
        let rounded = (reference as f32).abs();
        let unit = f32::from_bits(rounded.to_bits() + 1) - rounded;
        (f64::from(y) - reference).abs() / f64::from(unit)
    }

    /// Every 997th value; `tanh-exhaustive` of the benches looks at all of them.
    #[test]
    fn rational_and_exact_are_within_their_bounds() {
        let (mut rational_worst, mut exact_worst, mut highest) = (0.0_f64, 0.0_f64, 0.0_f32);
        for bits in (0..=12_f32.to_bits()).step_by(997) {
            let x = f32::from_bits(bits);
            let reference = libm::tanh(f64::from(x));
            let y = rational(x);
            assert!((0.0..=1.0).contains(&y), "{x}: {y}");
            assert_eq!(rational(-x).to_bits(), (-y).to_bits(), "odd at {x}");
            assert!(y >= highest * (1.0 - 5e-7), "falls at {x}");
            highest = highest.max(y);
            rational_worst = rational_worst.max(ulp(y, reference));
            exact_worst = exact_worst.max(ulp(exact(x), reference));
        }
        eprintln!("rational {rational_worst:.3} ulp, exact {exact_worst:.4} ulp");
        assert!(rational_worst <= 3.5 && exact_worst <= 0.501, "{rational_worst} {exact_worst}");
    }

    #[test]
    fn rational_and_exact_keep_nan_and_saturate() {
        for f in [rational, exact] {
            assert!(f(f32::NAN).is_nan() && f(-f32::NAN).is_nan());
            for x in [12.0, 1e30, f32::MAX, f32::INFINITY] {
                assert!((f(x) - 1.0).abs() < 1e-7 && (f(-x) + 1.0).abs() < 1e-7, "{x}");
            }
            assert_eq!((f(0.0).to_bits(), f(-0.0).to_bits()), (0, 0x8000_0000));
            for x in [1e-45_f32, 1e-38, 1e-20] {
                assert!(f(x).to_bits().abs_diff(x.to_bits()) <= 1, "{x:e}: {:e}", f(x));
            }
        }
    }
}
