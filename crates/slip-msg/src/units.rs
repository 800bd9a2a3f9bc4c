//! Units that cross crate borders: newtypes of bare numbers, so that none can be mistaken.
//!
//! Inside a computation values are plain `f32`/`f64` in SI with the unit in the name or the doc
//! sentence; these newtypes stand where a caller could otherwise swap two arguments.

/// A point in time or a duration in microseconds since the microcontroller started.
///
/// The device counts ticks of one microsecond; 64 bits last for 584,000 years, so it never wraps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Micros(pub u64);

impl Micros {
    /// Seconds, the `f64` nearest to them up to 2^53 microseconds (285 years).
    #[inline]
    #[must_use]
    pub fn as_seconds(self) -> f64 {
        self.0 as f64 / 1e6
    }

    /// The microseconds nearest to `seconds`; zero for NaN and negative values.
    #[must_use]
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "the cast saturates"
    )]
    pub const fn from_seconds(seconds: f64) -> Self {
        Self((seconds * 1e6 + 0.5) as u64)
    }

    /// `ms` milliseconds, rounded down; zero for NaN and negative values.
    #[must_use]
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "the cast saturates"
    )]
    pub const fn from_ms(ms: f32) -> Self {
        Self((ms * 1e3) as u64)
    }

    /// Time from `earlier` to `self`, zero where `earlier` is later.
    #[inline]
    #[must_use]
    pub fn since(self, earlier: Self) -> Self {
        Self(self.0.saturating_sub(earlier.0))
    }

    /// `self` later by `duration`, saturating.
    #[inline]
    #[must_use]
    pub fn plus(self, duration: Self) -> Self {
        Self(self.0.saturating_add(duration.0))
    }

    /// The duration of `ms` milliseconds.
    #[must_use]
    pub const fn from_millis(ms: u32) -> Self {
        Self(ms as u64 * 1000)
    }
}

/// A rate or a corner frequency in hertz.
#[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(transparent))]
pub struct Hertz(pub f32);

/// A force in newtons.
#[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(transparent))]
pub struct Newtons(pub f32);

impl Newtons {
    /// From millinewtons, as forces travel.
    #[must_use]
    #[expect(clippy::cast_possible_truncation, reason = "rounded to 24 bits")]
    pub const fn from_mn(force_mn: i32) -> Self {
        Self((force_mn as f64 / 1000.0) as f32)
    }

    /// In millinewtons, rounded; `None` for NaN, a negative force or one over 2.1 MN.
    #[must_use]
    #[expect(clippy::cast_possible_truncation, reason = "within 0..=i32::MAX")]
    pub const fn to_mn(self) -> Option<i32> {
        // Exact: a force has 24 bits.
        let rounded = self.0 as f64 * 1000.0 + 0.5;
        if self.0 >= 0.0 && rounded < i32::MAX as f64 + 1.0 { Some(rounded as i32) } else { None }
    }
}
