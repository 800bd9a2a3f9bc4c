//! Items of a source's thread in; a bounded ring to the model, and counts of what found no room, out.

use super::clock::Clock;
use crate::feed::{Feed, SourceStatus};
use core::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use core::time::Duration;
use rtrb::{Producer, PushError};
use std::collections::VecDeque;
use std::sync::Arc;

/// Items that the ring of a live source holds: some seconds.
pub(super) const LIVE_RING: usize = 2048;
/// Items that the ring of a file holds: its blocks are larger, and its thread waits.
pub(super) const FILE_RING: usize = 64;
/// News that wait for room; samples never do.
const BACKLOG: usize = 256;
/// How long a file's thread waits for room before it looks again.
const ROOM: Duration = Duration::from_millis(2);

/// What both sides share.
#[derive(Debug, Default)]
pub(super) struct Shared {
    pub(super) stop: AtomicBool,
    pub(super) dropped: AtomicU64,
}

/// Where a source's thread puts what it has.
pub(super) struct Outlet {
    ring: Producer<Feed>,
    shared: Arc<Shared>,
    wake: Box<dyn Fn() + Send>,
    backlog: VecDeque<Feed>,
    status: SourceStatus,
    /// Samples were dropped: the next ones do not join.
    broken: bool,
    pub(super) clock: Clock,
}

impl Outlet {
    pub(super) fn new(
        ring: Producer<Feed>,
        shared: Arc<Shared>,
        wake: Box<dyn Fn() + Send>,
    ) -> Self {
        let status = SourceStatus::default();
        let backlog = VecDeque::new();
        Self { ring, shared, wake, backlog, status, broken: false, clock: Clock::start() }
    }

    /// Whether the scope lets go of this source.
    pub(super) fn stops(&self) -> bool {
        self.shared.stop.load(Ordering::Relaxed) || self.ring.is_abandoned()
    }

    /// Offers an item without waiting. News wait in a backlog for room; samples, states and what is derived of them are dropped and
    /// counted, and the next samples say that something is missing before them.
    pub(super) fn offer(&mut self, feed: Feed) {
        self.catch_up();
        let mut feed = feed;
        if self.broken
            && let Feed::Rows(block) = &mut feed
        {
            block.broken = true;
        }
        let is_rows = matches!(feed, Feed::Rows(_));
        let back = if self.backlog.is_empty() {
            match self.ring.push(feed) {
                Ok(()) => {
                    self.broken &= !is_rows;
                    return;
                }
                Err(PushError::Full(feed)) => feed,
            }
        } else {
            feed
        };
        if is_bulk(&back) || self.backlog.len() >= BACKLOG {
            self.broken |= is_rows;
            self.shared.dropped.fetch_add(1, Ordering::Relaxed);
        } else {
            self.backlog.push_back(back);
        }
    }

    /// Puts what waits into the ring, as far as there is room.
    pub(super) fn catch_up(&mut self) {
        while let Some(feed) = self.backlog.pop_front() {
            if let Err(PushError::Full(feed)) = self.ring.push(feed) {
                self.backlog.push_front(feed);
                return;
            }
        }
    }

    /// Puts an item in and waits for room: only a file's thread may. `false` where the scope lets go of the source.
    pub(super) fn put(&mut self, feed: Feed) -> bool {
        let mut feed = feed;
        loop {
            if self.stops() {
                return false;
            }
            match self.ring.push(feed) {
                Ok(()) => return true,
                Err(PushError::Full(back)) => {
                    feed = back;
                    (self.wake)();
                    self.clock.wait(ROOM);
                }
            }
        }
    }

    /// Tells how the source is, where that is new.
    pub(super) fn status(&mut self, status: SourceStatus) {
        if self.status != status {
            self.status = status.clone();
            self.offer(Feed::Status(status));
            self.wake();
        }
    }

    /// Tells how far a file has been read, where there is room.
    pub(super) fn progress(&mut self, done: f32) {
        let status = SourceStatus::Loading { done };
        if self.status != status && self.ring.push(Feed::Status(status.clone())).is_ok() {
            self.status = status;
        }
    }

    /// Something is there to be seen.
    pub(super) fn wake(&self) {
        (self.wake)();
    }
}

/// What comes many times a second and may be missing.
const fn is_bulk(feed: &Feed) -> bool {
    matches!(feed, Feed::Rows(_) | Feed::Preview(_) | Feed::State(_) | Feed::Derived(_))
}
