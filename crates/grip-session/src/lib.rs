//! What runs beside a gripper and in a replay alike: configuration, model file, the live session, recordings played again, output
//! lines and exit codes.

pub mod calibration;
pub mod config;
pub mod exit;
pub mod gripper;
pub mod memory;
pub mod model;
pub mod recording;
pub mod replay;
pub mod report;
pub mod rows;
pub mod session;
pub mod shadow;
pub mod signature;
pub mod status;
pub mod steady;
pub mod tape;
pub mod utc;

pub use config::{HostConfig, HostConfigError, LinkConfig};
pub use model::{HostEstimator, ModelError};
pub use session::{Session, SessionError, SessionOptions, Update};

/// The blocks of the page run as tests of this crate, which has what they use.
#[cfg(doctest)]
#[doc = include_str!("../../../docs/rust.md")]
struct RustPage;
