//! The scattered energy of vibration E_sc of irregularities.
//!
//! Eq. 1 as printed:
//!
//! ```text
//! E_sc = n F v tan(S),   S = sum over i = 1..n of cot(delta_i / s_i)
//! ```
//!
//! with n irregularities of height delta_i and spacing s_i, the trial force F (N) and the slip speed v (m/s). Its unit
//! is N m/s = W. tan is periodic, so the value answers to S mod pi alone. Every value comes with
//!
//! - an **enclosure**: the exact value of the formula for the numbers that went in lies within `lo..=hi`;
//! - the **condition** number: how much larger than a relative error of S that of the value is, |2 S / sin 2S|;
//! - **sigma_S**: the deviation of S (rad) that the sensor noise causes; infinite where a ratio is unknown mod pi. Above 1 the value shows nothing about the surface;
//! - [`Flags`] that report it in words.
//!
//! [`literal`] holds the evaluators of the equation as printed, [`Reading`] the other readings of it that have been
//! proposed, [`EscSums`] all of them at once. Nothing replaces the literal value: another reading stands beside it.

mod cotangent;
mod double;
mod enclosure;
mod flags;
pub mod literal;
pub mod readings;
mod real;
mod sums;
#[cfg(test)]
mod tests;
mod trial;

pub use flags::{Flag, Flags};
pub use literal::LiteralSum;
pub use real::Real;
pub use slip_msg::Reading;
pub use sums::{EscSum, EscSums};
pub use trial::{Noise, Trial};

/// One reading of E_sc with the figures that show how far it can be trusted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Esc<T = f64> {
    /// Which reading.
    pub reading: Reading,
    /// Its value, in [`Reading::unit`].
    pub value: T,
    /// The exact value is not below this; minus infinity where a pole may be inside.
    pub lo: T,
    /// The exact value is not above this.
    pub hi: T,
    /// Irregularities in the sum.
    pub n: u32,
    /// Irregularities that were left out because a length was zero, negative or not finite.
    pub degenerate: u32,
    /// The sum S of the reading: of cotangents or arccotangents (rad), of slopes, of heights (m) or of delta^2/s (m).
    pub sum: T,
    /// Relative condition number of the value with respect to S; 1 where it is proportional to S.
    pub condition: T,
    /// Deviation of S caused by the sensor noise: in rad where the value is a tangent of S, otherwise relative to S.
    pub sigma_s: T,
    /// What is wrong with the value.
    pub flags: Flags,
}

impl<T> Esc<T> {
    /// Whether sigma_S stays below 1, so that the value still depends on the surface.
    #[must_use]
    pub fn informative(&self) -> bool {
        !self.flags.contains(Flag::NoInformation)
    }
}
