//! Extremes, mean and root mean square of a stretch of samples.

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
/// Samples that are looked at together, so that a compiler can use vectors.
const LANES: usize = 8;

impl Node {
    /// Least and greatest sample; `None` where there is none that is finite.
    pub(super) fn extremes(&self) -> Option<(f32, f32)> {
        (self.count & !BROKEN > 0).then_some((self.min, self.max))
    }

    /// Whether something is missing in it.
    pub(super) const fn is_broken(&self) -> bool {
        self.count & BROKEN != 0
    }
}

/// Sums over samples and nodes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sum {
    pub(super) min: f32,
    pub(super) max: f32,
    sum: f64,
    squares: f64,
    /// Finite samples.
    pub(super) count: u64,
    /// Whether something is missing.
    pub(super) broken: bool,
}

impl Default for Sum {
    fn default() -> Self {
        let (min, max) = (f32::INFINITY, f32::NEG_INFINITY);
        Self { min, max, sum: 0.0, squares: 0.0, count: 0, broken: false }
    }
}

impl Sum {
    /// Adds samples; readings that are not finite count as missing.
    #[inline]
    pub(super) fn add_values(&mut self, values: &[f32]) {
        let (blocks, rest) = values.as_chunks::<LANES>();
        let mut low = [f32::INFINITY; LANES];
        let mut high = [f32::NEG_INFINITY; LANES];
        let mut sum = [0.0_f64; LANES];
        let mut squares = [0.0_f64; LANES];
        let mut count = [0_u32; LANES];
        for block in blocks {
            for lane in 0..LANES {
                let value = block[lane];
                let finite = value.abs() < f32::INFINITY;
                low[lane] = if finite && value < low[lane] { value } else { low[lane] };
                high[lane] = if finite && value > high[lane] { value } else { high[lane] };
                let wide = f64::from(if finite { value } else { 0.0 });
                sum[lane] += wide;
                squares[lane] += wide * wide;
                count[lane] += u32::from(finite);
            }
        }
        for value in rest.iter().filter(|value| value.is_finite()) {
            low[0] = low[0].min(*value);
            high[0] = high[0].max(*value);
            sum[0] += f64::from(*value);
            squares[0] += f64::from(*value).powi(2);
            count[0] += 1;
        }
        self.min = low.into_iter().fold(self.min, f32::min);
        self.max = high.into_iter().fold(self.max, f32::max);
        self.sum += sum.into_iter().sum::<f64>();
        self.squares += squares.into_iter().sum::<f64>();
        let finite: u64 = count.into_iter().map(u64::from).sum();
        self.count += finite;
        self.broken |= finite < values.len() as u64;
    }

    /// Adds what a node knows.
    #[inline]
    pub(super) fn add_node(&mut self, node: &Node) {
        self.broken |= node.is_broken();
        let count = node.count & !BROKEN;
        // Without samples the extremes are infinite the other way round, and the mean is 0.
        self.min = if node.min < self.min { node.min } else { self.min };
        self.max = if node.max > self.max { node.max } else { self.max };
        self.sum += f64::from(node.mean) * f64::from(count);
        self.squares += f64::from(node.rms).powi(2) * f64::from(count);
        self.count += u64::from(count);
    }

    /// The mean; 0 where there are no samples.
    pub(super) fn mean(&self) -> f64 {
        self.sum / self.divisor()
    }

    /// Root of the mean square; 0 where there are no samples.
    pub(super) fn rms(&self) -> f64 {
        (self.squares / self.divisor()).sqrt()
    }

    fn divisor(&self) -> f64 {
        self.count.max(1) as f64
    }

    /// Whether nothing was added, not even something missing.
    pub(super) const fn is_empty(&self) -> bool {
        self.count == 0 && !self.broken
    }

    #[expect(clippy::cast_possible_truncation, reason = "kept with seven digits")]
    pub(super) fn node(&self) -> Node {
        let count = u32::try_from(self.count).unwrap_or(u32::MAX) & !BROKEN;
        let count = count | if self.broken { BROKEN } else { 0 };
        let (mean, rms) = (self.mean() as f32, self.rms() as f32);
        Node { min: self.min, max: self.max, mean, rms, count }
    }
}
