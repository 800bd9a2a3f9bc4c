//! Where a source's thread puts what it has.

use super::clock::Clock;
use crate::feed::{Feed, SourceStatus};
use core::sync::atomic::{AtomicBool, Ordering};
use core::time::Duration;
use std::sync::Arc;

/// The way from a source to the model.
#[expect(missing_debug_implementations, reason = "it holds what has none")]
pub struct Outlet {
    take: Box<dyn FnMut(Feed) + Send>,
    wake: Box<dyn Fn() + Send>,
    stop: Arc<AtomicBool>,
    status: SourceStatus,
    pub(super) clock: Clock,
}

impl Outlet {
    pub(super) fn new(
        take: impl FnMut(Feed) + Send + 'static,
        wake: impl Fn() + Send + 'static,
        stop: Arc<AtomicBool>,
    ) -> Self {
        let (take, wake) = (Box::new(take), Box::new(wake));
        Self { take, wake, stop, status: SourceStatus::default(), clock: Clock::start() }
    }

    /// Whether the scope lets go of this source.
    #[must_use]
    pub fn stops(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    /// Time since its start.
    #[must_use]
    pub fn now(&self) -> Duration {
        self.clock.now()
    }

    /// Puts an item into the model.
    pub fn offer(&mut self, feed: Feed) {
        (self.take)(feed);
    }

    /// Reports how the source is, where that is new.
    pub fn status(&mut self, status: SourceStatus) {
        if self.status != status {
            self.status = status.clone();
            self.offer(Feed::Status(status));
            self.wake();
        }
    }

    /// Something is there to be seen.
    pub(super) fn wake(&self) {
        (self.wake)();
    }
}
