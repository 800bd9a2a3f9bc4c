//! Signals of a held object with and without slip and robot motion in; false alarms and latencies out.
#![expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "counts of samples and places in lists, all small and not negative"
)]

mod ours;
mod peers;
mod robot;
mod trials;

pub use ours::Ours;
pub use peers::Peer;
pub use robot::{Hand, RobotConfig};
pub use trials::{Alarm, NullRun, Slips, Trial, null_run, slips};
