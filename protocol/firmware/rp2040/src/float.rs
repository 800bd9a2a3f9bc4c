//! Sum and product of two f32 in integers, for a core that has no unit for floats.
//!
//! IEEE 754, round to nearest even, to the bit that of any host (its test compares them). The compiler's own functions take
//! every number the same way, with a product of 64 bits; these are quick for normal numbers, and let f64 do what is left:
//! sums and products of two f32 that were rounded to f64 first round to the same f32 (53 >= 2 * 24 + 2 bits).

const SIGN: u32 = 0x8000_0000;
const INFINITY: u32 = 0x7F80_0000;
const HIDDEN: u32 = 0x0080_0000;
const FRACTION: u32 = HIDDEN - 1;

/// The sum of two f32, as bits.
#[must_use]
#[inline(always)]
pub fn add(a: u32, b: u32) -> u32 {
    let (x, y) = if (a << 1) < (b << 1) { (b, a) } else { (a, b) };
    let (exponent, lower) = ((x >> 23) & 0xFF, (y >> 23) & 0xFF);
    if exponent == 0xFF || lower == 0 {
        return if y << 1 == 0 && x << 1 != 0 && exponent != 0xFF { x } else { slow_add(x, y) };
    }
    let shift = exponent - lower;
    if shift > 26 {
        return x;
    }
    // Three bits below the last one: two of the sum and one for all that is lost.
    let large = ((x & FRACTION) | HIDDEN) << 3;
    let mut small = ((y & FRACTION) | HIDDEN) << 3;
    if shift > 0 {
        let lost = small << (32 - shift);
        small = (small >> shift) | u32::from(lost != 0);
    }
    let sign = x & SIGN;
    if (x ^ y) & SIGN == 0 {
        let sum = large + small;
        if sum < HIDDEN << 4 {
            return rounded(sign, exponent, sum);
        }
        return if exponent >= 0xFE {
            sign | INFINITY
        } else {
            rounded(sign, exponent + 1, (sum >> 1) | (sum & 1))
        };
    }
    let mut difference = large - small;
    if difference >= HIDDEN << 3 {
        return rounded(sign, exponent, difference);
    }
    if difference == 0 {
        return 0;
    }
    let up = difference.leading_zeros() - 5;
    if up >= exponent {
        return slow_add(x, y);
    }
    difference <<= up;
    rounded(sign, exponent - up, difference)
}

/// Sign, exponent and a significand with three bits below its last one, rounded; a carry goes on into the exponent.
#[inline(always)]
const fn rounded(sign: u32, exponent: u32, significand: u32) -> u32 {
    let bits = sign | ((exponent << 23) + ((significand >> 3) & FRACTION));
    let below = significand & 7;
    bits + (below > 4 || (below == 4 && bits & 1 != 0)) as u32
}

/// The product of two f32, as bits.
#[must_use]
#[inline(always)]
pub fn mul(a: u32, b: u32) -> u32 {
    let (left, right) = ((a >> 23) & 0xFF, (b >> 23) & 0xFF);
    let sign = (a ^ b) & SIGN;
    if left.wrapping_sub(1) >= 0xFE || right.wrapping_sub(1) >= 0xFE {
        let zero = (a << 1 == 0 && right != 0xFF) || (b << 1 == 0 && left != 0xFF);
        return if zero { sign } else { slow_mul(a, b) };
    }
    let (x, y) = ((a & FRACTION) | HIDDEN, (b & FRACTION) | HIDDEN);
    // 24 by 24 bits from four products of 12 by 12.
    let (x_high, x_low, y_high, y_low) = (x >> 12, x & 0xFFF, y >> 12, y & 0xFFF);
    let middle = x_high * y_low + x_low * y_high;
    let low = x_low * y_low + ((middle & 0xFFF) << 12);
    let mut high = x_high * y_high + (middle >> 12) + (low >> 24);
    let mut below = low & 0x00FF_FFFF;
    let mut exponent = left + right;
    if high < HIDDEN {
        high = (high << 1) | (below >> 23);
        below = (below << 1) & 0x00FF_FFFF;
    } else {
        exponent += 1;
    }
    // Biased twice: 128 is the smallest normal exponent, 381 the largest.
    if exponent.wrapping_sub(128) > 253 {
        return slow_mul(a, b);
    }
    let bits = sign | (((exponent - 127) << 23) + (high & FRACTION));
    bits + u32::from(below > HIDDEN || (below == HIDDEN && bits & 1 != 0))
}

/// An f32 as f64. Hidden from the optimizer, which would make a sum of f32 of it again, that is a call of [`add`].
fn wide(bits: u32) -> f64 {
    core::hint::black_box(f64::from(f32::from_bits(bits)))
}

#[cold]
#[inline(never)]
fn slow_add(a: u32, b: u32) -> u32 {
    ((wide(a) + wide(b)) as f32).to_bits()
}

#[cold]
#[inline(never)]
fn slow_mul(a: u32, b: u32) -> u32 {
    ((wide(a) * wide(b)) as f32).to_bits()
}

#[cfg(test)]
mod tests {
    use super::{add, mul};

    /// The same number, or both no number.
    fn same(bits: u32, wanted: f32) -> bool {
        bits == wanted.to_bits() || (wanted.is_nan() && f32::from_bits(bits).is_nan())
    }

    fn compare(a: u32, b: u32) {
        let (x, y) = (f32::from_bits(a), f32::from_bits(b));
        assert!(same(add(a, b), x + y), "{a:#010x} + {b:#010x}: {:#010x}", add(a, b));
        assert!(same(mul(a, b), x * y), "{a:#010x} * {b:#010x}: {:#010x}", mul(a, b));
    }

    #[test]
    fn sums_and_products_are_those_of_the_host() {
        let edges = [
            0,
            1,
            0x007F_FFFF,
            0x0080_0000,
            0x0080_0001,
            0x3F7F_FFFF,
            0x3F80_0000,
            0x3F80_0001,
            0x7F00_0000,
            0x7F7F_FFFF,
            0x7F80_0000,
            0x7FC0_0000,
        ];
        for a in edges.into_iter().flat_map(|edge| [edge, edge | 0x8000_0000]) {
            edges
                .into_iter()
                .flat_map(|edge| [edge, edge | 0x8000_0000])
                .for_each(|b| compare(a, b));
        }
        let mut random = 1_u64;
        let mut next = || {
            random = random
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (random >> 32) as u32
        };
        for round in 0..20_000_000_u32 {
            let (a, b) = (next(), next());
            compare(a, b);
            // Exponents that lie close together, where rounding and cancellation are hard.
            let near = (a & 0x7F80_0000).wrapping_add((round % 64) << 23).wrapping_sub(32 << 23)
                & 0x7F80_0000;
            compare(a, near | (b & 0x807F_FFFF));
            compare(a, (a ^ 0x8000_0000).wrapping_add(b % 64));
        }
    }
}
