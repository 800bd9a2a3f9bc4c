//! What the signal of a slip shows block by block: its power, whether it moves, and whether it stands.

use super::bank::Law;
use crate::{
    sample::Signal,
    turns::{Turn, Turns},
};

/// Block means that are kept.
const KEPT: usize = 64;
/// Bounds of the slope of a surface (rms).
const SLOPE: [f32; 2] = [0.005, 0.3];
/// It stands where block means stay within this many deviations for this time (s).
const STANDS: f32 = 8.5;
const STANDS_S: f32 = 6e-3;
/// Squared differences of readings over those of the noise: so fast that block means blur it, moves again, moves again although a fine
/// travel shows nothing, and stands no longer.
const BLURRED: f32 = 6.7;
const AGAIN: f32 = 4.4;
const AGAIN_ALONE: f32 = 6.7;
const NOT_STILL: f32 = 2.35;
/// Weight of the last block in them.
const SMOOTHING: f32 = 0.2;
/// Range since a stop that is movement, in deviations of a block mean and in mean swings; the same where a fine travel shows nothing.
const AGAIN_NOISES: [f32; 2] = [9.0, 15.0];
const AGAIN_SWINGS: [f32; 2] = [0.5, 1.2];
/// That range is forgotten in this time (s).
const AGAIN_TAU_S: f32 = 0.06;
/// Share of how far a stylus sinks in that is not known, and weight of the last block in its mean.
const SINKS: f32 = 0.4;
const SINKS_SHARE: f32 = 0.1;
/// Above this noise (m) a stylus shows no surface.
const NOISIEST_M: f32 = 5e-6;

/// Vibration: over noise (rms) at this speed (m/s), least and most; weight of a block; time in which the finger rings out (s); time constant of the
/// mean that is taken off (s); power over that of the noise of a finger that vibrates, moves again and stands.
const LEVEL: [f32; 2] = [0.2, 1000.0];
const LEVEL_M_S: f32 = 0.1;
const WEIGHT: f32 = 0.25;
const RINGS_S: f32 = 2.5e-3;
const MEAN_S: f32 = 1.6e-3;
const POWER: [f32; 2] = [3.4, 1.7];
/// What is below this share of the largest power is the finger that rings.
const ECHO: f32 = 0.01;
/// A reading counts up to so many deviations of the noise.
const MOST: f32 = 1e6;

/// Distance that the object has moved when the alarm comes (m), by the signal.
pub(super) fn alarm_m(signal: Signal) -> f32 {
    match signal {
        Signal::Displacement => 6e-6,
        Signal::Vibration => 1e-4,
    }
}

/// The power of a block.
#[derive(Clone, Copy, Debug)]
pub(super) struct Power {
    /// With that of the noise, and that of the noise.
    pub(super) square: f32,
    pub(super) noise: f32,
}

/// What a reading states of the turns.
#[derive(Clone, Copy, Debug)]
pub(super) struct TurnAt {
    /// What it is.
    pub(super) turn: Turn,
    /// Since the end of the last block (s).
    pub(super) within_s: f32,
}

/// The signal and its memory.
#[derive(Clone, Debug)]
pub(super) struct Stylus {
    signal: Signal,
    sigma: f32,
    dt_s: f32,
    samples: u16,
    filled: u16,
    sum: f32,
    differences: f32,
    last: Option<f32>,
    mean: Option<f32>,
    fast: f32,
    /// Mean of what is not known of how far it has sunk in, in a block.
    sunk: f32,
    means: [f32; KEPT],
    at: usize,
    kept: usize,
    turns: Turns,
    /// Mean swing of the slip before (m); 0 before the first.
    swing: f32,
    low: f32,
    high: f32,
    /// Vibration: mean, and smoothed power over that of the noise, and the largest.
    level: Option<f32>,
    most: f32,
}

impl Stylus {
    pub(super) const NEW: Self = Self {
        signal: Signal::Displacement,
        sigma: 1e-7,
        dt_s: 1e-4,
        samples: 3,
        filled: 0,
        sum: 0.0,
        differences: 0.0,
        last: None,
        mean: None,
        fast: 0.0,
        sunk: 0.0,
        means: [0.0; KEPT],
        at: 0,
        kept: 0,
        turns: Turns::NEW,
        swing: 0.0,
        low: 0.0,
        high: 0.0,
        level: None,
        most: 0.0,
    };

    /// An alarm of a signal with white noise `sigma` (rms), read each `dt_s` (s), in blocks of so many samples.
    pub(super) fn begin(&mut self, signal: Signal, sigma: f32, dt_s: f32, samples: u16) {
        *self = Self { signal, sigma, dt_s, samples, swing: self.swing, ..Self::NEW };
        self.start();
    }

    /// The object begins to move.
    pub(super) fn start(&mut self) {
        self.turns = Turns::NEW;
        self.kept = 0;
        self.most = 0.0;
    }

    /// Another object.
    pub(super) fn forget(&mut self) {
        self.swing = 0.0;
    }

    /// How it follows the distance, where it is `alone` by its turns too: beside a travel they are worth less than they are sure of. `None` where it
    /// is too noisy to show a surface.
    pub(super) fn law(&self, alone: bool) -> Option<Law> {
        let block_s = f32::from(self.samples) * self.dt_s;
        match self.signal {
            Signal::Displacement if self.sigma > NOISIEST_M => None,
            Signal::Displacement => {
                Some(Law { slope: SLOPE, turns: alone, rings: 0.0, weight: None })
            }
            Signal::Vibration => Some(Law {
                slope: LEVEL.map(|level| level / (LEVEL_M_S * block_s)),
                turns: false,
                rings: libm::expf(-block_s / RINGS_S),
                weight: Some(WEIGHT),
            }),
        }
    }

    /// Deviation of the mean of two blocks.
    fn mean_noise(&self) -> f32 {
        self.sigma / libm::sqrtf(2.0 * f32::from(self.samples)) + self.sunk
    }

    /// Squared differences of readings of the noise.
    fn fast_noise(&self) -> f32 {
        let n = f32::from(self.samples);
        2.0 * n * n * self.sigma * self.sigma + self.sunk * self.sunk
    }

    /// Takes the next reading; what it states of the turns, where they count.
    pub(super) fn push(&mut self, x: f32) -> Option<TurnAt> {
        match self.signal {
            Signal::Displacement => {
                let last = self.last.replace(x).unwrap_or(x);
                self.sum += x;
                self.differences += (x - last) * (x - last);
                let within_s = f32::from(self.filled) * self.dt_s;
                self.filled += 1;
                Some(TurnAt { turn: self.turns.push(x, self.sigma), within_s })
            }
            Signal::Vibration => {
                let x = x / self.sigma;
                let level = self.level.get_or_insert(x);
                let without = (x - *level).clamp(-MOST, MOST);
                *level += (self.dt_s / MEAN_S).min(1.0) * without;
                self.sum += without * without;
                self.filled += 1;
                None
            }
        }
    }

    /// The end of a block in which the stylus has sunk in by about `sunk` as the force has changed; `None` where a reading was missing. How far it sinks in
    /// is known roughly: what is not known is noise.
    pub(super) fn block(&mut self, sunk: f32) -> Option<Power> {
        let unknown = SINKS * sunk;
        self.sunk += SINKS_SHARE * (unknown.abs() - self.sunk);
        let n = f32::from(self.samples);
        let (filled, sum, differences) = (self.filled, self.sum, self.differences);
        self.filled = 0;
        self.sum = 0.0;
        self.differences = 0.0;
        if filled < self.samples {
            self.mean = None;
            return None;
        }
        if self.signal == Signal::Vibration {
            let power = sum / n;
            self.most = self.most.max(self.fast);
            self.fast += 0.5 * SMOOTHING * (power - self.fast);
            return Some(Power { square: power, noise: (ECHO * self.most).max(1.0) });
        }
        let mean = sum / n;
        let fast = n * differences;
        self.fast += SMOOTHING * (fast - self.fast);
        let before = self.mean.replace(mean).unwrap_or(mean);
        self.keep(0.5 * (mean + before));
        let noise = 2.0 * self.sigma * self.sigma / n + unknown * unknown;
        let square = if self.fast > BLURRED * self.fast_noise() {
            (fast - self.fast_noise()).max(0.0) + noise
        } else {
            (mean - before) * (mean - before)
        };
        Some(Power { square, noise })
    }

    fn keep(&mut self, middle: f32) {
        self.at = (self.at + 1) % KEPT;
        self.means[self.at] = middle;
        self.kept = (self.kept + 1).min(KEPT);
    }

    /// Range of the block means of the last `s` (s), as far as they are kept.
    fn range(&self, s: f32) -> f32 {
        let blocks = self.blocks(s).min(self.kept);
        let (mut low, mut high) = (f32::INFINITY, f32::NEG_INFINITY);
        for back in 0..blocks {
            let mean = self.means[(self.at + KEPT - back) % KEPT];
            low = low.min(mean);
            high = high.max(mean);
        }
        high - low
    }

    /// Blocks that make `s` (s).
    fn blocks(&self, s: f32) -> usize {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "some blocks")]
        let blocks = (s / (f32::from(self.samples) * self.dt_s) + 0.5) as usize;
        blocks.max(2)
    }

    /// Power over that of the noise, of a vibration.
    fn power(&self) -> f32 {
        self.fast / (ECHO * self.most).max(1.0)
    }

    /// Whether it stands.
    pub(super) fn stands(&self) -> bool {
        if self.signal == Signal::Vibration {
            return self.power() < POWER[1];
        }
        self.kept >= self.blocks(STANDS_S)
            && self.range(STANDS_S) < STANDS * self.mean_noise()
            && self.fast < NOT_STILL * self.fast_noise()
    }

    /// The object has stopped.
    pub(super) fn stop(&mut self) {
        let swing = self.turns.swing();
        self.swing = if swing > 0.0 { swing } else { self.swing.max(0.5 * self.turns.range()) };
        self.rest();
    }

    /// Nothing is known to move from here on.
    pub(super) fn rest(&mut self) {
        let mean = if self.kept > 0 { self.means[self.at % KEPT] } else { f32::NAN };
        self.low = mean;
        self.high = mean;
    }

    /// Whether it moves again after a stop: more than pads that swing, and clearly so where a fine travel `stands`.
    pub(super) fn moves_again(&mut self, block_s: f32, soon: bool, stands: bool) -> bool {
        let strict = usize::from(stands);
        if self.signal == Signal::Vibration {
            return self.power() > POWER[0];
        }
        if self.kept == 0 {
            return false;
        }
        let middle = self.means[self.at % KEPT];
        if self.low.is_nan() {
            self.low = middle;
            self.high = middle;
        }
        let back = block_s / AGAIN_TAU_S * (self.high - self.low);
        self.low = (self.low + back).min(middle);
        self.high = (self.high - back).max(middle);
        let swing = if soon { AGAIN_SWINGS[strict] * self.swing } else { 0.0 };
        let shakes = if stands { AGAIN_ALONE } else { AGAIN };
        self.high - self.low > (AGAIN_NOISES[strict] * self.mean_noise()).max(swing)
            || self.fast > shakes * self.fast_noise()
    }
}
