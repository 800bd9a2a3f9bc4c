//! Stylus and motion readings in, the slip state and its statistic out.

mod axes;
mod config;
mod correlation;
mod coupling;
mod cusum;
mod decision;
mod delay;
mod doubt;
mod evidence;
mod gate;
mod glrt;
mod knocks;
mod lanes;
mod level;
mod pending;
mod primed;
mod reference;
mod rest;
mod slip;
mod test;

pub use config::{BANDS, BandThreshold, DetectorConfig, TestKind};
pub use cusum::Cusum;
pub use doubt::FloorHealth;
pub use evidence::{Certificate, Evidence, LIMITS, ScoreLaw, Scores};
pub use gate::GateConfig;
pub use glrt::Glrt;
pub use reference::MotionInput;
pub use rest::RestMeter;
pub use slip::{KnownFloors, Levels, SlipDetector, SlipState};
pub use test::{Block, EnergyTest, SequentialTest};
