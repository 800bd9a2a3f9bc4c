//! Chunks of samples in; sums over any stretch of them out, at a cost that hardly grows with its length.
//!
//! Above the chunks stands a pyramid: units of 128 samples, four of them, four times four, and so on. The oldest chunks are first thinned out to
//! their nodes and then dropped.

use super::blocks::Blocks;
use super::chunk::{CHUNK, Chunk, UNIT, UNITS, partition};
use super::node::{Fold, Node, Sum};

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
    chunks: Blocks<Chunk>,
    first: u64,
    /// The pyramid; units have the number of their chunk times [`UNITS`] and on.
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
    nodes: Blocks<Node>,
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
        (0..UNITS).for_each(|number| self.climb(chunk.unit(number)));
        self.bytes += chunk.bytes();
        self.whole_bytes += chunk.whole_bytes();
        self.chunks.push_back(chunk);
    }

    /// Adds the node of a unit to the lowest level, and those that it completes above.
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
            let group = layer.nodes.newest().take(1 << FACTOR_BITS);
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

    /// Time of the first and of the last sample.
    pub(super) fn span(&self) -> Option<(f64, f64)> {
        let first = self.chunk(self.first)?;
        let last = self.chunk(self.end() - 1)?;
        Some((first.start_s(), last.last_s()))
    }

    /// The first sample that is not before `t_s`, at or after the place `from`.
    pub(super) fn place(&self, t_s: f64, from: u64) -> Place {
        let from = from.max(self.first);
        let ends_before =
            |number: u64| self.chunk(number).is_some_and(|chunk| chunk.last_s() < t_s);
        // The next column of a picture mostly begins in the same chunk or in the next.
        let near = (from..from + 2).find(|number| !ends_before(*number));
        let chunk = near.unwrap_or_else(|| self.chunk_far(t_s, from));
        let index = self.chunk(chunk).map_or(0, |chunk| chunk.place(t_s));
        Place { chunk, index }
    }

    /// The first chunk that does not end before `t_s`, from `from` on.
    fn chunk_far(&self, t_s: f64, from: u64) -> u64 {
        let end = self.end();
        let ends_before =
            |number: u64| self.chunk(number).is_some_and(|chunk| chunk.last_s() < t_s);
        // Chunks are mostly as long as the first one and as far from each other: a guess, then leaps that double, then halving.
        let next_s = self.chunk(from + 1).map(Chunk::start_s);
        let ahead = self.chunk(from).map_or(0, |chunk| chunk.lengths_to(t_s, next_s));
        let guess = from.saturating_add(ahead).min(end.saturating_sub(1)).max(from);
        let (mut low, mut high, mut leap) = (from, end, 1);
        if ends_before(guess) {
            low = guess + 1;
            while low + leap < end && ends_before(low + leap) {
                low += leap;
                leap *= 2;
            }
            high = (low + leap).min(end).max(low);
        } else {
            high = high.min(guess);
            while high > from {
                let probe = high.saturating_sub(leap).max(from);
                if ends_before(probe) {
                    low = probe + 1;
                    break;
                }
                high = probe;
                leap *= 2;
            }
        }
        let most = usize::try_from(high - low.min(high)).unwrap_or(0);
        low + partition(most, |k| ends_before(low + k as u64)) as u64
    }

    /// A place near `place`, the first sample that is not before `t_s`, where a part may end at little cost: see [`Chunk::cut`].
    pub(super) fn cut(&self, place: Place, t_s: f64, most_s: f64) -> Place {
        let Some(chunk) = self.chunk(place.chunk) else { return place };
        let index = chunk.cut(place.index, t_s, most_s);
        if index < chunk.len() {
            return Place { index, ..place };
        }
        Place { chunk: place.chunk + 1, index: 0 }
    }

    /// Adds the samples from one place to before another.
    pub(super) fn fold(&self, from: Place, to: Place, sum: &mut impl Fold) {
        if from >= to {
            return;
        }
        let unit = |place: Place, within: usize| place.chunk * UNITS as u64 + within as u64;
        let first = unit(from, from.index.div_ceil(UNIT));
        let last = unit(to, to.index / UNIT);
        if first > last {
            // All within one unit.
            if let Some(chunk) = self.chunk(from.chunk) {
                chunk.fold(from.index, to.index, sum);
            }
            return;
        }
        if let Some(chunk) = self.chunk(from.chunk).filter(|_| !from.index.is_multiple_of(UNIT)) {
            chunk.fold(from.index, from.index.next_multiple_of(UNIT), sum);
        }
        self.fold_units(first, last, sum);
        if let Some(chunk) = self.chunk(to.chunk).filter(|_| !to.index.is_multiple_of(UNIT)) {
            chunk.fold(to.index / UNIT * UNIT, to.index, sum);
        }
    }

    /// Adds whole units by their numbers, over the highest levels that fit.
    fn fold_units(&self, mut from: u64, to: u64, sum: &mut impl Fold) {
        let closed = to.min(self.levels.first().map_or(0, Layer::end));
        while from < closed {
            // A node of this level begins here and ends in time.
            let level =
                (from.trailing_zeros() / FACTOR_BITS).min((closed - from).ilog2() / FACTOR_BITS);
            let node = |level: u32| {
                let layer = self.levels.get(usize::try_from(level).ok()?)?;
                layer.get(from >> (FACTOR_BITS * level)).map(|node| (level, node))
            };
            let found = (0..=level).rev().find_map(node);
            found.into_iter().for_each(|(_, node)| sum.add_node(node));
            from += 1 << (FACTOR_BITS * found.map_or(0, |(level, _)| level));
        }
        if let Some(open) = self.open.as_ref().filter(|_| from < to) {
            let start = self.levels.first().map_or(0, Layer::end);
            let within =
                |unit: u64| usize::try_from(unit - start).map_or(CHUNK, |n| n.min(UNITS) * UNIT);
            open.fold(within(from), within(to), sum);
        }
    }

    /// Bytes of samples, times and the pyramid.
    pub(super) fn bytes(&self) -> usize {
        let nodes: usize = self.levels.iter().map(|layer| layer.nodes.bytes()).sum();
        let open = self.open.as_ref().map_or(0, |open| size_of::<Chunk>() + open.bytes());
        self.bytes + open + nodes + self.chunks.bytes()
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
            let keep = (self.first * UNITS as u64).checked_shr(bits).unwrap_or(0);
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
