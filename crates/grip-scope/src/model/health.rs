//! The last numbers of a daemon, with what the scope itself counts.

use grip_link::message::daemon::Health;

/// What is known of the link's health.
#[derive(Clone, Debug, Default)]
pub struct HealthBoard {
    /// The last numbers.
    pub latest: Option<Box<Health>>,
    /// Rows that were not later than the one before and are not shown.
    pub late_rows: u64,
    /// States whose time is far from that of the samples, not shown.
    pub stray_states: u64,
    /// Finite readings that no sensor of a gripper sends.
    pub huge: u64,
    /// Readings of the stylus that are no number.
    pub nan: u64,
    /// Values of states and of what is derived that came after later ones and are not shown.
    pub misplaced: u64,
}
