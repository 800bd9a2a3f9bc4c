//! Stylus and motion readings in, the slip state and its statistic out.

mod config;
mod coupling;
mod evidence;
mod lanes;
mod reference;
mod rest;
mod slip;
mod test;

pub use config::{BANDS, BandThreshold, DetectorConfig, STILL_BANDS, TestKind};
pub use evidence::{Certificate, Evidence, LIMITS, ScoreLaw, Scores};
pub use reference::GateConfig;
pub use rest::{FloorHealth, RestMeter};
pub use slip::{KnownFloors, Levels, SlipDetector, SlipState};
pub use test::{Block, Cusum, EnergyTest, Glrt, SequentialTest};
