//! The one place of this crate that reads a clock and waits: the threads of sources.

use core::time::Duration;
use std::time::Instant;

/// A clock that never goes back.
#[derive(Clone, Copy, Debug)]
pub struct Clock(Instant);

impl Clock {
    #[expect(
        clippy::disallowed_methods,
        reason = "threads of sources are drivers: they run in real time"
    )]
    /// It begins now.
    #[must_use]
    pub fn start() -> Self {
        Self(Instant::now())
    }

    /// Time since its start.
    #[must_use]
    pub fn now(&self) -> Duration {
        self.0.elapsed()
    }

    /// The same in whole microseconds.
    pub(super) fn now_us(&self) -> u64 {
        u64::try_from(self.now().as_micros()).unwrap_or(u64::MAX)
    }

    /// Waits, as only the thread of a source may.
    #[expect(clippy::disallowed_methods, reason = "as above")]
    pub fn wait(&self, time: Duration) {
        std::thread::sleep(time);
    }
}
