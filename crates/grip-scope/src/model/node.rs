//! Samples in, what a stretch of them is at most, at least and on the mean out.

/// What is known of a stretch of samples; 20 bytes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Node {
    min: f32,
    max: f32,
    mean: f32,
    rms: f32,
    /// Finite samples; the highest bit: something is missing in it.
    count: u32,
}

const BROKEN: u32 = 1 << 31;

/// What takes samples and nodes: everything that is known of them, or what a picture needs.
pub(super) trait Fold {
    /// Adds samples; readings that are not finite count as missing.
    fn add_values(&mut self, values: &[f32]);
    /// Adds what a node knows.
    fn add_node(&mut self, node: &Node);
    /// Something is missing.
    fn set_broken(&mut self);
}

/// Sums over samples and nodes.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sum {
    pub(super) light: Light,
    squares: f64,
}

/// Extremes and sum of samples and nodes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Light {
    pub(super) min: f32,
    pub(super) max: f32,
    sum: f64,
    pub(super) count: u64,
    pub(super) broken: bool,
}

impl Default for Light {
    fn default() -> Self {
        let (min, max) = (f32::INFINITY, f32::NEG_INFINITY);
        Self { min, max, sum: 0.0, count: 0, broken: false }
    }
}

/// Samples that are looked at together, so that a compiler can use vectors.
const LANES: usize = 8;

impl Light {
    fn add(&mut self, value: f32) {
        if !value.is_finite() {
            self.broken = true;
            return;
        }
        self.min = self.min.min(value);
        self.max = self.max.max(value);
        self.sum += f64::from(value);
        self.count += 1;
    }

    /// The mean; 0 where there are no samples.
    #[expect(clippy::cast_precision_loss, reason = "counts of samples are below 2^53")]
    pub(super) fn mean(&self) -> f64 {
        self.sum / self.count.max(1) as f64
    }

    /// Whether nothing was added, not even something missing.
    pub(super) const fn is_empty(&self) -> bool {
        self.count == 0 && !self.broken
    }
}

impl Fold for Light {
    #[inline]
    fn add_values(&mut self, values: &[f32]) {
        let (blocks, rest) = values.as_chunks::<LANES>();
        let mut low = [f32::INFINITY; LANES];
        let mut high = [f32::NEG_INFINITY; LANES];
        let mut sum = [0.0_f64; LANES];
        let mut count = [0_u32; LANES];
        for block in blocks {
            for lane in 0..LANES {
                let value = block[lane];
                let finite = value.abs() < f32::INFINITY;
                let (bottom, top) = (finite && value < low[lane], finite && value > high[lane]);
                low[lane] = if bottom { value } else { low[lane] };
                high[lane] = if top { value } else { high[lane] };
                sum[lane] += f64::from(if finite { value } else { 0.0 });
                count[lane] += u32::from(finite);
            }
        }
        self.min = low.into_iter().fold(self.min, f32::min);
        self.max = high.into_iter().fold(self.max, f32::max);
        self.sum += sum.into_iter().sum::<f64>();
        let finite: u64 = count.into_iter().map(u64::from).sum();
        self.count += finite;
        self.broken |= finite < (blocks.len() * LANES) as u64;
        rest.iter().for_each(|value| self.add(*value));
    }

    #[inline]
    fn add_node(&mut self, node: &Node) {
        self.broken |= node.count & BROKEN != 0;
        let count = node.count & !BROKEN;
        // Without samples the extremes are infinite the other way round, and the mean is 0.
        self.min = if node.min < self.min { node.min } else { self.min };
        self.max = if node.max > self.max { node.max } else { self.max };
        self.sum += f64::from(node.mean) * f64::from(count);
        self.count += u64::from(count);
    }

    fn set_broken(&mut self) {
        self.broken = true;
    }
}

impl Sum {
    #[expect(clippy::cast_precision_loss, reason = "counts of samples are below 2^53")]
    pub(super) fn rms(&self) -> f64 {
        (self.squares / self.light.count.max(1) as f64).sqrt()
    }

    #[expect(clippy::cast_possible_truncation, reason = "kept with seven digits")]
    pub(super) fn node(&self) -> Node {
        let Light { min, max, broken, count, .. } = self.light;
        let count = u32::try_from(count).unwrap_or(u32::MAX) & !BROKEN;
        let count = count | if broken { BROKEN } else { 0 };
        let (mean, rms) = (self.light.mean() as f32, self.rms() as f32);
        Node { min, max, mean, rms, count }
    }
}

impl Fold for Sum {
    fn add_values(&mut self, values: &[f32]) {
        self.light.add_values(values);
        let finite = values.iter().filter(|value| value.is_finite());
        self.squares += finite.map(|value| f64::from(*value).powi(2)).sum::<f64>();
    }

    #[inline]
    fn add_node(&mut self, node: &Node) {
        self.light.add_node(node);
        self.squares += f64::from(node.rms).powi(2) * f64::from(node.count & !BROKEN);
    }

    fn set_broken(&mut self) {
        self.light.broken = true;
    }
}

impl Node {
    /// Least and greatest sample; `None` where there is none that is finite.
    pub(super) fn extremes(&self) -> Option<(f32, f32)> {
        (self.count & !BROKEN > 0).then_some((self.min, self.max))
    }

    /// Whether something is missing in it.
    pub(super) const fn is_broken(&self) -> bool {
        self.count & BROKEN != 0
    }

    /// The mean of its samples; NaN where there are none.
    pub(super) fn mean(&self) -> f32 {
        if self.count & !BROKEN == 0 { f32::NAN } else { self.mean }
    }
}
