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
/// Items that wait for room; samples never do.
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
#[expect(missing_debug_implementations, reason = "it holds what has none")]
pub struct Outlet {
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
    #[must_use]
    pub fn stops(&self) -> bool {
        self.shared.stop.load(Ordering::Relaxed) || self.ring.is_abandoned()
    }

    /// Time since its start.
    #[must_use]
    pub fn now(&self) -> Duration {
        self.clock.now()
    }

    /// Offers an item without waiting. Events wait in a backlog for room; samples, states and what is derived of them are dropped and
    /// counted, and the next samples show that something is missing before them.
    pub fn offer(&mut self, feed: Feed) {
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

    /// Reports how the source is, where that is new.
    pub fn status(&mut self, status: SourceStatus) {
        if self.status != status {
            self.status = status.clone();
            self.offer(Feed::Status(status));
            self.wake();
        }
    }

    /// Reports how the source is for the last time: nothing comes behind it, so it waits for room.
    pub(super) fn last(&mut self, status: SourceStatus) {
        while let Some(feed) = self.backlog.pop_front() {
            if !self.put(feed) {
                return;
            }
        }
        self.put(Feed::Status(status));
        self.wake();
    }

    /// Reports how far a file has been read, where there is room.
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
    matches!(
        feed,
        Feed::Rows(_) | Feed::Preview(_) | Feed::Truth(_) | Feed::State(_) | Feed::Derived(_)
    )
}

#[cfg(test)]
mod tests {
    use super::{Outlet, Shared};
    use crate::feed::{Feed, Level, NoticeLine, RowBlock, SourceStatus};
    use core::sync::atomic::Ordering;
    use rtrb::{Consumer, RingBuffer};
    use std::sync::Arc;

    fn outlet(room: usize) -> (Outlet, Consumer<Feed>, Arc<Shared>) {
        let (to_model, ring) = RingBuffer::new(room);
        let shared = Arc::new(Shared::default());
        (Outlet::new(to_model, Arc::clone(&shared), Box::new(|| {})), ring, shared)
    }

    fn rows(time_us: u64) -> Feed {
        Feed::Rows(RowBlock { times_us: vec![time_us], ..RowBlock::default() })
    }

    fn all(ring: &mut Consumer<Feed>) -> Vec<Feed> {
        core::iter::from_fn(|| ring.pop().ok()).collect()
    }

    #[test]
    fn samples_without_room_are_counted_and_leave_a_gap_and_updates_wait() {
        let (mut outlet, mut ring, shared) = outlet(4);
        (0..7).for_each(|k| outlet.offer(rows(k)));
        outlet.status(SourceStatus::Live);
        let updates = NoticeLine { level: Level::Info, text: "x".to_owned() };
        outlet.offer(Feed::Notice(updates.clone()));
        assert_eq!(shared.dropped.load(Ordering::Relaxed), 3);
        assert_eq!(all(&mut ring), (0..4).map(rows).collect::<Vec<_>>());
        outlet.offer(rows(7));
        outlet.offer(rows(8));
        let seen = all(&mut ring);
        assert_eq!(seen[..2], [Feed::Status(SourceStatus::Live), Feed::Notice(updates)]);
        let broken = |feed: &Feed| matches!(feed, Feed::Rows(block) if block.broken);
        assert_eq!(seen[2..].iter().map(broken).collect::<Vec<_>>(), [true, false]);
        assert_eq!(shared.dropped.load(Ordering::Relaxed), 3);
    }

    #[test]
    fn a_scope_that_has_gone_ends_a_file() {
        let (mut outlet, ring, shared) = outlet(1);
        assert!(outlet.put(rows(0)));
        shared.stop.store(true, Ordering::Relaxed);
        assert!(!outlet.put(rows(1)));
        shared.stop.store(false, Ordering::Relaxed);
        drop(ring);
        assert!(outlet.stops() && !outlet.put(rows(2)));
    }
}
