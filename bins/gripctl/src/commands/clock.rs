//! The clocks of the toolbox: nothing in, time out. Everything else is given the time.

use core::time::Duration;
use rustix::time::{ClockId, clock_gettime};

/// Time since the machine started.
pub(crate) fn monotonic() -> Duration {
    let time = clock_gettime(ClockId::Monotonic);
    // Since the machine started: neither part is negative.
    Duration::new(time.tv_sec.unsigned_abs(), u32::try_from(time.tv_nsec).unwrap_or(0))
}

/// What the wall clock shows (ns since 1970).
#[cfg(feature = "fleet")]
pub(crate) fn utc_ns() -> u64 {
    let time = clock_gettime(ClockId::Realtime);
    // A clock before 1970 is not set; times then count from 1970.
    let now = Duration::new(
        u64::try_from(time.tv_sec).unwrap_or(0),
        u32::try_from(time.tv_nsec).unwrap_or(0),
    );
    u64::try_from(now.as_nanos()).unwrap_or(u64::MAX)
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

/// Nanoseconds since 1970: the wall time at the start, read once, and monotonic from there on, as in a recording.
#[cfg(feature = "foxglove")]
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wall {
    zero: Duration,
    start: Duration,
}

#[cfg(feature = "foxglove")]
impl Wall {
    pub(crate) fn start() -> anyhow::Result<Self> {
        let time = clock_gettime(ClockId::Realtime);
        let zero = Duration::new(u64::try_from(time.tv_sec)?, u32::try_from(time.tv_nsec)?);
        Ok(Self { zero, start: monotonic() })
    }

    pub(crate) fn now_ns(self) -> u64 {
        let now = self.zero + monotonic().saturating_sub(self.start);
        u64::try_from(now.as_nanos()).unwrap_or(u64::MAX)
    }
}
