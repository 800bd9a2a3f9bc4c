//! The only clocks of the daemon: the monotonic one, and one look at the wall clock, which may jump.

use core::time::Duration;
use std::time::{Instant, SystemTime, UNIX_EPOCH};

/// Microseconds since the start.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Clock {
    start: Instant,
    /// Wall clock at the start, since 1970.
    wall: Duration,
}

impl Clock {
    #[expect(
        clippy::disallowed_methods,
        reason = "the driver reads the clock; everything else is told the time"
    )]
    pub(crate) fn start() -> Self {
        // A wall clock before 1970 is not set; times then count from 1970.
        let wall = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        Self { start: Instant::now(), wall }
    }

    /// What the wall clock would show if it had not been touched since the start (ns since 1970).
    pub(crate) fn wall_ns(&self) -> u64 {
        u64::try_from((self.wall + self.start.elapsed()).as_nanos()).unwrap_or(u64::MAX)
    }

    /// [`Clock::wall_ns`] in whole seconds.
    pub(crate) fn wall_s(&self) -> u64 {
        (self.wall + self.start.elapsed()).as_secs()
    }

    pub(crate) fn now_us(&self) -> u64 {
        u64::try_from(self.start.elapsed().as_micros()).unwrap_or(u64::MAX)
    }

    pub(crate) fn now_ns(&self) -> u64 {
        u64::try_from(self.start.elapsed().as_nanos()).unwrap_or(u64::MAX)
    }

    /// A number that differs from start to start.
    pub(crate) fn run_id(&self) -> u32 {
        u32::try_from(self.wall.as_millis() & 0xFFFF_FFFF).unwrap_or(0)
    }
}
