//! Ring of the samples of one channel, with one pyramid of extremes above it.
//!
//! Samples are numbered from the first one on. They lie in blocks of 1024, of which the oldest goes as a whole. A node of the lowest level
//! knows 32 samples, one of each level above four nodes of the level below: a sum over any stretch looks at some dozen nodes and at most
//! 62 samples, however long it is.

use super::allocated;
use super::node::{Node, Sum};
use core::ops::Range;
use std::collections::VecDeque;
use std::sync::Arc;

/// Samples of a block.
pub(super) const BLOCK: usize = 1024;
/// Samples of a node of the lowest level, as bits.
const LEAF_BITS: u32 = 5;
/// The same as a number.
pub(super) const LEAF: u64 = 1 << LEAF_BITS;
/// Nodes of a level that one node of the next level holds, as bits.
const FACTOR_BITS: u32 = 2;
/// Times that are off an even step by less than this (s), or this share of the step, are not kept one by one.
const EVEN_S: f64 = 2e-6;
const EVEN_SHARE: f64 = 0.01;

/// Samples in order of time.
#[derive(Clone, Debug)]
struct Block {
    from_s: f64,
    last_s: f64,
    /// Mean time from sample to sample, once it is full (s).
    step_s: f64,
    /// Time of each sample (s); empty where the step shows them.
    times: Vec<f64>,
    values: Vec<f32>,
}

impl Block {
    fn new(from_s: f64) -> Self {
        let (times, values) = (Vec::with_capacity(BLOCK), Vec::with_capacity(BLOCK));
        Self { from_s, last_s: from_s, step_s: 0.0, times, values }
    }

    /// Forgets times that are even to the accuracy of a device's clock.
    fn close(&mut self) {
        self.step_s = (self.last_s - self.from_s) / exact(self.values.len() - 1);
        let bound_s = EVEN_S.max(EVEN_SHARE * self.step_s);
        let even = |(k, t_s): (usize, &f64)| (t_s - self.even_s(k)).abs() <= bound_s;
        if self.times.iter().enumerate().all(even) {
            self.times = Vec::new();
        }
    }

    /// Devices report whole microseconds: so even times come back as they were.
    fn even_s(&self, index: usize) -> f64 {
        whole_micros(self.from_s + self.step_s * exact(index))
    }

    fn time(&self, index: usize) -> f64 {
        self.times.get(index).copied().unwrap_or_else(|| self.even_s(index))
    }

    /// The first sample that is not before `t_s`.
    fn index(&self, t_s: f64) -> usize {
        if t_s <= self.from_s {
            return 0;
        }
        if !self.times.is_empty() {
            return self.times.partition_point(|time| *time < t_s);
        }
        // Rounding may be off by one; the comparison decides.
        let guess = floor_index((t_s - self.from_s) / self.step_s).min(self.values.len());
        let mut index = guess.saturating_sub(1);
        while index < self.values.len() && self.even_s(index) < t_s {
            index += 1;
        }
        index
    }

    const fn bytes(&self) -> usize {
        let times = allocated(self.times.capacity() * size_of::<f64>());
        times + allocated(self.values.capacity() * size_of::<f32>())
    }
}

/// The samples of one channel.
#[derive(Clone, Debug, Default)]
pub(super) struct Store {
    /// All full but the last.
    blocks: VecDeque<Arc<Block>>,
    /// Number of the first sample that is kept.
    first: u64,
    /// Numbers of the samples that do not join the one before them.
    breaks: VecDeque<u64>,
    levels: Vec<Level>,
    /// Bytes of the full blocks.
    full_bytes: usize,
}

/// One level of the pyramid; its first node has the number `first`.
#[derive(Clone, Debug, Default)]
struct Level {
    nodes: VecDeque<Node>,
    first: u64,
}

impl Store {
    /// Takes a sample that is not before the last one.
    pub(super) fn push(&mut self, t_s: f64, value: f32, broken: bool) {
        let number = self.end();
        if broken {
            self.breaks.push_back(number);
        }
        if self.blocks.back().is_none_or(|block| block.values.len() == BLOCK) {
            self.blocks.push_back(Arc::new(Block::new(t_s)));
        }
        // Whoever copies out of it keeps the block as it was.
        let Some(block) = self.blocks.back_mut().map(Arc::make_mut) else { return };
        block.times.push(t_s);
        block.values.push(value);
        block.last_s = t_s;
        if block.values.len() == BLOCK {
            block.close();
            self.full_bytes += block.bytes();
        }
        if (number + 1).is_multiple_of(LEAF) {
            self.climb(number + 1);
        }
    }

    /// Adds the node of the samples before `end`, and those that it completes above.
    fn climb(&mut self, end: u64) {
        let mut sum = Sum::default();
        self.fold_values(end - LEAF..end, &mut sum);
        for level in 0.. {
            if level == self.levels.len() {
                self.levels.push(Level::default());
            }
            let Some(Level { nodes, first }) = self.levels.get_mut(level) else { return };
            nodes.push_back(sum.node());
            if !(*first + nodes.len() as u64).is_multiple_of(1 << FACTOR_BITS) {
                return;
            }
            sum = Sum::default();
            nodes.iter().rev().take(1 << FACTOR_BITS).for_each(|node| sum.add_node(node));
        }
    }

    /// Number of the first sample.
    pub(super) const fn first(&self) -> u64 {
        self.first
    }

    /// Number behind that of the last sample.
    pub(super) fn end(&self) -> u64 {
        let open = self.blocks.back().map_or(0, |block| block.values.len());
        self.first + (self.blocks.len().saturating_sub(1) * BLOCK + open) as u64
    }

    fn place(&self, number: u64) -> Option<(&Block, usize)> {
        let at = usize::try_from(number.checked_sub(self.first)?).ok()?;
        Some((self.blocks.get(at / BLOCK)?, at % BLOCK))
    }

    /// Time of a sample (s); `None` where there is none of this number.
    pub(super) fn time(&self, number: u64) -> Option<f64> {
        let (block, index) = self.place(number)?;
        (index < block.values.len()).then(|| block.time(index))
    }

    /// Value of a sample; NaN where there is none.
    pub(super) fn value(&self, number: u64) -> f32 {
        let value = self.place(number).and_then(|(block, index)| block.values.get(index));
        value.copied().unwrap_or(f32::NAN)
    }

    /// Whether a sample does not join the one before it.
    pub(super) fn is_break(&self, number: u64) -> bool {
        self.breaks.binary_search(&number).is_ok()
    }

    /// Time of the first and of the last sample.
    pub(super) fn span(&self) -> Option<(f64, f64)> {
        Some((self.blocks.front()?.from_s, self.blocks.back()?.last_s))
    }

    /// Number of the first sample that is not before `t_s`, at or after `from`.
    pub(super) fn index(&self, t_s: f64, from: u64) -> u64 {
        let near = usize::try_from(from.saturating_sub(self.first)).unwrap_or(0) / BLOCK;
        let ends_before =
            |block: usize| self.blocks.get(block).is_some_and(|block| block.last_s < t_s);
        // The next column of a picture begins near: leaps that double, then halving.
        let (mut block, mut leap) = (near, 1);
        while ends_before(block + leap - 1) {
            block += leap;
            leap *= 2;
        }
        let mut behind = block + leap - 1;
        while block < behind {
            let middle = block.midpoint(behind);
            if ends_before(middle) {
                block = middle + 1;
            } else {
                behind = middle;
            }
        }
        let index = self.blocks.get(block).map_or(0, |block| block.index(t_s));
        (self.first + (block * BLOCK + index) as u64).clamp(from.min(self.end()), self.end())
    }

    /// Adds the samples of these numbers.
    pub(super) fn fold(&self, numbers: Range<u64>, sum: &mut Sum) {
        let (mut at, to) = (numbers.start.max(self.first), numbers.end.min(self.end()));
        while at < to {
            // The highest node that begins here and ends in time.
            let levels = (at.trailing_zeros().min((to - at).ilog2()) + FACTOR_BITS)
                .saturating_sub(LEAF_BITS)
                / FACTOR_BITS;
            let found = (0..levels).rev().find_map(|level| Some((level, self.node(at, level)?)));
            if let Some((level, node)) = found {
                sum.add_node(node);
                at += LEAF << (FACTOR_BITS * level);
            } else {
                let end = (at + 1).next_multiple_of(LEAF).min(to);
                self.fold_values(at..end, sum);
                at = end;
            }
        }
    }

    /// The node of a level that begins with a sample.
    fn node(&self, number: u64, level: u32) -> Option<&Node> {
        let level_of = self.levels.get(usize::try_from(level).ok()?)?;
        let node = (number >> (LEAF_BITS + FACTOR_BITS * level)).checked_sub(level_of.first)?;
        level_of.nodes.get(usize::try_from(node).ok()?)
    }

    /// The node of the lowest level that begins with a sample, a multiple of [`LEAF`].
    pub(super) fn leaf(&self, number: u64) -> Option<&Node> {
        self.node(number, 0)
    }

    /// Adds samples one by one; at most up to the next multiple of [`LEAF`].
    fn fold_values(&self, numbers: Range<u64>, sum: &mut Sum) {
        let Some((block, from)) = self.place(numbers.start) else { return };
        let count = usize::try_from(numbers.end - numbers.start).unwrap_or(0);
        let to = (from + count).min(block.values.len());
        sum.add_values(block.values.get(from..to).unwrap_or_default());
        // Mostly there is none, or none so late.
        if self.breaks.back().is_some_and(|last| *last >= numbers.start) {
            let next = self.breaks.partition_point(|number| *number < numbers.start);
            sum.broken |= self.breaks.get(next).is_some_and(|number| *number < numbers.end);
        }
    }

    /// Bytes of samples, times and the pyramid.
    pub(super) fn bytes(&self) -> usize {
        let nodes: usize = self.levels.iter().map(|level| level.nodes.capacity()).sum();
        let open = self.blocks.back().filter(|block| block.values.len() < BLOCK);
        self.full_bytes
            + open.map_or(0, |block| block.bytes())
            + self.blocks.len() * allocated(size_of::<Block>() + 16)
            + self.blocks.capacity() * size_of::<Arc<Block>>()
            + nodes * size_of::<Node>()
            + self.breaks.capacity() * size_of::<u64>()
    }

    /// Time of the oldest samples, where they lie in a full block.
    pub(super) fn oldest_s(&self) -> Option<f64> {
        let full = |block: &&Arc<Block>| block.values.len() == BLOCK;
        self.blocks.front().filter(full).map(|block| block.from_s)
    }

    /// Drops the oldest full block.
    pub(super) fn drop_oldest(&mut self) {
        if self.oldest_s().is_none() {
            return;
        }
        let Some(block) = self.blocks.pop_front() else { return };
        self.full_bytes -= block.bytes();
        self.first += BLOCK as u64;
        while self.breaks.front().is_some_and(|number| *number < self.first) {
            self.breaks.pop_front();
        }
        let mut bits = LEAF_BITS;
        for Level { nodes, first } in &mut self.levels {
            while *first < self.first >> bits && nodes.pop_front().is_some() {
                *first += 1;
            }
            bits += FACTOR_BITS;
        }
    }

    /// The samples of these numbers, whatever becomes of the store meanwhile.
    pub(super) fn samples(&self, numbers: Range<u64>) -> Samples {
        let range = numbers.start.max(self.first)..numbers.end.min(self.end());
        let block =
            |number: u64| usize::try_from((number - self.first) / BLOCK as u64).unwrap_or(0);
        if range.is_empty() {
            return Samples::default();
        }
        let (from, to) = (block(range.start), block(range.end - 1) + 1);
        let breaks = self.breaks.partition_point(|number| *number < range.start);
        let store = Self {
            blocks: self.blocks.range(from..to).cloned().collect(),
            first: self.first + (from * BLOCK) as u64,
            breaks: self.breaks.range(breaks..).copied().collect(),
            ..Self::default()
        };
        Samples { store, range }
    }
}

/// Samples of a channel in order of time.
#[derive(Clone, Debug, Default)]
pub(crate) struct Samples {
    store: Store,
    range: Range<u64>,
}

/// Time (s), value, and whether something is missing before it.
impl Iterator for Samples {
    type Item = (f64, f32, bool);

    fn next(&mut self) -> Option<Self::Item> {
        let number = self.range.next()?;
        let t_s = self.store.time(number)?;
        Some((t_s, self.store.value(number), self.store.is_break(number)))
    }
}

fn exact(index: usize) -> f64 {
    index as f64
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "the cast saturates")]
fn floor_index(place: f64) -> usize {
    if place.is_finite() { place as usize } else { 0 }
}

/// The nearest whole microsecond (s); times on the axis are not negative.
#[expect(clippy::cast_possible_truncation, reason = "exact for 285 years")]
fn whole_micros(t_s: f64) -> f64 {
    (1e6 * t_s + 0.5) as i64 as f64 / 1e6
}
