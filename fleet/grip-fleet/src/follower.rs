//! Receiver of numbered events of one gripper, as they come and as they are asked for again: each of them once, in the order of the log.

use crate::id::EventId;
use std::collections::VecDeque;

/// Runs whose last event is remembered: more starts of a daemon than a receiver is away for.
const RUNS: usize = 64;
/// Runs that a log is asked by: the gripper's computer may have lost the latest ones.
const NAMED: usize = 8;

/// What a receiver wants that has received nothing yet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Since {
    /// Everything that the gripper still has.
    Start,
    /// What happens from now on.
    Now,
}

/// What becomes of an event.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// It is the next one.
    New {
        /// Events before it that nobody has any more.
        missing: u64,
    },
    /// It was reported before.
    Known,
    /// Others come before it: ask. It comes again with the answer.
    Early,
}

/// What one receiver has received of one gripper.
#[derive(Clone, Debug)]
pub struct Follower {
    since: Since,
    /// The last event of each run, the run received last at the end.
    received: VecDeque<EventId>,
    asking: bool,
    /// Something came while it was asking that the answer may not hold.
    again: bool,
}

impl Follower {
    /// A receiver that has received nothing.
    #[must_use]
    pub const fn new(since: Since) -> Self {
        Self { since, received: VecDeque::new(), asking: false, again: false }
    }

    /// A receiver that has got these events before, the last of each run, the latest run at the end.
    #[must_use]
    pub fn resumed(since: Since, received: impl IntoIterator<Item = EventId>) -> Self {
        let mut resumed = Self::new(since);
        received.into_iter().for_each(|id| resumed.receive(id));
        resumed
    }

    /// The last event of each run that was received, the latest run at the end.
    pub fn received(&self) -> impl Iterator<Item = EventId> {
        self.received.iter().copied()
    }

    /// Takes an event as it was published.
    pub fn live(&mut self, id: EventId) -> Verdict {
        if self.known(id) {
            return Verdict::Known;
        }
        if self.asking {
            self.again = true;
            return Verdict::Early;
        }
        let next = match self.received.back() {
            Some(last) => last.run == id.run && last.seq + 1 == id.seq,
            None => self.since == Since::Now,
        };
        if next {
            self.receive(id);
            Verdict::New { missing: 0 }
        } else {
            Verdict::Early
        }
    }

    /// Takes the number of the gripper's last event, which stands beside everything else that it publishes; whether that is one to
    /// ask for.
    pub fn head(&mut self, id: EventId) -> bool {
        if self.received.is_empty() && self.since == Since::Now {
            self.receive(id);
        }
        let behind = !self.known(id) && (id.seq > 0 || self.received.is_empty());
        self.again |= behind && self.asking;
        behind
    }

    /// What to ask for: everything behind the first of these events of whose run the log knows, those of the last runs, the last one first; everything,
    /// where there are none. `None` while an answer is on its way, and where nothing before the next event is wanted.
    pub fn ask(&mut self) -> Option<Vec<EventId>> {
        let waits = self.received.is_empty() && self.since == Since::Now;
        if waits || core::mem::replace(&mut self.asking, true) {
            return None;
        }
        self.again = false;
        Some(self.received.iter().rev().take(NAMED).copied().collect())
    }

    /// Takes an event of the answer.
    pub fn answer(&mut self, id: EventId) -> Verdict {
        if self.known(id) {
            return Verdict::Known;
        }
        let before = self.received.iter().find(|last| last.run == id.run).map(|last| last.seq);
        let expected = match before {
            Some(seq) => seq + 1,
            // What a gripper no longer had when it was first received is not missed.
            None if self.received.is_empty() => id.seq,
            None => 1,
        };
        self.receive(id);
        Verdict::New { missing: id.seq.saturating_sub(expected) }
    }

    /// The answer is complete, or will not come; whether to ask again at once.
    pub fn answered(&mut self) -> bool {
        self.asking = false;
        core::mem::take(&mut self.again)
    }

    /// The answer will not come: the gripper, or the way to it, was away meanwhile. What comes of it later must not be taken.
    pub fn abandon(&mut self) {
        self.asking = false;
        self.again = false;
    }

    fn known(&self, id: EventId) -> bool {
        self.received.iter().any(|last| last.run == id.run && id.seq <= last.seq)
    }

    fn receive(&mut self, id: EventId) {
        self.received.retain(|last| last.run != id.run);
        if self.received.len() == RUNS {
            self.received.pop_front();
        }
        self.received.push_back(id);
    }
}

#[cfg(test)]
mod tests {
    use super::{EventId, Follower, Since, Verdict};
    use crate::log::{EventLog, Logged};
    use proptest::prelude::*;

    const NEW: Verdict = Verdict::New { missing: 0 };

    fn id(run: u32, seq: u64) -> EventId {
        EventId { run, seq }
    }

    #[test]
    fn events_in_order_need_no_question() {
        let mut follower = Follower::new(Since::Now);
        assert!(!follower.head(id(1, 4)));
        for seq in 5..9 {
            assert_eq!(follower.live(id(1, seq)), NEW);
            assert_eq!(follower.live(id(1, seq)), Verdict::Known);
            assert!(!follower.head(id(1, seq)));
        }
    }

    #[test]
    fn a_gap_is_asked_for_once_and_filled() {
        let mut follower = Follower::new(Since::Now);
        assert_eq!(follower.live(id(1, 1)), NEW);
        assert_eq!(follower.live(id(1, 4)), Verdict::Early);
        assert_eq!(follower.ask(), Some(vec![id(1, 1)]));
        assert_eq!(follower.ask(), None, "an answer is on its way");
        assert_eq!(follower.live(id(1, 5)), Verdict::Early);
        for seq in 2..5 {
            assert_eq!(follower.answer(id(1, seq)), NEW);
        }
        assert!(follower.answered(), "number 5 came meanwhile");
        assert_eq!(follower.ask(), Some(vec![id(1, 4)]));
        assert_eq!(follower.answer(id(1, 5)), NEW);
        assert!(!follower.answered());
        assert_eq!(follower.live(id(1, 6)), NEW);
    }

    #[test]
    fn the_last_events_before_a_silence_are_missed_too() {
        let mut follower = Follower::new(Since::Now);
        assert_eq!(follower.live(id(1, 1)), NEW);
        assert!(follower.head(id(1, 3)));
        assert_eq!(follower.ask(), Some(vec![id(1, 1)]));
    }

    #[test]
    fn another_run_is_asked_for_from_its_beginning() {
        let mut follower = Follower::new(Since::Start);
        assert!(follower.head(id(1, 0)), "earlier runs may have left something");
        assert_eq!(follower.ask(), Some(vec![]));
        assert_eq!(follower.answer(id(1, 7)), NEW, "what made room before is not missed");
        assert!(!follower.answered());
        assert!(!follower.head(id(2, 0)), "a run without events");
        assert_eq!(follower.live(id(2, 1)), Verdict::Early, "run 1 may have ended later");
        assert_eq!(follower.ask(), Some(vec![id(1, 7)]));
        assert_eq!(follower.answer(id(1, 8)), NEW);
        assert_eq!(follower.answer(id(2, 3)), Verdict::New { missing: 2 });
        assert_eq!(follower.answer(id(1, 8)), Verdict::Known);
        assert_eq!(follower.answer(id(2, 6)), Verdict::New { missing: 2 });
    }

    /// The gripper's computer has lost power, and with it the run that had just begun; before that there were more runs than a receiver remembers.
    #[test]
    fn a_run_that_a_crash_has_cost_brings_nothing_again() {
        let mut follower = Follower::new(Since::Start);
        let mut log = EventLog::new(100, 1 << 20);
        for run in 1..=99 {
            assert_eq!(follower.live(id(run, 1)), Verdict::Early);
            assert!(follower.ask().is_some());
            assert_eq!(follower.answer(id(run, 1)), NEW);
            assert!(!follower.answered());
            if run < 99 {
                let at = crate::WallTime::default();
                log.restore(Logged { id: id(run, 1), at, wire: Vec::new() });
            }
        }
        let next = log.append(Vec::new());
        assert_eq!(follower.live(next), Verdict::Early);
        let named = follower.ask().unwrap();
        let answer = log.from(log.place(&named, Since::Start)).map(|event| event.id);
        assert_eq!(answer.collect::<Vec<_>>(), [next]);
        assert_eq!(follower.answer(next), NEW);
    }

    #[test]
    fn a_question_that_is_abandoned_can_be_asked_again() {
        let mut follower = Follower::new(Since::Now);
        assert_eq!(follower.live(id(1, 1)), NEW);
        assert_eq!(follower.live(id(1, 3)), Verdict::Early);
        assert_eq!(follower.ask(), Some(vec![id(1, 1)]));
        assert_eq!(follower.ask(), None);
        follower.abandon();
        assert_eq!(follower.ask(), Some(vec![id(1, 1)]));
    }

    #[test]
    fn events_that_nobody_could_number_are_missing() {
        let mut log = EventLog::new(1, 1 << 20);
        let mut follower = Follower::new(Since::Now);
        let first = log.append(vec![0]);
        assert_eq!(follower.live(first), NEW);
        log.skip(4);
        let next = log.append(vec![0]);
        assert_eq!(follower.live(next), Verdict::Early);
        assert_eq!(follower.ask(), Some(vec![first]));
        assert_eq!(follower.answer(next), Verdict::New { missing: 4 });
    }

    /// What happens to the next event on its way.
    #[derive(Clone, Copy, Debug)]
    enum Fate {
        Arrives,
        Lost,
        Twice,
        /// The daemon starts again before it.
        Restart,
        /// The computer too, and has lost the run that had just begun.
        Crash,
        /// The number of the last event is reported.
        Reported,
    }

    fn fate() -> impl Strategy<Value = Fate> {
        prop_oneof![
            4 => Just(Fate::Arrives),
            3 => Just(Fate::Lost),
            1 => Just(Fate::Twice),
            1 => Just(Fate::Restart),
            1 => Just(Fate::Crash),
            2 => Just(Fate::Reported),
        ]
    }

    /// A gripper and a receiver with a bad line between them; `cut` answers end early.
    struct Line {
        log: EventLog,
        follower: Follower,
        got: Vec<EventId>,
        sent: Vec<EventId>,
        cut: usize,
    }

    impl Line {
        fn take(&mut self, verdict: Verdict, id: EventId) {
            match verdict {
                Verdict::New { missing } => {
                    assert_eq!(missing, 0, "{id}");
                    self.got.push(id);
                }
                Verdict::Known => {}
                Verdict::Early => self.catch_up(),
            }
        }

        fn catch_up(&mut self) {
            while let Some(after) = self.follower.ask() {
                let whole = self.cut == 0;
                self.cut = self.cut.saturating_sub(1);
                let take = if whole { usize::MAX } else { 1 };
                let answer: Vec<EventId> = self
                    .log
                    .from(self.log.place(&after, Since::Start))
                    .map(|event| event.id)
                    .take(take)
                    .collect();
                for id in answer {
                    let verdict = self.follower.answer(id);
                    self.take(verdict, id);
                }
                if !self.follower.answered() {
                    break;
                }
            }
        }

        fn restart(&mut self, keeps: impl Fn(u32) -> bool) {
            let mut next = EventLog::new(self.log.head().run + 1, 1 << 20);
            let kept = self.log.from(0).filter(|event| keeps(event.id.run));
            kept.for_each(|event| next.restore(event.clone()));
            self.log = next;
        }

        fn send(&mut self, fate: Fate) {
            match fate {
                Fate::Restart => self.restart(|_| true),
                Fate::Crash => {
                    self.restart(|_| true);
                    self.send(Fate::Arrives);
                    let lost = self.log.head().run;
                    self.restart(|run| run != lost);
                    // What nobody has received by then is gone.
                    let Self { sent, got, .. } = self;
                    sent.retain(|id| id.run != lost || got.contains(id));
                }
                Fate::Reported => {
                    if self.follower.head(self.log.head()) {
                        self.catch_up();
                    }
                }
                Fate::Arrives | Fate::Lost | Fate::Twice => {
                    let id = self.log.append(vec![0; 10]);
                    self.sent.push(id);
                    let times = match fate {
                        Fate::Arrives => 1,
                        Fate::Twice => 2,
                        _ => 0,
                    };
                    for _ in 0..times {
                        let verdict = self.follower.live(id);
                        self.take(verdict, id);
                    }
                }
            }
        }
    }

    proptest! {
        #[test]
        fn every_event_is_reported_once_in_order_over_any_line(
            fates in prop::collection::vec(fate(), 0..60),
            cut in 0_usize..4,
        ) {
            let mut line = Line {
                log: EventLog::new(1, 1 << 20),
                follower: Follower::new(Since::Start),
                got: Vec::new(),
                sent: Vec::new(),
                cut,
            };
            fates.into_iter().for_each(|fate| line.send(fate));
            // The line is good from now on, and something is said over it.
            line.cut = 0;
            line.send(Fate::Arrives);
            prop_assert_eq!(&line.got, &line.sent);
        }
    }
}
