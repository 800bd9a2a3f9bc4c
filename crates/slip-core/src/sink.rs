//! Stylus and grip force in; the reading of the stylus without what the pads give way under the force, out.
//!
//! A stylus that stands out of a pad is pushed in when the pad gives way under the grip force. In a slip the force rises by many newtons, so that this
//! movement looks like a surface. How far it is pushed in by a newton is learned while the fingers close and nothing slips: the slope of the reading
//! over the force, where that is known well. In a slip it is taken away from the reading; afterwards what was taken away stays as it is,
//! so that the reading does not jump.
//!
//! Pads get stiffer with the force. So the slope is followed in the slip by a Kalman filter of one state, the share of the slope at the trial force; the
//! surface is its noise.

use crate::sample::Sample;

/// Readings that a slope takes.
const READINGS: u32 = 50;
/// It also takes a force that spreads by this (N, standard deviation), and is so many times its own deviation.
const SPREAD_N: f32 = 0.1;
const SURE: f32 = 20.0;
/// What the noise of the force sensor moves the levelled reading by is this share of the noise of the stylus at most.
const NOISE: f32 = 0.6;
/// Where it is so many times that, the force says too little: nothing is taken away.
const TOO_NOISY: f32 = 12.0;
/// A reading further from the force that is expected than this (N) and so many of its deviations counts as one at that distance.
const GLITCH_N: f32 = 0.5;
const GLITCH: f32 = 5.0;
/// Time (s) after which the share of the slope is looked at again; its variance before a slip, and what is added each time.
const BLOCK_S: f32 = 1e-3;
const UNSURE: f32 = 0.1;
const CHANGES: f32 = 4e-4;
/// Of the squared movement of the surface in a block so much is new.
const NEW: f32 = 0.1;
/// The largest share: pads get stiffer.
const MOST: f32 = 1.5;

/// How far the force pushes the stylus in.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Sink {
    /// Of the readings since touch: number, means of force (N) and reading, sums of squares and of the product of their deviations.
    count: u32,
    force_n: f32,
    reading: f32,
    squares: [f32; 2],
    product: f32,
    /// Unit of the reading for one newton at the trial force, 0 where nothing is known, and the share of it now with its variance.
    per_n: f32,
    share: f32,
    variance: f32,
    /// What is taken away, and the force (N) of the last sample of the slip.
    taken: f32,
    last_n: f32,
    /// Of the block: length so far (s), force (N) and reading at its begin; squared movement of the surface in a block.
    block_s: f32,
    block_n: f32,
    block: f32,
    surface: f32,
    /// Sum of the squared differences of one force reading and the next (N^2), and the last reading (N).
    differences: f32,
    read_n: f32,
    /// Deviation of a force reading (N), and time constant (s) of what corrects the force of the command.
    sigma_n: f32,
    corrects_s: f32,
    /// Force by the command alone (N), and the last change of the force (N).
    commanded_n: f32,
    step_n: f32,
    raw: f32,
}

impl Sink {
    /// Takes a sample while no object is held: with touch the fingers close on it, without any nothing is known of the next grasp.
    pub(crate) fn close(&mut self, sample: &Sample, touching: bool) {
        match sample.normal_force_n.filter(|_| touching) {
            Some(force_n) => self.learn(sample.stylus, force_n),
            None => self.open(),
        }
    }

    fn open(&mut self) {
        (self.count, self.force_n, self.reading) = (0, 0.0, 0.0);
        (self.squares, self.product, self.differences) = ([0.0; 2], 0.0, 0.0);
    }

    fn learn(&mut self, reading: f32, force_n: f32) {
        if !(reading.is_finite() && force_n.is_finite()) {
            return;
        }
        if self.count > 0 {
            self.differences += (force_n - self.read_n) * (force_n - self.read_n);
        }
        self.read_n = force_n;
        self.count = self.count.saturating_add(1);
        #[expect(clippy::cast_precision_loss, reason = "readings of one closing")]
        let share = 1.0 / self.count as f32;
        let (by_n, by) = (force_n - self.force_n, reading - self.reading);
        self.force_n += share * by_n;
        self.reading += share * by;
        let left = reading - self.reading;
        self.squares[0] += by_n * (force_n - self.force_n);
        self.squares[1] += by * left;
        self.product += by_n * left;
    }

    /// The object is held: the slope is what was learned of this grasp.
    pub(crate) fn settle(&mut self) {
        if self.count < READINGS {
            return;
        }
        let [forces, readings] = self.squares;
        #[expect(clippy::cast_precision_loss, reason = "readings of one closing")]
        let count = self.count as f32;
        self.sigma_n = libm::sqrtf(0.5 * self.differences / count);
        let per_n = self.product / forces;
        // Variance of the reading that the force does not explain, and with it that of the slope.
        let rest = (readings - per_n * self.product).max(0.0);
        let sure = per_n * per_n * forces * count >= SURE * SURE * rest;
        let spread = forces >= SPREAD_N * SPREAD_N * count;
        self.per_n = if spread && sure && per_n.is_finite() { per_n } else { 0.0 };
        self.open();
    }

    /// A slip begins: force by its sensor, where that shows any, and by the command (N), as the sensor shows them. `noise` is that of the stylus (its unit),
    /// `dt_s` the time between samples (s).
    pub(crate) fn begin(
        &mut self,
        (read_n, commanded_n): (Option<f32>, f32),
        noise: f32,
        dt_s: f32,
    ) {
        let noises = self.per_n * self.sigma_n / (NOISE * noise);
        if noises > TOO_NOISY {
            self.per_n = 0.0;
        }
        let corrects_s = 0.5 * dt_s * noises * noises;
        self.corrects_s = if corrects_s.is_finite() { corrects_s } else { 0.0 };
        // A single reading of a noisy sensor is no beginning.
        let sound = self.corrects_s <= dt_s;
        let force_n = read_n.filter(|n| sound && n.is_finite()).unwrap_or(commanded_n);
        (self.last_n, self.commanded_n, self.step_n) = (force_n, commanded_n, 0.0);
        (self.block_n, self.block, self.block_s) = (force_n, self.raw, 0.0);
        (self.share, self.variance, self.surface) = (1.0, UNSURE, 0.0);
    }

    /// The force (N) in a slip, by its sensor and by the command alone, and the time since the sample before (s). A noisy sensor only corrects the
    /// command, so that its noise does not look like a surface.
    #[inline]
    pub(crate) fn follow(&mut self, force_n: f32, commanded_n: f32, dt_s: f32) {
        if self.per_n == 0.0 {
            return;
        }
        let expected_n = self.last_n + commanded_n - self.commanded_n;
        self.commanded_n = commanded_n;
        let share = if self.corrects_s > dt_s { dt_s / self.corrects_s } else { 1.0 };
        let off_n = force_n - expected_n;
        let most_n = GLITCH_N + GLITCH * self.sigma_n;
        let off_n = if off_n.is_finite() { off_n.min(most_n).max(-most_n) } else { 0.0 };
        let force_n = expected_n + share * off_n;
        self.step_n = force_n - self.last_n;
        self.taken += self.share * self.per_n * self.step_n;
        self.last_n = force_n;
        self.block_s += dt_s;
        if self.block_s >= BLOCK_S {
            self.correct(force_n);
        }
    }

    /// Corrects the share of the slope by the movement of the last block.
    #[cold]
    fn correct(&mut self, force_n: f32) {
        let pushed = self.per_n * (force_n - self.block_n);
        let missed = self.raw - self.block - self.share * pushed;
        (self.block_s, self.block_n, self.block) = (0.0, force_n, self.raw);
        let new = if self.surface == 0.0 { 1.0 } else { NEW };
        self.surface += new * (missed * missed - self.surface);
        let gain = self.variance * pushed / (self.surface + self.variance * pushed * pushed);
        if gain.is_finite() {
            self.share = (self.share + gain * missed).clamp(0.0, MOST);
            self.variance = (1.0 - gain * pushed) * self.variance + CHANGES;
        }
    }

    /// The slip has ended: what is taken away stays.
    pub(crate) fn end(&mut self) {
        self.step_n = 0.0;
    }

    /// The sample without what the force has pushed the stylus in; `None` where that is nothing.
    #[inline]
    pub(crate) fn level(&mut self, sample: &Sample) -> Option<Sample> {
        self.raw = sample.stylus;
        // The force of the sample itself is known only after it was judged: it is as much further on as the last one was.
        let taken = self.taken + self.share * self.per_n * self.step_n;
        if taken == 0.0 {
            return None;
        }
        Some(Sample {
            stylus: sample.stylus - taken,
            second_stylus: sample.second_stylus.map(|reading| reading - taken),
            ..*sample
        })
    }

    /// The last reading as it came.
    pub(crate) fn raw(&self) -> f32 {
        self.raw
    }
}

#[cfg(test)]
mod tests;
