//! Events and states in order of time: what happened in a span, what comes next, and what happened to the object.

use super::timeline::{Room, Stretch, Timeline};
use crate::feed::{EventKind, EventMark};
use crate::span::Span;
use std::collections::VecDeque;

/// Events and stretches kept of each kind.
const MOST: usize = 50_000;
const ROOM: Room = Room::Items(MOST);

slip_msg::named! {
    /// What happens to the object, the worst last.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
    pub enum Doing {
        fn name: "One word for people.";
    }
    Idle: "Nothing is held, or no force is known.", "idle";
    Moving: "Arm or fingers move: no decision on slip.", "moving";
    Held: "It stands in the fingers.", "HELD";
    Slipping: "It slides.", "SLIPPING";
    Crushed: "It was pressed harder than it bears: only a simulator knows.", "CRUSHED";
    Dropped: "It has left the fingers: only a simulator knows.", "DROPPED";
}

/// What happened.
#[derive(Clone, Debug, Default)]
pub struct Events {
    /// All events.
    pub marks: Timeline<EventMark>,
    /// What happened to the object.
    pub doings: Timeline<Stretch<Doing>>,
    /// Slips, their incipient and gross parts apart.
    pub slips: Timeline<Stretch<EventKind>>,
    /// Faults.
    pub faults: Timeline<Stretch<EventKind>>,
    /// Stretches without samples.
    pub gaps: Timeline<Stretch<EventKind>>,
    /// Kind and time of the newest marks, in the order in which they came.
    arrivals: VecDeque<(EventKind, f64)>,
    /// Marks that have come so far.
    arrived: u64,
    /// Whether the last slip, or the last fault, goes on.
    slipping: bool,
    faulty: bool,
    /// Gaps so far, those included that were dropped.
    gapped: u64,
}

impl Events {
    /// Takes an event whose time is on the axis.
    pub(super) fn push(&mut self, mark: EventMark) {
        let now = Span { from_s: mark.t_s, to_s: mark.t_s };
        match mark.kind {
            EventKind::Incipient | EventKind::Gross => {
                self.cut_slip(mark.t_s);
                self.slips.append(Stretch { span: now, what: mark.kind }, ROOM);
                self.slipping = true;
            }
            EventKind::Ended => {
                self.cut_slip(mark.t_s);
                self.slipping = false;
            }
            EventKind::Fault if !self.faulty => {
                self.faults.append(Stretch { span: now, what: EventKind::Fault }, ROOM);
                self.faulty = true;
            }
            EventKind::Recovered => {
                self.reach(mark.t_s);
                self.faulty = false;
            }
            _ => {}
        }
        self.arrived += 1;
        self.arrivals.push_back((mark.kind, mark.t_s));
        if self.arrivals.len() > MOST {
            self.arrivals.pop_front();
        }
        self.marks.insert(mark, ROOM);
    }

    /// A slip, or its incipient part, ends here: states that came before its event have drawn it out.
    fn cut_slip(&mut self, t_s: f64) {
        if let Some(slip) = self.slips.last_mut().filter(|_| self.slipping) {
            slip.span.to_s = slip.span.from_s.max(t_s);
        }
    }

    fn end_slip(&mut self, t_s: f64) {
        if let Some(slip) = self.slips.last_mut().filter(|_| self.slipping) {
            slip.span.to_s = slip.span.to_s.max(t_s);
        }
    }

    pub(super) fn gap(&mut self, span: Span) {
        self.gapped += 1;
        self.gaps.append(Stretch { span, what: EventKind::Gap }, ROOM);
    }

    pub(super) fn state(&mut self, t_s: f64, doing: Doing, joined: bool) {
        let last = self.doings.last_mut().filter(|_| joined);
        let goes_on = last.is_some_and(|last| {
            last.span.to_s = last.span.to_s.max(t_s);
            last.what == doing
        });
        if !goes_on {
            let span = Span { from_s: t_s, to_s: t_s };
            self.doings.append(Stretch { span, what: doing }, ROOM);
        }
        self.reach(t_s);
    }

    /// What goes on reaches to this time.
    pub(super) fn reach(&mut self, t_s: f64) {
        self.end_slip(t_s);
        if let Some(fault) = self.faults.last_mut().filter(|_| self.faulty) {
            fault.span.to_s = fault.span.to_s.max(t_s);
        }
    }

    /// Nothing goes on.
    pub(super) fn interrupt(&mut self) {
        self.slipping = false;
        self.faulty = false;
    }

    /// Gaps in the samples so far, those included that were dropped.
    #[must_use]
    pub const fn gapped(&self) -> u64 {
        self.gapped
    }

    /// How many have come so far, those included that were dropped.
    #[must_use]
    pub const fn arrived(&self) -> u64 {
        self.arrived
    }

    /// Number, kind and time (s) of those that came after the first `number`, in the order in which they came, whatever their times.
    pub fn arrivals_after(&self, number: u64) -> impl Iterator<Item = (u64, EventKind, f64)> {
        let first = self.arrived - self.arrivals.len() as u64;
        let skipped = usize::try_from(number.saturating_sub(first)).unwrap_or(usize::MAX);
        let numbered = (first + 1..).zip(&self.arrivals).skip(skipped);
        numbered.map(|(number, (kind, t_s))| (number, *kind, *t_s))
    }

    /// Bytes it takes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        let stretches = self.slips.bytes() + self.faults.bytes() + self.gaps.bytes();
        let arrivals = self.arrivals.capacity() * size_of::<(EventKind, f64)>();
        self.marks.bytes() + self.doings.bytes() + stretches + arrivals
    }
}

#[cfg(test)]
mod tests {
    use super::Events;
    use crate::feed::{EventKind, EventMark};

    #[test]
    fn a_slip_ends_with_its_event_even_where_later_states_came_before_it() {
        let mut events = Events::default();
        let mut push = |t_s, kind| events.push(EventMark::plain(t_s, kind, ""));
        push(1.0, EventKind::Incipient);
        push(1.1, EventKind::Gross);
        events.reach(1.3);
        events.push(EventMark::plain(1.2, EventKind::Ended, ""));
        events.reach(1.4);
        let ends: Vec<f64> = events.slips.iter().map(|slip| slip.span.to_s).collect();
        assert_eq!(ends, [1.1, 1.2]);
    }
}
