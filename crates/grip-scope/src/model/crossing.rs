//! A level and a span in; where a channel passes the level, or is beyond it, out.
//!
//! Where samples are thinned out, the extremes of 32 show it: what is found stands where those 32 begin. Whether a channel came back to the
//! level and left it again within the same 32, they do not show.

use super::chunk::{Chunk, NODE};
use super::node::Node;
use super::series::Series;
use super::store::Place;
use crate::span::Span;
use core::ops::Range;

impl Series {
    /// When the channel first passes `level` in the span (s), from at or below it to above, or the other way round.
    #[must_use]
    pub fn crossing(&self, span: Span, level: f32, rising: bool) -> Option<f64> {
        let (from, to) = self.places(span);
        let side = Side { level, up: rising };
        Search { side, last: GAP, edge: true, from }.run(self, self.before(from), to)
    }

    /// When the channel is first above `level` in the span (s), or below it.
    #[must_use]
    pub fn beyond(&self, span: Span, level: f32, above: bool) -> Option<f64> {
        let (from, to) = self.places(span);
        let side = Side { level, up: above };
        Search { side, last: Last::Near, edge: false, from }.run(self, from, to)
    }
}

/// A level, and the side of it that is waited for.
#[derive(Clone, Copy)]
struct Side {
    level: f32,
    up: bool,
}

/// Where samples lie.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Part {
    /// All at the level or on the side that is not waited for.
    Near,
    /// On both sides, in an order that is not known.
    Mixed,
    /// All on the side that is waited for.
    Beyond,
}

impl Side {
    fn of_value(self, value: f32) -> Part {
        let beyond = if self.up { value > self.level } else { value < self.level };
        if beyond { Part::Beyond } else { Part::Near }
    }

    /// `None` where there is no finite sample.
    fn of_node(self, node: &Node) -> Option<Part> {
        let (min, max) = node.extremes()?;
        let (low, high) = (self.of_value(min), self.of_value(max));
        Some(if low == high { low } else { Part::Mixed })
    }
}

/// Where the channel was.
#[derive(Clone, Copy)]
enum Last {
    Near,
    Beyond,
    /// It came near in the samples that begin at this time (s), and may be beyond again.
    Dipped(f64),
}

/// A gap, as what lies before the first sample, hides on which side it was: behind it nothing has passed.
const GAP: Last = Last::Beyond;

/// A look from sample to sample, by groups of 32 where those show enough.
struct Search {
    side: Side,
    last: Last,
    /// Only where it passes.
    edge: bool,
    /// What is found before this place does not count.
    from: Place,
}

impl Search {
    fn run(mut self, series: &Series, mut place: Place, to: Place) -> Option<f64> {
        while place < to {
            let chunk = series.store().chunk(place.chunk)?;
            let end = if place.chunk == to.chunk { to.index.min(chunk.len()) } else { chunk.len() };
            let found = self.chunk(chunk, place.chunk, place.index..end);
            if found.is_some() {
                return found;
            }
            place = Place { chunk: place.chunk + 1, index: 0 };
        }
        None
    }

    fn chunk(&mut self, chunk: &Chunk, number: u64, range: Range<usize>) -> Option<f64> {
        let mut index = range.start;
        while index < range.end {
            let counts = Place { chunk: number, index } >= self.from;
            let t_s = chunk.time(index);
            let (part, behind) = self.look(chunk, index, range.end);
            let found = part.and_then(|part| self.take(part, t_s, counts));
            if found.is_some() {
                return found;
            }
            if part.is_none() && self.edge {
                self.last = GAP;
            }
            index = behind;
        }
        None
    }

    /// Where the samples from `index` on lie, and the first one behind them; `None` where they are no numbers.
    fn look(&self, chunk: &Chunk, index: usize, end: usize) -> (Option<Part>, usize) {
        let behind = (index / NODE + 1) * NODE;
        let node = chunk.node(index / NODE);
        if chunk.is_thin() {
            return (node.and_then(|node| self.side.of_node(node)), behind);
        }
        if index.is_multiple_of(NODE)
            && behind <= end
            && let Some(node) = node.filter(|node| !node.is_broken())
            && let Some(part) = self.side.of_node(node).filter(|part| *part != Part::Mixed)
        {
            return (Some(part), behind);
        }
        let value = chunk.value(index);
        ((!value.is_nan()).then(|| self.side.of_value(value)), index + 1)
    }

    fn take(&mut self, part: Part, t_s: f64, counts: bool) -> Option<f64> {
        let found_s = match (self.last, part) {
            (_, Part::Near) => {
                self.last = Last::Near;
                return None;
            }
            (Last::Near, _) => t_s,
            (Last::Dipped(dip_s), _) => dip_s,
            (Last::Beyond, Part::Mixed) if counts => {
                self.last = Last::Dipped(t_s);
                return None;
            }
            (Last::Beyond, _) => return None,
        };
        self.last = Last::Beyond;
        counts.then_some(found_s)
    }
}
