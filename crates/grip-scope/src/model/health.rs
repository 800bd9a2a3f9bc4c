//! Figures of a daemon in, the last ones, with what the scope itself counts, out.

use grip_link::message::daemon::Health;

/// What is known of the link's health.
#[derive(Clone, Debug, Default)]
pub struct HealthBoard {
    latest: Option<Box<Health>>,
    lost_in_scope: u64,
    late_rows: u64,
    huge: u64,
    nan: u64,
    misplaced: u64,
    stray_states: u64,
}

impl HealthBoard {
    pub(super) fn take(&mut self, point: Box<Health>) {
        self.latest = Some(point);
    }

    pub(super) fn late_row(&mut self) {
        self.late_rows += 1;
    }

    pub(super) fn stray_state(&mut self) {
        self.stray_states += 1;
    }

    pub(super) fn set_unusable(&mut self, huge: u64, nan: u64, misplaced: u64) {
        (self.huge, self.nan, self.misplaced) = (huge, nan, misplaced);
    }

    pub(super) fn set_lost_in_scope(&mut self, dropped: u64) -> bool {
        core::mem::replace(&mut self.lost_in_scope, dropped) != dropped
    }

    /// The last figures.
    #[must_use]
    pub fn latest(&self) -> Option<&Health> {
        self.latest.as_deref()
    }

    /// Items that the scope itself had no room for: shown as gaps.
    #[must_use]
    pub const fn lost_in_scope(&self) -> u64 {
        self.lost_in_scope
    }

    /// Rows that were not later than the one before and are not shown.
    #[must_use]
    pub const fn late_rows(&self) -> u64 {
        self.late_rows
    }

    /// States whose time is far from that of the samples, not shown.
    #[must_use]
    pub const fn stray_states(&self) -> u64 {
        self.stray_states
    }

    /// Finite readings that no sensor of a gripper sends.
    #[must_use]
    pub const fn huge(&self) -> u64 {
        self.huge
    }

    /// Readings of the stylus that are no number.
    #[must_use]
    pub const fn nan(&self) -> u64 {
        self.nan
    }

    /// Values of states and of what is derived that came after later ones and are not shown.
    #[must_use]
    pub const fn misplaced(&self) -> u64 {
        self.misplaced
    }

    /// Bytes it takes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.latest.as_ref().map_or(0, |_| size_of::<Health>())
    }
}
