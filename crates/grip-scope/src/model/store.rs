//! Chunks of samples in; sums over any stretch of them out, at a cost that hardly grows with its length.
//!
//! Above the chunks stands a pyramid: four chunks, four times four, and so on. The oldest chunks are first thinned out to
//! their nodes and then dropped.

use super::chunk::{Chunk, partition};
use super::node::{Fold, Node, Sum};
use std::collections::VecDeque;

/// Nodes of a level that one node of the next level holds, as bits.
const FACTOR_BITS: u32 = 2;

/// A place among the samples: number of the chunk since the beginning, and of the sample in it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Place {
    pub(super) chunk: u64,
    pub(super) index: usize,
}

/// All samples of one channel.
#[derive(Clone, Debug, Default)]
pub(super) struct Store {
    /// Closed chunks; the first has the number `first`.
    chunks: VecDeque<Chunk>,
    first: u64,
    levels: Vec<Layer>,
    open: Option<Chunk>,
    /// Bytes of the closed chunks.
    bytes: usize,
    /// Closed chunks from the front that are thinned out.
    thin: usize,
    /// Bytes that thinning all chunks would free.
    whole_bytes: usize,
}

/// One level of the pyramid; its first node has the number `first`.
#[derive(Clone, Debug, Default)]
struct Layer {
    nodes: VecDeque<Node>,
    first: u64,
}

impl Layer {
    fn get(&self, number: u64) -> Option<&Node> {
        self.nodes.get(usize::try_from(number.checked_sub(self.first)?).ok()?)
    }

    fn end(&self) -> u64 {
        self.first + self.nodes.len() as u64
    }
}

impl Store {
    /// Takes a sample that is not before the last one.
    pub(super) fn push(&mut self, t_s: f64, value: f32, broken: bool) {
        if broken {
            self.close();
        }
        let open = self.open.get_or_insert_with(|| Chunk::new(broken));
        open.push(t_s, value);
        if open.is_full() {
            self.close();
        }
    }

    fn close(&mut self) {
        let Some(mut chunk) = self.open.take() else { return };
        chunk.close();
        let mut sum = Sum::default();
        chunk.fold(0, chunk.len(), &mut sum);
        self.bytes += chunk.bytes();
        self.whole_bytes += chunk.whole_bytes();
        self.chunks.push_back(chunk);
        self.climb(sum.node());
    }

    /// Adds the node of a chunk to the lowest level, and those that it completes above.
    fn climb(&mut self, mut node: Node) {
        for level in 0.. {
            if level == self.levels.len() {
                self.levels.push(Layer::default());
            }
            let Some(layer) = self.levels.get_mut(level) else { return };
            layer.nodes.push_back(node);
            let end = layer.end();
            if !end.is_multiple_of(1 << FACTOR_BITS) {
                return;
            }
            let mut sum = Sum::default();
            let group = layer.nodes.iter().rev().take(1 << FACTOR_BITS);
            group.for_each(|node| sum.add_node(node));
            node = sum.node();
        }
    }

    /// Number behind that of the last chunk.
    pub(super) fn end(&self) -> u64 {
        self.first + (self.chunks.len() + usize::from(self.open.is_some())) as u64
    }

    pub(super) const fn first(&self) -> u64 {
        self.first
    }

    pub(super) fn chunk(&self, number: u64) -> Option<&Chunk> {
        let at = usize::try_from(number.checked_sub(self.first)?).ok()?;
        if at == self.chunks.len() { self.open.as_ref() } else { self.chunks.get(at) }
    }

    fn is_open(&self, number: u64) -> bool {
        number == self.first + self.chunks.len() as u64
    }

    /// Time of the first and of the last sample.
    pub(super) fn span(&self) -> Option<(f64, f64)> {
        let first = self.chunk(self.first)?;
        let last = self.chunk(self.end() - 1)?;
        Some((first.start_s(), last.last_s()))
    }

    /// The first sample that is not before `t_s`, at or after the place `from`.
    pub(super) fn place(&self, t_s: f64, from: u64) -> Place {
        let (from, end) = (from.max(self.first), self.end());
        let ends_before =
            |number: u64| self.chunk(number).is_some_and(|chunk| chunk.last_s() < t_s);
        // Chunks are mostly as long as the first one: a guess, then leaps that double, then halving.
        let ahead = self.chunk(from).map_or(0, |chunk| chunk.lengths_to(t_s));
        let guess = from.saturating_add(ahead);
        let guess = guess.min(end.saturating_sub(1)).max(from);
        let hit = !ends_before(guess) && (guess == from || ends_before(guess - 1));
        let mut leap = 1;
        let mut low = if hit || ends_before(guess) { guess } else { from };
        while low + leap < end && ends_before(low + leap) {
            low += leap;
            leap *= 2;
        }
        let most = usize::try_from((low + leap).min(end) - low.min(end)).unwrap_or(0);
        let chunk = low + partition(most, |k| ends_before(low + k as u64)) as u64;
        let index = self.chunk(chunk).map_or(0, |chunk| chunk.place(t_s));
        Place { chunk, index }
    }

    /// Adds the samples from one place to before another.
    pub(super) fn fold(&self, from: Place, to: Place, sum: &mut impl Fold) {
        if from.chunk >= to.chunk {
            if let Some(chunk) = self.chunk(from.chunk).filter(|_| from.chunk == to.chunk) {
                chunk.fold(from.index, to.index, sum);
            }
            return;
        }
        let mut whole = from.chunk;
        if from.index > 0 {
            if let Some(chunk) = self.chunk(from.chunk) {
                chunk.fold(from.index, chunk.len(), sum);
            }
            whole += 1;
        }
        self.fold_chunks(whole, to.chunk, sum);
        if let Some(chunk) = self.chunk(to.chunk).filter(|_| to.index > 0) {
            chunk.fold(0, to.index, sum);
        }
    }

    /// Adds whole chunks by their numbers, over the highest levels that fit.
    fn fold_chunks(&self, mut from: u64, to: u64, sum: &mut impl Fold) {
        while from < to {
            if self.is_open(from) {
                if let Some(chunk) = &self.open {
                    chunk.fold(0, chunk.len(), sum);
                }
                return;
            }
            let mut level = 0;
            let mut node = self.levels.first().and_then(|layer| layer.get(from));
            for (above, layer) in self.levels.iter().enumerate().skip(1) {
                let bits = FACTOR_BITS * u32::try_from(above).unwrap_or(u32::MAX);
                let fits = bits < 60
                    && from.trailing_zeros() >= bits
                    && from.checked_add(1 << bits).is_some_and(|end| end <= to);
                let found = layer.get(from.checked_shr(bits).unwrap_or(0)).filter(|_| fits);
                if found.is_none() {
                    break;
                }
                (level, node) = (bits, found);
            }
            if let Some(node) = node {
                sum.add_node(node);
            }
            from += 1 << level;
        }
    }

    /// Bytes of samples, times and the pyramid.
    pub(super) fn bytes(&self) -> usize {
        let nodes: usize = self.levels.iter().map(|layer| layer.nodes.capacity()).sum();
        let places = self.chunks.capacity() - self.chunks.len();
        self.bytes
            + self.open.as_ref().map_or(0, Chunk::bytes)
            + nodes * size_of::<Node>()
            + places * size_of::<Chunk>()
    }

    /// Bytes of the samples that are whole.
    pub(super) const fn whole_bytes(&self) -> usize {
        self.whole_bytes
    }

    /// Time of the oldest samples that are whole and belong to a closed chunk.
    pub(super) fn oldest_whole_s(&self) -> Option<f64> {
        self.chunks.get(self.thin).map(Chunk::start_s)
    }

    /// Time of the oldest closed chunk.
    pub(super) fn oldest_s(&self) -> Option<f64> {
        self.chunks.front().map(Chunk::start_s)
    }

    /// Thins the oldest whole chunk out.
    pub(super) fn thin_oldest(&mut self) {
        if let Some(chunk) = self.chunks.get_mut(self.thin) {
            let freed = chunk.thin();
            self.bytes -= freed;
            self.whole_bytes -= freed;
            self.thin += 1;
        }
    }

    /// Drops the oldest chunk.
    pub(super) fn drop_oldest(&mut self) {
        let Some(chunk) = self.chunks.pop_front() else { return };
        self.bytes -= chunk.bytes();
        self.whole_bytes -= chunk.whole_bytes();
        self.first += 1;
        self.thin = self.thin.saturating_sub(1);
        let mut bits = 0;
        for layer in &mut self.levels {
            let keep = self.first.checked_shr(bits).unwrap_or(0);
            while layer.first < keep && layer.nodes.pop_front().is_some() {
                layer.first += 1;
            }
            bits += FACTOR_BITS;
        }
    }

    /// Time before which the samples are thinned out; `None` where none are.
    pub(super) fn thin_before_s(&self) -> Option<f64> {
        let last = self.thin.checked_sub(1)?;
        self.chunks.get(last).map(Chunk::last_s)
    }
}
