//! False alarms and latencies on signals of a held object with and without slip and robot motion.
#![expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "counts of samples and places in lists, all small and not negative"
)]

pub mod bound;
mod latency;
mod ours;
mod robot;
mod trials;

pub use latency::{Latency, quantile};
pub use ours::Ours;
pub use robot::{Hand, RobotConfig};
pub use trials::{NullRun, Slips, Trial, null_run, slips};
