//! Stylus readings in, the slip state and its statistic out.

mod energy;
mod primed;
mod rest;

pub use energy::{BANDS, BandThreshold, DetectorConfig, SlipDetector, SlipState};
pub use rest::RestMeter;
