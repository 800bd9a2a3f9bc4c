//! Samples in, band signals and their mean energy out.

mod bank;
mod envelope;
mod svf;

pub use bank::{Band, FilterBank};
pub use envelope::Envelope;
pub use svf::{CornerError, MAX_CORNER, Svf, SvfLanes};
