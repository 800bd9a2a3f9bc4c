//! The clocks of gripfleet: the monotonic one, and one look at the wall clock, which may jump.

use core::time::Duration;
use grip_daemon::log::Clocks;
use std::{
    sync::OnceLock,
    time::{Instant, SystemTime, UNIX_EPOCH},
};

/// Time since the start.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Clock {
    start: Instant,
    /// Wall clock at the start, since 1970.
    wall: Duration,
}

impl Clock {
    #[expect(clippy::disallowed_methods, reason = "the driver reads the clock")]
    pub(crate) fn start() -> Self {
        Self { start: Instant::now(), wall: Duration::from_nanos(utc_ns()) }
    }

    /// Microseconds since the start.
    pub(crate) fn now_us(&self) -> u64 {
        u64::try_from(self.start.elapsed().as_micros()).unwrap_or(u64::MAX)
    }

    /// What the wall clock would show if it had not been touched since the start (ns since 1970).
    pub(crate) fn wall_ns(&self) -> u64 {
        u64::try_from((self.wall + self.start.elapsed()).as_nanos()).unwrap_or(u64::MAX)
    }

    /// Both, for the log.
    pub(crate) fn now(&self) -> Clocks {
        Clocks { host_us: self.now_us(), wall_us: self.wall_ns() / 1000 }
    }
}

/// Time since the first look.
#[expect(clippy::disallowed_methods, reason = "the driver reads the clock")]
pub(crate) fn monotonic() -> Duration {
    static FIRST: OnceLock<Instant> = OnceLock::new();
    FIRST.get_or_init(Instant::now).elapsed()
}

/// What the wall clock shows now (ns since 1970). One before 1970 is not set; times then count from 1970.
#[expect(clippy::disallowed_methods, reason = "the driver reads the clock")]
pub(crate) fn utc_ns() -> u64 {
    let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    u64::try_from(now.as_nanos()).unwrap_or(u64::MAX)
}
