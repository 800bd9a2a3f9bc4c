//! Where a channel passes a level, or is beyond it.

use super::node::Node;
use super::series::Series;
use super::store::LEAF;
use crate::span::Span;

impl Series {
    /// When the channel first passes `level` in the span (s), from at or below it to above, or the other way round. Behind a gap nothing
    /// has passed: it hides on which side the channel was.
    #[must_use]
    pub fn crossing(&self, span: Span, level: f32, rising: bool) -> Option<f64> {
        Search { level, up: rising, edge: true }.first(self, span)
    }

    /// When the channel is first above `level` in the span (s), or below it.
    #[must_use]
    pub fn beyond(&self, span: Span, level: f32, above: bool) -> Option<f64> {
        Search { level, up: above, edge: false }.first(self, span)
    }
}

/// A level, the side of it that is waited for, and whether it has to be passed.
#[derive(Clone, Copy)]
struct Search {
    level: f32,
    up: bool,
    edge: bool,
}

impl Search {
    fn is_beyond(self, value: f32) -> bool {
        if self.up { value > self.level } else { value < self.level }
    }

    /// Whether all samples of a node lie beyond; `None` where they differ, or something is missing.
    fn of_node(self, node: &Node) -> Option<bool> {
        let (min, max) = node.extremes().filter(|_| !node.is_broken())?;
        let (low, high) = (self.is_beyond(min), self.is_beyond(max));
        (low == high).then_some(low)
    }

    fn first(self, series: &Series, span: Span) -> Option<f64> {
        let (store, numbers) = (&series.store, series.numbers(span));
        // The sample before the span shows on which side it begins.
        let mut number = numbers.start.saturating_sub(u64::from(self.edge)).max(store.first());
        let mut near = !self.edge;
        while number < numbers.end {
            let whole = number.is_multiple_of(LEAF) && number + LEAF <= numbers.end;
            let leaf = store.leaf(number).filter(|_| whole).and_then(|node| self.of_node(node));
            let value = store.value(number);
            let beyond = leaf.unwrap_or_else(|| self.is_beyond(value));
            let hidden = self.edge && (value.is_nan() || store.is_break(number));
            if beyond && near && !hidden && number >= numbers.start {
                return store.time(number);
            }
            near = !self.edge || !(beyond || value.is_nan());
            number += if leaf.is_some() { LEAF } else { 1 };
        }
        None
    }
}
