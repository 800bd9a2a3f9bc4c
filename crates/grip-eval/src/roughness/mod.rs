//! A height profile in, its mean line, roughness profile and roughness parameters out.
//!
//! [`ProfileFilter`] gives the mean line, the long waves of a profile; the profile minus its mean line is the
//! roughness profile, and [`Roughness::measure`] gives Ra, Rq, Rz and RSm of that. Heights are f64 in metres at equal steps;
//! the caller brings the buffers, so nothing is allocated here either.

mod elements;
mod filter;
mod noise;
mod parameters;
mod period;

pub use filter::{BufferTooShort, FilterKind, ProfileFilter};
pub use noise::noise_deviation;
pub use parameters::Roughness;
pub use period::dominant_wavelength;
