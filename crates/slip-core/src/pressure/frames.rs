//! Statistics of taxel frames: their common shape and a frame's departure from it, range and noise of each taxel, whether the force stands.

use crate::units::Micros;

// Common shape of the frames, and how far a frame departs from it.

/// Most that one taxel counts: deviations squared.
pub(super) const CLIP: f32 = 36.0;
/// Frames whose plain mean begins the shape.
const FIRST: f32 = 2.0;

/// A unit vector without mean that follows the frames.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shape<const N: usize> {
    u: [f32; N],
    uu: f32,
    frames: f32,
}

/// What a frame shows beside the shape.
#[derive(Clone, Copy, Debug)]
pub(super) struct Departure<const N: usize> {
    residual: [f32; N],
    len: usize,
}

impl<const N: usize> Departure<N> {
    /// A residual for each taxel (unit of the taxels).
    pub(super) fn residual(&self) -> &[f32] {
        self.residual.get(..self.len).unwrap_or(&self.residual)
    }

    fn squares(&self) -> f32 {
        self.residual().iter().map(|r| r * r).sum()
    }

    /// Mean square over the taxels that are free.
    pub(super) fn mean_square(&self) -> f32 {
        self.squares() / (count(self.len) - 2.0).max(1.0)
    }

    /// Mean square over all taxels.
    pub(super) fn over_all(&self) -> f32 {
        self.squares() / count(self.len)
    }

    /// Mean of the squares over the variance, each limited to [`CLIP`].
    pub(super) fn energy(&self, per_variance: f32) -> f32 {
        let sum: f32 = self.residual().iter().map(|r| (r * r * per_variance).min(CLIP)).sum();
        sum / count(self.len)
    }
}

impl<const N: usize> Shape<N> {
    pub(super) const fn new() -> Self {
        Self { u: [0.0; N], uu: 0.0, frames: 0.0 }
    }

    /// Compares the frame and follows it by the time `dt_over_tau`; `None` for the first frame and for one without a pattern.
    pub(super) fn step(
        &mut self,
        frame: &[f32; N],
        n: usize,
        dt_over_tau: f32,
    ) -> Option<Departure<N>> {
        let (p, norm) = centred(frame, n);
        if norm <= 0.0 {
            return None;
        }
        let before = (self.frames > 0.0).then(|| self.residual(&p, n));
        self.frames = (self.frames + 1.0).min(FIRST + 1.0);
        let follow = 1.0 - libm::expf(-dt_over_tau);
        let weight = if self.frames <= FIRST { 1.0 / self.frames } else { follow };
        let scale = 1.0 / norm;
        for (u, p) in self.u.iter_mut().zip(&p).take(n) {
            *u += weight * (p * scale - *u);
        }
        self.uu = self.u.iter().take(n).map(|u| u * u).sum();
        before.map(|residual| Departure { residual, len: n })
    }

    /// The frame of `n` taxels without its share of the shape.
    fn residual(&self, p: &[f32; N], n: usize) -> [f32; N] {
        let dot: f32 = p.iter().zip(&self.u).take(n).map(|(p, u)| p * u).sum();
        let share = if self.uu > 0.0 { dot / self.uu } else { 0.0 };
        let mut out = [0.0; N];
        for (r, (p, u)) in out.iter_mut().zip(p.iter().zip(&self.u)).take(n) {
            *r = p - share * u;
        }
        out
    }
}

/// The first `n` taxels less their mean, the rest zero; and the length of that vector.
fn centred<const N: usize>(frame: &[f32; N], n: usize) -> ([f32; N], f32) {
    let mean = frame.iter().take(n).sum::<f32>() / count(n);
    let mut p = [0.0; N];
    for (p, value) in p.iter_mut().zip(frame).take(n) {
        *p = value - mean;
    }
    let norm = libm::sqrtf(p.iter().take(n).map(|p| p * p).sum());
    (p, norm)
}

pub(super) fn count(n: usize) -> f32 {
    n.max(1) as f32
}

/// Mean of residuals at rest without the largest of them, so that one knock does not raise the noise.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Spread {
    sum: f32,
    largest: f32,
    count: u16,
}

impl Spread {
    pub(super) fn push(&mut self, mean_square: f32) {
        self.sum += mean_square;
        self.largest = self.largest.max(mean_square);
        self.count = self.count.saturating_add(1);
    }

    /// The mean once there are `frames` residuals.
    pub(super) fn mean(&self, frames: u16) -> Option<f32> {
        (self.count >= frames.max(2))
            .then(|| (self.sum - self.largest).max(0.0) / f32::from(self.count - 1))
    }
}

// Range that the residual of each taxel went through in the last seconds.

/// Time constant of the means (ms): slower than tremor, faster than a slip.
const SMOOTH_MS: f32 = 30.0;
/// Time constant with which a range is forgotten (ms).
const RANGE_MS: f32 = 4000.0;
/// A range of a shorter stretch than half of that is none: it has only begun to grow.
const SHORTEST: Micros = Micros(2_000_000);
/// Most that one taxel counts, in ranges at rest.
pub(super) const RANGE_CLIP: f32 = 6.0;

/// The ranges of at most `N` taxels.
///
/// ```text
/// m <- m + (1 - exp(-dt / 30 ms)) (r - m)       high <- max(high', m), low <- min(low', m)
/// range = mean over the taxels of min(high - low, 6 known)                slip when range > known
/// ```
///
/// high' and low' have come nearer to their middle by exp(-dt / 4 s). The mean m leaves what is below some 5 Hz: noise,
/// and the tremor of a hand (8 to 12 Hz), swing about a place and make no way. A slip carries the pattern on: residuals
/// go up at one taxel and down at the next as ridges and the edge of the contact pass, and the range grows with the way
/// where the residuals themselves, which the shape follows, do not. An object held still shows noise and creep, which
/// slows down: its range stands after some seconds, at a level that only a record of rest can give.
#[derive(Clone, Copy, Debug)]
pub(super) struct Range<const N: usize> {
    mean: [f32; N],
    high: [f32; N],
    low: [f32; N],
    begun: bool,
}

impl<const N: usize> Range<N> {
    pub(super) const fn new() -> Self {
        Self { mean: [0.0; N], high: [0.0; N], low: [0.0; N], begun: false }
    }

    /// Takes the residuals of the next frame, `dt_ms` (ms) after the one before.
    pub(super) fn step(&mut self, residual: &[f32], dt_ms: f32) {
        if !self.begun {
            self.begun = true;
            for ends in [&mut self.mean, &mut self.high, &mut self.low] {
                ends.iter_mut().zip(residual).for_each(|(end, r)| *end = *r);
            }
            return;
        }
        let follow = 1.0 - libm::expf(-dt_ms / SMOOTH_MS);
        let shrink = 0.5 * (1.0 - libm::expf(-dt_ms / RANGE_MS));
        let ends = self.high.iter_mut().zip(&mut self.low);
        for ((r, mean), (high, low)) in residual.iter().zip(&mut self.mean).zip(ends) {
            *mean += follow * (r - *mean);
            let nearer = shrink * (*high - *low);
            *high = (*high - nearer).max(*mean);
            *low = (*low + nearer).min(*mean);
        }
    }

    /// Mean range of the first `n` taxels, each limited to `most` (unit of the taxels).
    pub(super) fn mean(&self, n: usize, most: f32) -> f32 {
        let ends = self.high.iter().zip(&self.low).take(n);
        let ranges = ends.map(|(high, low)| (high - low).min(most));
        ranges.sum::<f32>() / count(n)
    }
}

/// The largest range of stretches of rest.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Widest {
    /// Largest range of this stretch, and of all stretches that are long enough for one.
    widest: f32,
    largest: f32,
    since: Option<Micros>,
    /// Length of the stretches before that were long enough, and of this one.
    before: Micros,
    now: Micros,
}

impl Widest {
    /// Begins another stretch of rest.
    pub(super) fn start(&mut self) {
        self.before = self.rest();
        (self.widest, self.since, self.now) = (0.0, None, Micros(0));
    }

    /// Takes the range at `t`.
    pub(super) fn push(&mut self, t: Micros, range: f32) {
        self.now = t.since(*self.since.get_or_insert(t));
        self.widest = self.widest.max(range);
        if self.now >= SHORTEST {
            self.largest = self.largest.max(self.widest);
        }
    }

    /// Length of the stretches that were long enough.
    pub(super) fn rest(&self) -> Micros {
        if self.now >= SHORTEST { self.before.plus(self.now) } else { self.before }
    }

    /// The largest range; `None` where no stretch was long enough, or nothing changed.
    pub(super) fn largest(&self) -> Option<f32> {
        Some(self.largest).filter(|range| *range > 0.0)
    }
}

// Noise of the taxels, from stretches of rest.
//
// For recordings whose rest is known beforehand; a running gripper learns the noise in the first grasp.

/// Pools the noise of several stretches of at most `N` taxels.
#[derive(Clone, Copy, Debug)]
pub struct PatternRest<const N: usize> {
    follow_ms: f32,
    shape: Shape<N>,
    range: Range<N>,
    widest: Widest,
    last_t: Option<Micros>,
    sum: f64,
    /// Largest mean square of the residuals over all taxels.
    largest: f32,
    frames: u64,
}

impl<const N: usize> PatternRest<N> {
    /// A meter for a method that follows creep with `follow_ms`.
    #[must_use]
    pub fn new(follow_ms: f32) -> Self {
        Self {
            follow_ms,
            shape: Shape::new(),
            range: Range::new(),
            widest: Widest::default(),
            last_t: None,
            sum: 0.0,
            largest: 0.0,
            frames: 0,
        }
    }

    /// Begins another stretch of rest.
    pub fn start(&mut self) {
        self.shape = Shape::new();
        self.range = Range::new();
        self.widest.start();
        self.last_t = None;
    }

    /// Takes the next frame; one with anything but numbers is left out.
    pub fn push(&mut self, t: Micros, frame: &[f32]) {
        if frame.is_empty() || frame.iter().any(|value| !value.is_finite()) {
            return;
        }
        let mut values = [0.0; N];
        for (value, taxel) in values.iter_mut().zip(frame) {
            *value = *taxel;
        }
        #[expect(clippy::cast_possible_truncation, reason = "a step of time")]
        let dt_ms = self.last_t.map_or(0.0, |last| t.since(last).as_seconds() * 1e3) as f32;
        self.last_t = Some(t);
        let seen = self.shape.step(&values, frame.len().min(N), dt_ms / self.follow_ms);
        if let Some(departure) = seen {
            self.sum += f64::from(departure.mean_square());
            self.largest = self.largest.max(departure.over_all());
            self.range.step(departure.residual(), dt_ms);
            let range = self.range.mean(frame.len().min(N), f32::INFINITY);
            self.widest.push(t, range);
            self.frames += 1;
        }
    }

    /// Frames that were used.
    #[must_use]
    pub fn frames(&self) -> u64 {
        self.frames
    }

    /// Noise of a taxel (rms) with which nothing of that rest is a slip at `threshold`: a hand that creeps shows more than noise.
    /// `None` before the second frame.
    #[must_use]
    #[expect(clippy::cast_possible_truncation, reason = "a mean in f32")]
    pub fn rms(&self, threshold: f32) -> Option<f32> {
        let variance = (self.sum / self.frames as f64) as f32;
        (self.frames > 0).then(|| libm::sqrtf(variance.max(self.largest / threshold)))
    }

    /// Largest mean range of a taxel (unit of the taxels), with which nothing of that rest is a slip. `None` where no stretch
    /// lasted for half the time constant of the range, or nothing changed.
    #[must_use]
    pub fn range(&self) -> Option<f32> {
        self.widest.largest()
    }
}

// Whether the grip force stands: fingers that close or open change the pattern of an array without a slip.

/// A force that stays within this share of what it stood at stands.
const SHARE: f32 = 0.1;

/// Whether the grip force stands.
#[derive(Clone, Copy, Debug, Default)]
pub struct Standing {
    /// The force (N) that the others are held against, and since when they have been.
    from: Option<(f32, Micros)>,
    last: Micros,
}

impl Standing {
    /// From contact, and from each change of the grip force by more than a tenth, on: how long nothing is concluded from the pattern.
    pub const WAIT: Micros = Micros(500_000);

    /// Takes the measured normal force (N); whether it has stood for [`Standing::WAIT`]. Without a force sensor it does.
    pub fn step(&mut self, t: Micros, normal_force_n: Option<f32>) -> bool {
        let Some(force_n) = normal_force_n else { return true };
        let (from_n, since) = *self.from.get_or_insert((force_n, t));
        let last = core::mem::replace(&mut self.last, t);
        if (force_n - from_n).abs() > SHARE * from_n.abs() {
            self.from = Some((force_n, t));
            return false;
        }
        let stands = t.since(since) >= Self::WAIT;
        if stands {
            // Not the force that closing fingers passed on the way.
            let follows = t.since(last).as_seconds() / Self::WAIT.as_seconds();
            #[expect(clippy::cast_possible_truncation, reason = "a share of at most 1")]
            let follows = follows.min(1.0) as f32;
            self.from = Some((from_n + follows * (force_n - from_n), since));
        }
        stands
    }

    /// Another object: nothing is known.
    pub fn prime(&mut self) {
        self.from = None;
    }
}

#[cfg(test)]
mod standing_tests {
    use super::Standing;
    use crate::units::Micros;

    #[test]
    fn a_force_stands_half_a_second_after_its_last_change() {
        let mut standing = Standing::default();
        let mut stands = |ms: u64, n: f32| standing.step(Micros(1000 * ms), Some(n));
        assert!(!stands(0, 1.0) && !stands(400, 1.08) && stands(500, 0.95));
        assert!(!stands(510, 1.5) && !stands(1000, 1.4) && stands(1010, 1.4));
        assert!(Standing::default().step(Micros(0), None), "nobody measures it");
    }

    #[test]
    fn a_force_is_held_against_what_it_stood_at_and_not_what_it_passed() {
        let mut standing = Standing::default();
        let mut stands = |ms: u64, n: f32| standing.step(Micros(1000 * ms), Some(n));
        // Closing fingers: 1.0 on the way to 1.08. A tenth below that is a change, though it is none of 1.0.
        assert!(!stands(0, 1.0) && (1..3000).all(|ms| stands(ms, 1.08) == (ms >= 500)));
        assert!(!stands(3000, 0.96));
    }
}
