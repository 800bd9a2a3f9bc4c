//! Log of events, numbered once each: it gives all that came after one of them, as long as there was room.

use crate::{
    follower::Since,
    id::{EventId, Stamp, WallTime},
};
use std::collections::VecDeque;

/// An event with its number.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Logged {
    /// Its number.
    pub id: EventId,
    /// When it happened.
    pub at: WallTime,
    /// The frame.
    pub wire: Vec<u8>,
}

impl Logged {
    /// What it takes of the room (bytes): itself and what stands beside it.
    const fn size(&self) -> usize {
        self.wire.len() + Stamp::SIZE
    }
}

/// The events of one gripper, oldest first. Older ones make room for new ones.
#[derive(Clone, Debug)]
pub struct EventLog {
    run: u32,
    last: u64,
    events: VecDeque<Logged>,
    bytes: usize,
    room: usize,
    dropped: u64,
}

impl EventLog {
    /// An empty log of a run; at most `room` bytes are kept, but always the last event.
    #[must_use]
    pub const fn new(run: u32, room: usize) -> Self {
        Self { run, last: 0, events: VecDeque::new(), bytes: 0, room, dropped: 0 }
    }

    /// Puts an event of an earlier run behind the others.
    pub(crate) fn restore(&mut self, event: Logged) {
        self.push(event);
    }

    /// Numbers an event of which it is not known when it happened, and keeps it.
    pub fn append(&mut self, wire: Vec<u8>) -> EventId {
        self.append_at(wire, WallTime::default())
    }

    /// Numbers an event and keeps it.
    pub fn append_at(&mut self, wire: Vec<u8>, at: WallTime) -> EventId {
        self.last += 1;
        let id = self.head();
        self.push(Logged { id, at, wire });
        id
    }

    fn push(&mut self, event: Logged) {
        self.bytes += event.size();
        self.events.push_back(event);
        while self.bytes > self.room && self.events.len() > 1 {
            if let Some(oldest) = self.events.pop_front() {
                self.bytes -= oldest.size();
                self.dropped = self.dropped.saturating_add(1);
            }
        }
    }

    /// Number of the last event of this run; its `seq` is 0 before the first.
    #[must_use]
    pub const fn head(&self) -> EventId {
        EventId { run: self.run, seq: self.last }
    }

    /// Leaves numbers out: events that had no room before they could be numbered. Whoever asks learns that so many are missing.
    pub const fn skip(&mut self, count: u64) {
        self.last = self.last.saturating_add(count);
    }

    /// The place behind an event: the first of those named of whose run this log knows, also where it has made room itself. Where it knows of none
    /// of them, the beginning of all, or of this run where only what is new is wanted. Without an event, the beginning of all.
    #[must_use]
    pub fn place(&self, after: &[EventId], since: Since) -> u64 {
        let index = match after.iter().find_map(|after| self.behind(*after)) {
            Some(index) => index,
            None if since == Since::Now && !after.is_empty() => {
                self.begins(self.run).unwrap_or(self.events.len())
            }
            None => 0,
        };
        self.dropped + index as u64
    }

    /// Behind an event, also where that one has made room; none where nothing is known of its run.
    fn behind(&self, after: EventId) -> Option<usize> {
        let reported = |event: &Logged| event.id.run == after.run && event.id.seq <= after.seq;
        let last = self.events.iter().rposition(reported).map(|last| last + 1);
        let empty = (after.run == self.run).then_some(self.events.len());
        last.or_else(|| self.begins(after.run)).or(empty)
    }

    fn begins(&self, run: u32) -> Option<usize> {
        self.events.iter().position(|event| event.id.run == run)
    }

    /// Events from a place on, oldest first, as far as they have not made room.
    #[must_use]
    pub fn from(&self, place: u64) -> impl ExactSizeIterator<Item = &Logged> {
        let index = usize::try_from(place.saturating_sub(self.dropped)).unwrap_or(usize::MAX);
        self.events.range(index.min(self.events.len())..)
    }

    /// Events that have made room for others: the place of the oldest that is there.
    #[must_use]
    pub const fn dropped(&self) -> u64 {
        self.dropped
    }
}

#[cfg(test)]
mod tests {
    use super::{EventId, EventLog, Logged, Since};

    fn log(run: u32, events: u64, room: usize) -> EventLog {
        let mut log = EventLog::new(run, room);
        for event in 0..events {
            log.append(vec![u8::try_from(event % 256).unwrap(); 8]);
        }
        log
    }

    fn seqs<'a>(events: impl Iterator<Item = &'a Logged>) -> Vec<u64> {
        events.map(|event| event.id.seq).collect()
    }

    fn after(log: &EventLog, after: &[EventId]) -> Vec<u64> {
        seqs(log.from(log.place(after, Since::Start)))
    }

    #[test]
    fn everything_behind_an_event_is_reported_in_order() {
        let log = log(5, 6, 1000);
        let behind = |seq| after(&log, &[EventId { run: 5, seq }]);
        assert_eq!(after(&log, &[]), [1, 2, 3, 4, 5, 6]);
        assert_eq!(behind(0), [1, 2, 3, 4, 5, 6]);
        assert_eq!(behind(4), [5, 6]);
        assert!(behind(6).is_empty());
        // A number that was lost with the end of the log: what is there was reported before.
        assert!(behind(9).is_empty());
    }

    #[test]
    fn the_oldest_make_room() {
        let log = log(5, 10, 4 * 32);
        assert_eq!((log.from(0).len(), log.dropped(), log.head().seq), (4, 6, 10));
        assert_eq!(after(&log, &[EventId { run: 5, seq: 2 }]), [7, 8, 9, 10]);
        // Who has a place goes on from there, whatever has made room since.
        assert_eq!(
            (seqs(log.from(1)), seqs(log.from(8)), log.dropped()),
            (vec![7, 8, 9, 10], vec![9, 10], 6)
        );
        let tiny = super::tests::log(5, 3, 0);
        assert_eq!((tiny.from(0).len(), tiny.dropped()), (1, 2));
    }

    #[test]
    fn runs_stand_one_behind_the_other() {
        let mut both = EventLog::new(1, 1000);
        for event in log(9, 3, 1000).from(0) {
            both.restore(event.clone());
        }
        both.append(vec![1]);
        both.append(vec![2]);
        assert_eq!(both.head(), EventId { run: 1, seq: 2 });
        assert_eq!(after(&both, &[EventId { run: 9, seq: 2 }]), [3, 1, 2]);
        assert_eq!(after(&both, &[EventId { run: 9, seq: 7 }]), [1, 2]);
        let unknown = EventId { run: 4, seq: 7 };
        assert_eq!(after(&both, &[unknown]), [1, 2, 3, 1, 2]);
        // A run that only the receiver knows of: the one that it received before counts.
        assert_eq!(after(&both, &[unknown, EventId { run: 9, seq: 2 }]), [3, 1, 2]);
        // Who wants what is new is sent nothing of runs that were over before.
        assert_eq!(seqs(both.from(both.place(&[unknown], Since::Now))), [1, 2]);
        let empty = log(4, 0, 1000);
        assert!(after(&empty, &[EventId { run: 4, seq: 0 }]).is_empty());
    }

    #[test]
    fn numbers_that_are_left_out_are_seen() {
        let mut log = log(5, 2, 1000);
        log.skip(3);
        assert_eq!(log.append(vec![0]), EventId { run: 5, seq: 6 });
        assert_eq!(after(&log, &[EventId { run: 5, seq: 2 }]), [6]);
    }
}
