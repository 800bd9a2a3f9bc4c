//! Sum and product of two f32 in integers, for a core that has no unit for floats.
//!
//! IEEE 754, round to nearest even, to the bit that of any host (its test compares them). The compiler's own functions take
//! every number the same way, with a product of 64 bits; these are quick for normal numbers, and let f64 do what is left:
//! sums and products of two f32 that were rounded to f64 first round to the same f32 (53 >= 2 * 24 + 2 bits).

const SIGN: u32 = 0x8000_0000;
const INFINITE: u32 = 0xFF;
/// The lowest bit of the exponent.
const ONE: u32 = 1 << 23;

/// The sum of two f32, as bits.
#[must_use]
#[inline(always)]
pub fn add(a: u32, b: u32) -> u32 {
    let (x, y) = if (a << 1) < (b << 1) { (b, a) } else { (a, b) };
    let (exponent, lower) = ((x << 1) >> 24, (y << 1) >> 24);
    // Nothing of the rest leaves the range of normal numbers.
    if exponent.wrapping_sub(28) >= 0xFE - 28 || lower == 0 {
        return special_add(x, y);
    }
    let shift = exponent - lower;
    if shift > 26 {
        return x;
    }
    // Six bits below the last one, and two above the first. The lowest stands for all that is lost.
    let large = ((x << 8) | SIGN) >> 2;
    let small = ((y << 8) | SIGN) >> 2;
    let kept = small >> shift;
    let small = kept | u32::from(kept << shift != small);
    let head = (x >> 23) << 23;
    if ((x ^ y) as i32) >= 0 {
        let sum = large + small;
        return if sum >> 30 != 0 {
            rounded(head, sum << 1, 0)
        } else {
            rounded(head - ONE, sum << 2, 0)
        };
    }
    let mut difference = (large - small) << 2;
    if difference == 0 {
        return 0;
    }
    let mut head = head - ONE;
    if difference >> 20 == 0 {
        difference <<= 12;
        head -= 12 * ONE;
    }
    // Mostly that is a step or none.
    while (difference as i32) >= 0 {
        difference <<= 1;
        head -= ONE;
    }
    rounded(head, difference, 0)
}

/// Sign and exponent less 1, with a significand of 32 bits of which the 24 highest count, rounded; a carry goes on into the
/// exponent. `rest` is not 0 where the significand has still lower bits.
#[inline(always)]
const fn rounded(head: u32, significand: u32, rest: u32) -> u32 {
    let bits = head + (significand >> 8);
    let below = (significand << 24) as i32;
    if below >= 0 {
        bits
    } else if below << 1 != 0 || rest != 0 {
        bits + 1
    } else {
        bits + (bits & 1)
    }
}

/// The product of two f32, as bits.
#[must_use]
#[inline(always)]
pub fn mul(a: u32, b: u32) -> u32 {
    let (left, right) = (((a << 1) >> 24).wrapping_sub(64), ((b << 1) >> 24).wrapping_sub(64));
    let exponent = left.wrapping_add(right);
    // Both between 2^-63 and 2^64, and the exponent of the product not above 252, in one test.
    if (((left | right) << 1) | exponent.wrapping_add(3)) >> 8 != 0 {
        return special_mul(a, b);
    }
    product(a, b, exponent)
}

/// The product of two normal numbers that is a normal number whatever their fractions are. `exponent` is the sum of theirs less 128.
#[inline(always)]
const fn product(a: u32, b: u32, exponent: u32) -> u32 {
    let head = ((a ^ b) & SIGN) | (exponent << 23);
    // 24 by 24 bits: all but the lowest 16 of the product, which are in `middle` and `low`.
    let (x, y) = (((a << 8) | SIGN) >> 8, ((b << 8) | SIGN) >> 8);
    let low = (x & 0xFF) * y;
    let middle = (x >> 8) * (y & 0xFF) + (low >> 8);
    let product = (x >> 8) * (y >> 8) + (middle >> 8);
    let rest = (middle | low) << 24;
    if (product as i32) < 0 {
        rounded(head + ONE, product, rest)
    } else {
        rounded(head, product << 1, rest)
    }
}

/// The sum of `x` and `y`, which is no larger, where one is zero, very small, very large or no number. Apart, so that the
/// compiler does not make comparisons of floats of those of bits.
#[inline(never)]
fn special_add(x: u32, y: u32) -> u32 {
    if y << 1 != 0 || (x << 1) >> 24 == INFINITE {
        slow_add(x, y)
    } else if x << 1 != 0 {
        x
    } else {
        x & y
    }
}

/// The same for a product, where a factor or the product may be very small or large too.
#[inline(never)]
fn special_mul(a: u32, b: u32) -> u32 {
    let (left, right) = ((a << 1) >> 24, (b << 1) >> 24);
    let exponent = (left + right).wrapping_sub(128);
    if left == INFINITE || right == INFINITE {
        slow_mul(a, b)
    } else if a << 1 == 0 || b << 1 == 0 {
        (a ^ b) & SIGN
    } else if left == 0 || right == 0 || exponent > 252 {
        slow_mul(a, b)
    } else {
        product(a, b, exponent)
    }
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
            // Short fractions, whose products lie in the middle of two numbers.
            compare(a & 0xFFFF_F000, b & 0xFFFF_F800);
        }
    }
}
