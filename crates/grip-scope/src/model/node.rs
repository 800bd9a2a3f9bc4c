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

/// Sums over samples and nodes. Readings that are not finite count as missing.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sum {
    pub(super) min: f32,
    pub(super) max: f32,
    sum: f64,
    squares: f64,
    pub(super) count: u64,
    pub(super) broken: bool,
}

impl Default for Sum {
    fn default() -> Self {
        let (min, max) = (f32::INFINITY, f32::NEG_INFINITY);
        Self { min, max, sum: 0.0, squares: 0.0, count: 0, broken: false }
    }
}

impl Sum {
    #[inline]
    pub(super) fn add(&mut self, value: f32) {
        if !value.is_finite() {
            self.broken = true;
            return;
        }
        self.min = self.min.min(value);
        self.max = self.max.max(value);
        let value = f64::from(value);
        self.sum += value;
        self.squares += value * value;
        self.count += 1;
    }

    #[inline]
    pub(super) fn add_node(&mut self, node: &Node) {
        self.broken |= node.count & BROKEN != 0;
        let count = node.count & !BROKEN;
        if count == 0 {
            return;
        }
        self.min = self.min.min(node.min);
        self.max = self.max.max(node.max);
        let (mean, rms) = (f64::from(node.mean), f64::from(node.rms));
        self.sum += mean * f64::from(count);
        self.squares += rms * rms * f64::from(count);
        self.count += u64::from(count);
    }

    #[expect(clippy::cast_precision_loss, reason = "counts of samples are below 2^53")]
    pub(super) fn mean(&self) -> f64 {
        self.sum / self.count.max(1) as f64
    }

    #[expect(clippy::cast_precision_loss, reason = "counts of samples are below 2^53")]
    pub(super) fn rms(&self) -> f64 {
        (self.squares / self.count.max(1) as f64).sqrt()
    }

    #[expect(clippy::cast_possible_truncation, reason = "kept with seven digits")]
    pub(super) fn node(&self) -> Node {
        let count = u32::try_from(self.count).unwrap_or(u32::MAX) & !BROKEN;
        let count = count | if self.broken { BROKEN } else { 0 };
        let (mean, rms) = (self.mean() as f32, self.rms() as f32);
        Node { min: self.min, max: self.max, mean, rms, count }
    }

    /// Whether nothing was added, not even something missing.
    pub(super) fn is_empty(&self) -> bool {
        self.count == 0 && !self.broken
    }
}

impl Node {
    /// The mean of its samples; NaN where there are none.
    pub(super) fn mean(&self) -> f32 {
        if self.count & !BROKEN == 0 { f32::NAN } else { self.mean }
    }
}
