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
        reason = "the driver reads the clock; everything else gets the time from it"
    )]
    pub(crate) fn start() -> Self {
        // A wall clock before 1970 is not set; times then count from 1970.
        Self::with(|| SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default())
    }

    /// `wall` is asked once and never again: whatever it shows later has no effect.
    #[expect(clippy::disallowed_methods, reason = "as above")]
    fn with(wall: impl FnOnce() -> Duration) -> Self {
        Self { start: Instant::now(), wall: wall() }
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

#[cfg(test)]
mod tests {
    use super::Clock;
    use core::{cell::Cell, time::Duration};

    /// The wall clock of the machine, as somebody sets it.
    const NOON: Duration = Duration::from_secs(1_800_000_000);
    const HOUR: Duration = Duration::from_secs(3600);

    /// Nothing else in the daemon and its libraries reads a wall clock (clippy: `disallowed_methods`), so this is all that a jump could reach.
    #[test]
    fn a_wall_clock_that_jumps_by_an_hour_changes_no_time_of_the_daemon() {
        let (shown, asked) = (Cell::new(NOON), Cell::new(0));
        let clock = Clock::with(|| {
            asked.set(asked.get() + 1);
            shown.get()
        });
        let run_id = clock.run_id();
        let mut before = (clock.now_us(), clock.now_ns(), clock.wall_ns());
        for jump in 0..2_000 {
            shown.set(if jump % 2 == 0 { NOON + HOUR } else { NOON - HOUR });
            let now = (clock.now_us(), clock.now_ns(), clock.wall_ns());
            assert!(
                now.0 >= before.0 && now.1 >= before.1 && now.2 >= before.2,
                "{before:?} {now:?}"
            );
            // Log times are those of the start and what has passed since, and no hour more.
            let since = Duration::from_nanos(clock.wall_ns()) - NOON;
            assert!(since >= Duration::from_nanos(now.1) && since < HOUR, "{since:?}");
            before = now;
        }
        assert_eq!((asked.get(), clock.run_id()), (1, run_id));
        assert!((NOON.as_secs()..(NOON + HOUR).as_secs()).contains(&clock.wall_s()));
    }
}
