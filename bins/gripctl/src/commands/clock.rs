//! The clocks of the toolbox. Everything else is given the time.

use core::time::Duration;
use rustix::time::{ClockId, clock_gettime};

/// Time since the machine started.
pub(crate) fn monotonic() -> Duration {
    let time = clock_gettime(ClockId::Monotonic);
    // Since the machine started: neither part is negative.
    Duration::new(time.tv_sec.unsigned_abs(), u32::try_from(time.tv_nsec).unwrap_or(0))
}

/// Processor time of this process, all threads.
pub(crate) fn processor() -> anyhow::Result<Duration> {
    let time = clock_gettime(ClockId::ProcessCPUTime);
    Ok(Duration::new(u64::try_from(time.tv_sec)?, u32::try_from(time.tv_nsec)?))
}

/// Microseconds since it was started.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Clock(Duration);

impl Clock {
    pub(crate) fn start() -> Self {
        Self(monotonic())
    }

    pub(crate) fn now_us(self) -> u64 {
        u64::try_from(monotonic().saturating_sub(self.0).as_micros()).unwrap_or(u64::MAX)
    }
}
