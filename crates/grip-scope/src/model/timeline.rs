//! Items in order of time, as many as there is room for: the oldest go first.

use super::allocated;
use crate::feed::{EventMark, SpectrumColumn, Turn};
use crate::span::Span;
use std::collections::VecDeque;

/// What has a place in time.
pub trait Timed {
    /// Where it begins and ends.
    fn span(&self) -> Span;

    /// Bytes that it takes beside its own size.
    fn held(&self) -> usize {
        0
    }
}

/// How much is kept.
#[derive(Clone, Copy, Debug)]
pub(super) enum Room {
    Items(usize),
    Bytes(usize),
}

/// Items in order of time.
#[derive(Clone, Debug)]
pub struct Timeline<T> {
    items: VecDeque<T>,
    held: usize,
}

impl<T> Default for Timeline<T> {
    fn default() -> Self {
        Self { items: VecDeque::new(), held: 0 }
    }
}

impl<T: Timed> Timeline<T> {
    /// Puts an item behind those that do not begin after it.
    pub(super) fn insert(&mut self, item: T, room: Room) {
        let begins_s = item.span().from_s;
        // Nearly always there is none.
        let later = self.items.iter().rev().take_while(|other| other.span().from_s > begins_s);
        self.place(later.count(), item, room);
    }

    /// Puts an item behind all others.
    pub(super) fn append(&mut self, item: T, room: Room) {
        self.place(0, item, room);
    }

    fn place(&mut self, from_end: usize, item: T, room: Room) {
        self.held += item.held();
        self.items.insert(self.items.len() - from_end, item);
        while match room {
            Room::Items(most) => self.items.len() > most,
            Room::Bytes(most) => self.held + self.items.len() * size_of::<T>() > most,
        } {
            let Some(oldest) = self.items.pop_front() else { return };
            self.held -= oldest.held();
        }
    }

    /// Those that touch the span, its ends included.
    #[must_use]
    pub fn within(&self, span: Span) -> impl DoubleEndedIterator<Item = &T> + ExactSizeIterator {
        let from = self.items.partition_point(|item| item.span().to_s < span.from_s);
        let to = self.items.partition_point(|item| item.span().from_s <= span.to_s);
        self.items.range(from..to.max(from))
    }

    /// The last one that begins at or before `t_s`.
    #[must_use]
    pub fn at(&self, t_s: f64) -> Option<&T> {
        self.within(Span { from_s: f64::NEG_INFINITY, to_s: t_s }).next_back()
    }

    /// The first one that ends at or after `t_s`.
    #[must_use]
    pub fn from(&self, t_s: f64) -> Option<&T> {
        self.within(Span { from_s: t_s, to_s: f64::INFINITY }).next()
    }

    /// All of them.
    #[must_use]
    pub fn iter(&self) -> impl DoubleEndedIterator<Item = &T> + ExactSizeIterator {
        self.items.iter()
    }

    pub(super) fn last_mut(&mut self) -> Option<&mut T> {
        self.items.back_mut()
    }

    /// How many there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.items.len()
    }

    /// Whether there is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.items.is_empty()
    }

    /// Bytes it takes.
    pub(super) fn bytes(&self) -> usize {
        self.held + self.items.capacity() * size_of::<T>()
    }
}

/// A time (s).
impl Timed for f64 {
    fn span(&self) -> Span {
        Span { from_s: *self, to_s: *self }
    }
}

impl Timed for Turn {
    fn span(&self) -> Span {
        self.t_s.span()
    }
}

impl Timed for EventMark {
    fn span(&self) -> Span {
        self.t_s.span()
    }

    fn held(&self) -> usize {
        allocated(self.text.capacity())
    }
}

impl Timed for SpectrumColumn {
    fn span(&self) -> Span {
        let [from_s, to_s] = self.span;
        Span { from_s, to_s }
    }

    fn held(&self) -> usize {
        allocated(self.bins.len())
    }
}

/// One frame of the pressure array.
#[derive(Clone, Debug, PartialEq)]
pub struct TaxelFrame {
    /// When (s).
    pub t_s: f64,
    /// Readings; NaN: none.
    pub values: Vec<f32>,
}

impl Timed for TaxelFrame {
    fn span(&self) -> Span {
        self.t_s.span()
    }

    fn held(&self) -> usize {
        allocated(4 * self.values.len())
    }
}

/// A stretch of time with a meaning; `to_s` of the last one grows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stretch<T> {
    /// Where it begins and ends.
    pub span: Span,
    /// What it means.
    pub what: T,
}

impl<T> Timed for Stretch<T> {
    fn span(&self) -> Span {
        self.span
    }
}

#[cfg(test)]
mod tests {
    use super::{Room, Timeline};
    use crate::feed::SpectrumColumn;

    #[test]
    fn the_oldest_go_where_there_are_too_many_and_the_others_are_found() {
        let mut spectra = Timeline::default();
        let mut times = Timeline::default();
        for k in 0..1000_u16 {
            let (from_s, bins) = (f64::from(k), vec![1; 100].into());
            let spectrum = SpectrumColumn { span: [from_s, from_s + 1.0], top_hz: 1.0, bins };
            spectra.insert(spectrum, Room::Bytes(20_000));
            times.append(from_s, Room::Items(900));
        }
        let first_s = spectra.iter().next().map(|column| column.span[0]);
        assert_eq!(first_s, Some(1000.0 - spectra.len() as f64));
        let bytes = spectra.held + spectra.len() * size_of::<SpectrumColumn>();
        assert!(spectra.len() > 100 && bytes <= 20_000, "{} {bytes}", spectra.len());
        assert_eq!([99.0, 100.5, 9e9].map(|t_s| times.at(t_s)), [None, Some(&100.0), Some(&999.0)]);
        assert_eq!(
            [0.0, 100.5, 9e9].map(|t_s| times.from(t_s)),
            [Some(&100.0), Some(&101.0), None]
        );
    }
}
