//! What the daemon and the toolbox share: configuration, model and scene files, replay, and the lines they print.

pub mod accuracy;
pub mod calibrate;
pub mod certify;
pub mod collect;
pub mod config;
pub mod esc;
pub mod exit;
pub mod grasp;
pub mod model;
pub mod motion;
pub mod poisson;
pub mod profile;
pub mod recording;
pub mod replay;
pub mod report;
pub mod scene;
pub mod score;
pub mod session;
pub mod tail;
pub mod tape;
pub mod trial;
pub mod utc;

pub use config::{HostConfig, HostConfigError, LinkConfig};
pub use model::{HostEstimator, ModelError};
pub use session::{News, Session, SessionError, SessionOptions};
