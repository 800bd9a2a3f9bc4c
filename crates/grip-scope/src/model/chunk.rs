//! At most a thousand samples in order of time in; their times, values and extremes out, in as little memory as they take.

use super::allocated;
use super::node::{Fold, Node, Sum};

/// Samples of a chunk.
pub(super) const CHUNK: usize = 1024;
/// Samples of a node, the finest that is kept of old samples.
pub(super) const NODE: usize = 32;
/// Samples of a unit, the lowest level of the pyramid above the chunks.
pub(super) const UNIT: usize = 128;
/// Units of every chunk; those behind the end of a short one are empty.
pub(super) const UNITS: usize = CHUNK / UNIT;
/// Times that are off an even step by less than this (s), or this share of the step, are not kept one by one.
const EVEN_S: f64 = 2e-6;
const EVEN_SHARE: f64 = 0.01;

/// Samples in order of time, without a gap between them.
#[derive(Clone, Debug)]
pub(super) struct Chunk {
    from_s: f64,
    last_s: f64,
    step_s: f64,
    times: Times,
    /// Empty once it is thinned out.
    values: Vec<f32>,
    nodes: Vec<Node>,
    len: usize,
    /// Something is missing before it.
    pub(super) broken: bool,
}

#[derive(Clone, Debug)]
enum Times {
    /// While it grows (s).
    Growing(Vec<f64>),
    Even,
    /// Times after the first one (us).
    Uneven(Box<[u32]>),
}

impl Chunk {
    pub(super) fn new(broken: bool) -> Self {
        Self {
            from_s: 0.0,
            last_s: 0.0,
            step_s: 0.0,
            // Pieces of memory of few sizes leave few holes behind: what one chunk frees another takes as it is.
            times: Times::Growing(Vec::with_capacity(CHUNK)),
            values: Vec::with_capacity(CHUNK),
            nodes: Vec::with_capacity(CHUNK / NODE),
            len: 0,
            broken,
        }
    }

    pub(super) const fn len(&self) -> usize {
        self.len
    }

    pub(super) const fn is_full(&self) -> bool {
        self.len >= CHUNK
    }

    pub(super) const fn start_s(&self) -> f64 {
        self.from_s
    }

    /// Mean time from sample to sample (s) of a chunk that was closed.
    pub(super) const fn step_s(&self) -> f64 {
        self.step_s
    }

    pub(super) const fn last_s(&self) -> f64 {
        self.last_s
    }

    /// Takes a sample; only a chunk that was not closed.
    pub(super) fn push(&mut self, t_s: f64, value: f32) {
        let Times::Growing(times) = &mut self.times else { return };
        if self.len == 0 {
            self.from_s = t_s;
        }
        self.last_s = t_s;
        times.push(t_s);
        self.values.push(value);
        self.len += 1;
        if self.len.is_multiple_of(NODE) {
            self.end_node();
        }
    }

    fn end_node(&mut self) {
        let from = self.nodes.len() * NODE;
        let mut sum = Sum::default();
        if from == 0 && self.broken {
            sum.set_broken();
        }
        sum.add_values(self.values.get(from..).unwrap_or_default());
        self.nodes.push(sum.node());
    }

    /// What is known of the samples from `number` times [`NODE`] on; `None` while there are not so many.
    pub(super) fn node(&self, number: usize) -> Option<&Node> {
        self.nodes.get(number)
    }

    /// What is known of a unit of a chunk that was closed.
    pub(super) fn unit(&self, number: usize) -> Node {
        let mut sum = Sum::default();
        let from = number * (UNIT / NODE);
        self.nodes.iter().skip(from).take(UNIT / NODE).for_each(|node| sum.add_node(node));
        sum.node()
    }

    /// Ends its growth: times that are even, to the accuracy of a device's clock, are not kept.
    pub(super) fn close(&mut self) {
        let Times::Growing(times) = &self.times else { return };
        #[expect(clippy::cast_precision_loss, reason = "at most 1024")]
        let steps = self.len.saturating_sub(1).max(1) as f64;
        let (from_s, step_s) = (self.from_s, (self.last_s - self.from_s) / steps);
        let bound_s = EVEN_S.max(EVEN_SHARE * step_s);
        let even = times.iter().enumerate().all(|(index, t_s)| {
            (t_s - whole_micros(from_s + step_s * exact(index))).abs() <= bound_s
        });
        self.step_s = step_s;
        let after = |t_s: &f64| micros(t_s - from_s);
        self.times =
            if even { Times::Even } else { Times::Uneven(times.iter().map(after).collect()) };
        if !self.len.is_multiple_of(NODE) {
            self.end_node();
        }
        self.values.shrink_to_fit();
        self.nodes.shrink_to_fit();
    }

    /// Forgets the samples; what the nodes know of them stays. The bytes that are free now.
    pub(super) fn thin(&mut self) -> usize {
        let freed = self.whole_bytes();
        self.values = Vec::new();
        freed
    }

    /// Bytes that thinning it out would free.
    pub(super) const fn whole_bytes(&self) -> usize {
        allocated(self.values.capacity() * size_of::<f32>())
    }

    pub(super) const fn is_thin(&self) -> bool {
        self.values.is_empty()
    }

    /// Bytes of what it holds, its own not included.
    pub(super) fn bytes(&self) -> usize {
        let times = match &self.times {
            Times::Growing(times) => times.capacity() * size_of::<f64>(),
            Times::Even => 0,
            Times::Uneven(after) => size_of_val(&**after),
        };
        let nodes = self.nodes.capacity() * size_of::<Node>();
        allocated(times) + self.whole_bytes() + allocated(nodes)
    }

    /// How many chunks like this one lie between its start and `t_s`; the one behind it begins at `next_s`.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "saturates")]
    pub(super) fn lengths_to(&self, t_s: f64, next_s: Option<f64>) -> u64 {
        let length_s = next_s.unwrap_or(self.last_s + self.step_s) - self.from_s;
        ((t_s - self.from_s) / length_s).max(0.0) as u64
    }

    /// Time of a sample (s).
    pub(super) fn time(&self, index: usize) -> f64 {
        match &self.times {
            Times::Growing(times) => times.get(index).copied().unwrap_or(self.last_s),
            // Devices report whole microseconds: so even times come back as they were.
            Times::Even => whole_micros(self.from_s + self.step_s * exact(index)),
            Times::Uneven(after) => {
                after.get(index).map_or(self.last_s, |after| self.from_s + 1e-6 * f64::from(*after))
            }
        }
    }

    /// The first sample that is not before `t_s`.
    pub(super) fn place(&self, t_s: f64) -> usize {
        if t_s <= self.from_s {
            return 0;
        }
        match &self.times {
            Times::Growing(times) => times.partition_point(|time| *time < t_s),
            Times::Uneven(_) => partition(self.len, |index| self.time(index) < t_s),
            Times::Even => {
                // Rounding may be off by one; the comparison decides.
                let guess = floor_index((t_s - self.from_s) / self.step_s).min(self.len);
                let mut place = guess.saturating_sub(1);
                while place < self.len && self.time(place) < t_s {
                    place += 1;
                }
                place
            }
        }
    }

    /// Where to cut near the sample at `index`, the first that is not before `t_s`, so that few parts are looked at: at the nearest border
    /// of the chunk, of a unit or of a node, the coarsest that moves no sample by more than `most_s` over the cut; else, and while the
    /// chunk grows, at the sample.
    pub(super) fn cut(&self, index: usize, t_s: f64, most_s: f64) -> usize {
        if matches!(self.times, Times::Growing(_)) {
            return index;
        }
        for grain in [CHUNK, UNIT, NODE] {
            // What is too coarse on the average is not tried: in columns of few samples the cut is exact.
            if exact(grain / 2) * self.step_s > most_s {
                continue;
            }
            let border = ((index + grain / 2) / grain * grain).min(self.len);
            let moved_s =
                if border <= index { t_s - self.time(border) } else { self.time(border - 1) - t_s };
            if moved_s <= most_s {
                return border;
            }
        }
        index
    }

    /// Adds the samples of a range; where they are thinned out, the nodes that begin in it.
    pub(super) fn fold(&self, from: usize, to: usize, sum: &mut impl Fold) {
        let to = to.min(self.len);
        if from >= to {
            return;
        }
        if from == 0 && self.broken {
            sum.set_broken();
        }
        if self.is_thin() {
            self.fold_nodes(from.div_ceil(NODE), to.div_ceil(NODE), sum);
            return;
        }
        let first = from.div_ceil(NODE).min(self.nodes.len());
        let last = if to == self.len { to.div_ceil(NODE) } else { to / NODE }.min(self.nodes.len());
        if first >= last {
            self.fold_values(from, to, sum);
            return;
        }
        self.fold_values(from, first * NODE, sum);
        self.fold_nodes(first, last, sum);
        self.fold_values(last * NODE, to, sum);
    }

    fn fold_nodes(&self, from: usize, to: usize, sum: &mut impl Fold) {
        self.nodes.get(from..to).into_iter().flatten().for_each(|node| sum.add_node(node));
    }

    fn fold_values(&self, from: usize, to: usize, sum: &mut impl Fold) {
        sum.add_values(self.values.get(from..to.min(self.len)).unwrap_or_default());
    }

    /// The value of a sample; the mean of its node where the chunk is thinned out.
    pub(super) fn value(&self, index: usize) -> f32 {
        if self.is_thin() {
            return self.nodes.get(index / NODE).map_or(f32::NAN, Node::mean);
        }
        self.values.get(index).copied().unwrap_or(f32::NAN)
    }
}

#[expect(clippy::cast_precision_loss, reason = "at most 1024")]
fn exact(index: usize) -> f64 {
    index as f64
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "the cast saturates")]
fn floor_index(place: f64) -> usize {
    if place.is_finite() { place as usize } else { 0 }
}

/// The nearest whole microsecond (s); times on the axis are not negative.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_precision_loss,
    reason = "exact for 285 years"
)]
fn whole_micros(t_s: f64) -> f64 {
    (1e6 * t_s + 0.5) as i64 as f64 / 1e6
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "the cast saturates")]
fn micros(after_s: f64) -> u32 {
    (1e6 * after_s).round() as u32
}

/// The first index below `len` where `before` does not hold any more.
pub(super) fn partition(len: usize, mut before: impl FnMut(usize) -> bool) -> usize {
    let (mut low, mut high) = (0, len);
    while low < high {
        let middle = low + (high - low) / 2;
        if before(middle) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    low
}
