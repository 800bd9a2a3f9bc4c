//! Logarithm and exponential that compile to vector instructions, accurate enough for weights of hypotheses.

/// Natural logarithm of a positive normal number; error below 3e-6, relative above 1.
#[inline(always)]
pub(super) fn ln(x: f32) -> f32 {
    let bits = x.to_bits().cast_signed();
    let exponent = bits.wrapping_sub(0x3f35_04f3) >> 23;
    let mantissa = f32::from_bits(bits.wrapping_sub(exponent << 23).cast_unsigned()) - 1.0;
    let s = mantissa / (2.0 + mantissa);
    let z = s * s;
    let whole = exponent as f32 * core::f32::consts::LN_2;
    whole + s * (2.0 + z * (0.666_666_7 + z * (0.4 + z * 0.2857)))
}

/// Exponential of a number, from -80 to 80; relative error below 3e-5.
#[inline(always)]
pub(super) fn exp(x: f32) -> f32 {
    /// Adding it rounds to the nearest integer, which then stands in the low bits.
    const ROUND: f32 = 12_582_912.0;
    let y = at_most(at_least(x, -80.0), 80.0) * core::f32::consts::LOG2_E;
    let rounded = y + ROUND;
    let exponent = rounded.to_bits().cast_signed().wrapping_sub(0x4b40_0000);
    let f = (y - (rounded - ROUND)) * core::f32::consts::LN_2;
    let p = 1.0 + f * (1.0 + f * (0.5 + f * (0.166_666_67 + f * (0.041_666_67 + f * 0.008_333))));
    p * f32::from_bits((exponent.wrapping_add(127) << 23).cast_unsigned())
}

/// As `f32::max` of numbers, in one instruction for several.
#[inline(always)]
pub(super) fn at_least(x: f32, low: f32) -> f32 {
    if x > low { x } else { low }
}

/// As `f32::min` of numbers, in one instruction for several.
#[inline(always)]
pub(super) fn at_most(x: f32, high: f32) -> f32 {
    if x < high { x } else { high }
}

#[cfg(test)]
mod tests {
    use super::{exp, ln};

    #[test]
    fn both_are_close_to_the_library() {
        let mut x = 1e-30_f32;
        while x < 1e30 {
            let reference = libm::logf(x);
            assert!((ln(x) - reference).abs() < 3e-6 * reference.abs().max(1.0), "{x}");
            x *= 1.013;
        }
        let mut x = -79.0_f32;
        while x < 79.0 {
            assert!((exp(x) / libm::expf(x) - 1.0).abs() < 3e-5, "{x}");
            x += 0.013;
        }
    }
}
