//! Slip detector: the slip state and its statistic from stylus and motion readings.

mod config;
mod coupling;
mod envelope;
mod evidence;
mod lanes;
mod level;
mod reference;
mod rest;
mod slip;
mod sum;

pub use config::{BANDS, DetectorConfig};
pub use evidence::{Certificate, Evidence, LIMITS, ScoreLaw, Scores};
pub use reference::GateConfig;
pub use rest::{FloorHealth, RestMeter};
pub use slip::{KnownFloors, Levels, SlipDetector, SlipState};
pub use sum::{AlarmSum, Block, COMPONENTS};
