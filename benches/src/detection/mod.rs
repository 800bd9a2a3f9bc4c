//! Signals of a held object with and without slip and robot motion in; false alarms and latencies out.
#![expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "counts of samples and places in lists, all small and not negative"
)]

pub mod bound;
pub mod contest;
mod cost;
mod latency;
mod ours;
mod peers;
pub mod report;
mod robot;
mod tail;
mod trials;

pub use cost::cost;
pub use latency::{Latency, quantile};
pub use ours::Ours;
pub use peers::Peer;
pub use robot::{Hand, RobotConfig};
pub use trials::{Alarm, NullRun, Slips, Trial, null_run, null_runs, slips, slips_of_all};
