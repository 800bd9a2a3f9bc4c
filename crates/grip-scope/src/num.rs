//! Numbers between the widths that the model (f64, f32, u64) and a window (f32) use.

/// The f32 nearest to `x`; pixels and colours need no more.
#[must_use]
#[expect(clippy::cast_possible_truncation, reason = "pixels need no more than f32")]
pub const fn narrow(x: f64) -> f32 {
    x as f32
}

/// A count as a number.
#[must_use]
pub const fn count(n: usize) -> f64 {
    n as f64
}

/// A counter as a number.
#[must_use]
pub const fn counter(n: u64) -> f64 {
    n as f64
}

/// A number of microseconds, before or after, as a number.
#[must_use]
pub const fn signed(n: i64) -> f64 {
    n as f64
}

/// `x` rounded down to a whole number of things: 0 for NaN and below, the largest one above.
#[must_use]
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "the cast saturates")]
pub const fn whole(x: f64) -> usize {
    x as usize
}

/// `x` in 0 to 1 as one of 256 steps.
#[must_use]
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "the cast saturates")]
pub const fn byte(x: f32) -> u8 {
    (x * 255.0 + 0.5) as u8
}
