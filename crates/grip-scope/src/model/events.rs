//! Events and states in order of time in; what happened in a span, what comes next, and what happened to the object out.

use crate::feed::{EventKind, EventMark};
use crate::span::Span;
use std::collections::VecDeque;

/// Events and stretches kept of each kind; the oldest go first.
const MOST: usize = 50_000;

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

/// A stretch of time with a meaning; `to_s` of the last one grows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stretch<T> {
    /// Where it begins and ends.
    pub span: Span,
    /// What it means.
    pub what: T,
}

/// What happened.
#[derive(Clone, Debug, Default)]
pub struct Events {
    marks: VecDeque<EventMark>,
    /// Kind and time of the newest marks, in the order in which they came.
    arrivals: VecDeque<(EventKind, f64)>,
    /// Marks that have come so far.
    arrived: u64,
    doings: VecDeque<Stretch<Doing>>,
    slips: VecDeque<Stretch<EventKind>>,
    faults: VecDeque<Stretch<EventKind>>,
    gaps: VecDeque<Stretch<EventKind>>,
    /// Whether the last slip, or the last fault, goes on.
    slipping: bool,
    faulty: bool,
    /// Gaps so far, those included that were dropped.
    gapped: u64,
    text_bytes: usize,
}

impl Events {
    /// Takes an event whose time is on the axis.
    pub(super) fn push(&mut self, mark: EventMark) {
        let now = Span { from_s: mark.t_s, to_s: mark.t_s };
        match mark.kind {
            EventKind::Incipient | EventKind::Gross => {
                self.cut_slip(mark.t_s);
                append(&mut self.slips, Stretch { span: now, what: mark.kind });
                self.slipping = true;
            }
            EventKind::Ended => {
                self.cut_slip(mark.t_s);
                self.slipping = false;
            }
            EventKind::Fault if !self.faulty => {
                append(&mut self.faults, Stretch { span: now, what: EventKind::Fault });
                self.faulty = true;
            }
            EventKind::Recovered => {
                self.reach(mark.t_s);
                self.faulty = false;
            }
            _ => {}
        }
        self.arrived += 1;
        append(&mut self.arrivals, (mark.kind, mark.t_s));
        // Nearly always at the end: events come in order.
        let behind = self.marks.iter().rev().take_while(|other| other.t_s > mark.t_s).count();
        self.text_bytes += super::allocated(mark.text.capacity());
        self.marks.insert(self.marks.len() - behind, mark);
        if self.marks.len() > MOST {
            let gone = self.marks.pop_front();
            self.text_bytes -= gone.map_or(0, |mark| super::allocated(mark.text.capacity()));
        }
    }

    /// A slip, or its incipient part, ends here: states that came before its event have drawn it out.
    fn cut_slip(&mut self, t_s: f64) {
        if let Some(slip) = self.slips.back_mut().filter(|_| self.slipping) {
            slip.span.to_s = slip.span.from_s.max(t_s);
        }
    }

    fn end_slip(&mut self, t_s: f64) {
        if let Some(slip) = self.slips.back_mut().filter(|_| self.slipping) {
            slip.span.to_s = slip.span.to_s.max(t_s);
        }
    }

    pub(super) fn gap(&mut self, span: Span) {
        self.gapped += 1;
        append(&mut self.gaps, Stretch { span, what: EventKind::Gap });
    }

    pub(super) fn state(&mut self, t_s: f64, doing: Doing, joined: bool) {
        extend(&mut self.doings, t_s, doing, joined);
        self.reach(t_s);
    }

    /// What goes on reaches to this time.
    pub(super) fn reach(&mut self, t_s: f64) {
        self.end_slip(t_s);
        if let Some(fault) = self.faults.back_mut().filter(|_| self.faulty) {
            fault.span.to_s = fault.span.to_s.max(t_s);
        }
    }

    /// Nothing goes on.
    pub(super) fn interrupt(&mut self) {
        self.slipping = false;
        self.faulty = false;
    }

    /// All of them, in order of time.
    #[must_use]
    pub fn iter(&self) -> impl DoubleEndedIterator<Item = &EventMark> + ExactSizeIterator {
        self.marks.iter()
    }

    /// How many there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.marks.len()
    }

    /// Whether there is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.marks.is_empty()
    }

    /// Those in the span, its ends included.
    #[must_use]
    pub fn in_span(&self, span: Span) -> impl DoubleEndedIterator<Item = &EventMark> {
        let from = self.marks.partition_point(|mark| mark.t_s < span.from_s);
        let to = self.marks.partition_point(|mark| mark.t_s <= span.to_s);
        self.marks.range(from..to.max(from))
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

    /// The first one later than `t_s`.
    #[must_use]
    pub fn next_after(&self, t_s: f64) -> Option<&EventMark> {
        self.marks.get(self.marks.partition_point(|mark| mark.t_s <= t_s))
    }

    /// The last one before `t_s`.
    #[must_use]
    pub fn before(&self, t_s: f64) -> Option<&EventMark> {
        let at = self.marks.partition_point(|mark| mark.t_s < t_s).checked_sub(1)?;
        self.marks.get(at)
    }

    /// What happened to the object in the span.
    pub fn doings(&self, span: Span) -> impl Iterator<Item = &Stretch<Doing>> {
        within(&self.doings, span)
    }

    /// Slips in the span, their incipient and gross parts apart.
    pub fn slips(&self, span: Span) -> impl Iterator<Item = &Stretch<EventKind>> {
        within(&self.slips, span)
    }

    /// Faults in the span.
    pub fn faults(&self, span: Span) -> impl Iterator<Item = &Stretch<EventKind>> {
        within(&self.faults, span)
    }

    /// Stretches without samples in the span.
    pub fn gaps(&self, span: Span) -> impl Iterator<Item = &Stretch<EventKind>> {
        within(&self.gaps, span)
    }

    /// Bytes it takes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        let stretches = self.doings.capacity() + self.slips.capacity();
        let stretches = stretches + self.faults.capacity() + self.gaps.capacity();
        self.text_bytes
            + self.marks.capacity() * size_of::<EventMark>()
            + self.arrivals.capacity() * size_of::<(EventKind, f64)>()
            + stretches * size_of::<Stretch<Doing>>()
    }
}

/// Puts the newest in; the oldest goes where there are too many.
fn append<T>(list: &mut VecDeque<T>, newest: T) {
    list.push_back(newest);
    if list.len() > MOST {
        list.pop_front();
    }
}

/// Lets the last stretch reach to `t_s`, or begins another one.
fn extend<T: PartialEq>(list: &mut VecDeque<Stretch<T>>, t_s: f64, what: T, joined: bool) {
    if let Some(last) = list.back_mut().filter(|_| joined) {
        last.span.to_s = last.span.to_s.max(t_s);
        if last.what == what {
            return;
        }
    }
    append(list, Stretch { span: Span { from_s: t_s, to_s: t_s }, what });
}

fn within<T>(list: &VecDeque<Stretch<T>>, span: Span) -> impl Iterator<Item = &Stretch<T>> {
    let from = list.partition_point(|stretch| stretch.span.to_s < span.from_s);
    list.range(from..).take_while(move |stretch| stretch.span.from_s <= span.to_s)
}

#[cfg(test)]
mod tests {
    use super::Events;
    use crate::feed::{EventKind, EventMark};
    use crate::span::Span;

    #[test]
    fn a_slip_ends_with_its_event_even_where_later_states_came_before_it() {
        let mut events = Events::default();
        let mut push = |t_s, kind| events.push(EventMark::plain(t_s, kind, ""));
        push(1.0, EventKind::Incipient);
        push(1.1, EventKind::Gross);
        events.reach(1.3);
        events.push(EventMark::plain(1.2, EventKind::Ended, ""));
        events.reach(1.4);
        let ends: Vec<f64> = events.slips(Span::new(0.0, 9.0)).map(|slip| slip.span.to_s).collect();
        assert_eq!(ends, [1.1, 1.2]);
    }
}
