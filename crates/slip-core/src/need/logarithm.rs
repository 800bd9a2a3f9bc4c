//! Logarithm and exponential without a branch or a table, so that a loop over candidates takes several at once. Within 3e-7 of the exact value.

use core::f32::consts::{FRAC_1_SQRT_2, LN_2, LOG2_E};

/// The natural logarithm of a normal number above 0. With `x = 2^e (1 + s) / (1 - s)` it is `e ln 2 + 2 artanh s`, and `s` is below 0.172.
#[inline(always)]
pub(super) fn ln(x: f32) -> f32 {
    const MANTISSA: u32 = 0x007f_ffff;
    let low = FRAC_1_SQRT_2.to_bits();
    let over = x.to_bits().wrapping_sub(low);
    #[expect(clippy::cast_precision_loss, clippy::cast_possible_wrap, reason = "-127 to 128")]
    let exponent = ((over as i32) >> 23) as f32;
    let m = f32::from_bits((over & MANTISSA).wrapping_add(low));
    let s = (m - 1.0) / (m + 1.0);
    let s2 = s * s;
    let series = 1.0 + s2 * (1.0 / 3.0 + s2 * (1.0 / 5.0 + s2 * (1.0 / 7.0 + s2 * (1.0 / 9.0))));
    exponent * LN_2 + 2.0 * s * series
}

/// The exponential of a number from -80 to 80, by the first terms of its series about the nearest power of two.
#[inline(always)]
pub(super) fn exp(x: f32) -> f32 {
    /// What is added to this is rounded to whole numbers.
    const ROUNDS: f32 = 12_582_912.0;
    /// `ln 2` in two parts, of which the first has few digits.
    const LN_2_HIGH: f32 = 0.693_359_4;
    const LN_2_LOW: f32 = -2.121_944_4e-4;
    let rounded = x * LOG2_E + ROUNDS;
    let whole = rounded - ROUNDS;
    let t = (x - whole * LN_2_HIGH) - whole * LN_2_LOW;
    let series = 1.0 / 24.0 + t * (1.0 / 120.0 + t * (1.0 / 720.0));
    let series = 1.0 + t * (1.0 + t * (0.5 + t * (1.0 / 6.0 + t * series)));
    let power = rounded.to_bits().wrapping_sub(ROUNDS.to_bits()).wrapping_add(127) << 23;
    series * f32::from_bits(power)
}

#[cfg(test)]
mod tests {
    use super::{exp, ln};

    /// Every 4,099th normal number.
    #[test]
    fn the_logarithm_is_that_of_libm() {
        for bits in (f32::MIN_POSITIVE.to_bits()..=f32::MAX.to_bits()).step_by(4099) {
            let x = f32::from_bits(bits);
            let exact = libm::log(f64::from(x));
            let error = (f64::from(ln(x)) - exact).abs();
            assert!(error <= 3e-7 * exact.abs().max(0.3), "{x}: {} for {exact}", ln(x));
        }
        assert_eq!(ln(1.0).to_bits(), 0.0_f32.to_bits());
    }

    #[test]
    fn the_exponential_is_that_of_libm() {
        for i in -800_000..=800_000_i32 {
            #[expect(clippy::cast_possible_truncation, reason = "a test")]
            let x = (f64::from(i) * 1e-4) as f32;
            let exact = libm::exp(f64::from(x));
            assert!((f64::from(exp(x)) - exact).abs() <= 3e-7 * exact, "{x}: {} {exact}", exp(x));
        }
    }
}
