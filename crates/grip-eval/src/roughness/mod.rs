//! The mean line of a height profile, and the parameters of its roughness and waviness.
//!
//! [`ProfileFilter`] gives the mean line, the long waves of a profile; the profile minus its mean line is the
//! roughness profile, and [`Roughness::measure`] gives Ra, Rq, Rz and RSm of that. The mean line less the form is the waviness
//! profile, with Wa and Wz by [`Waviness::measure`]. Heights are f64 in metres at equal steps;
//! the caller brings the buffers, so nothing is allocated here either.

mod elements;
mod filter;
mod noise;
mod parameters;
mod period;

pub use filter::{BufferTooShort, FilterKind, ProfileFilter};
pub use noise::noise_deviation;
pub use parameters::{Roughness, Waviness};
pub use period::dominant_wavelength;
