//! Delay between two styli, from their samples: how much later the second passes the same surface.
//!
//! A multiple-tau correlator (as used for light scattering, Schaetzel 1990): four levels, each of 128 lags, whose samples are
//! means of 1, 4, 16, 64 samples. Each level estimates
//!
//! ```text
//! R_k <- R_k + w (y x_k - R_k),    rho_k = R_k / sqrt(X Y)          k = 0..127, memory 256 of its samples
//! ```
//!
//! with x_k the first stylus k steps ago, y the second one now, both without their running mean. Delays from 2 to 8000
//! samples are covered for 170 multiplications a sample, whatever the speed. A peak within the lags is placed between them by a
//! parabola; the finest level whose peak is within 0.05 of the best is taken.
//!
//! Uncertainty: with c = -R''/R at the peak and N samples in memory, sigma^2 = (1 - rho^2) / (rho^2 N c) steps (the delay error of
//! a correlator with independent noise on both channels, Knapp and Carter 1976, for a narrow band), and 0.05 steps
//! for the parabola. Test: `velocity::tests::two_styli_report_the_speed_within_their_uncertainty`.
//!
//! A peak of chance must not pass for a delay: with M waves of the texture in memory two unlike signals correlate by
//! 1/sqrt(M). So a peak counts from [`CYCLES`] waves on (c^1/2 N / 2 pi of them), which is 1 to 3 mm of slip. A texture with less than
//! four samples a wave is not seen: at 10 kHz and RSm 100 um that is beyond 0.25 m/s.
//!
//! The delay is a mean over the memory: while an object accelerates it lags behind. Only motion that passes the first
//! stylus first is seen.

/// Lags of a level.
const LAGS: usize = 128;
/// Levels, each four times as coarse as the one before.
const LEVELS: usize = 4;
/// Samples a level remembers.
const MEMORY: f32 = 256.0;
/// Shortest lag believed on a coarser level: below it the level before sees better.
const FIRST_COARSE: usize = 24;
/// Waves of the texture in memory from which a peak is no chance.
const CYCLES: f32 = 12.0;
/// How much a coarser level must be better to be taken.
const BETTER: f32 = 0.05;
/// Error of the parabola (steps).
const PARABOLA: f32 = 0.05;

/// A delay and how far it may be off.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Delay {
    /// The second stylus behind the first (s).
    pub seconds: f32,
    /// Standard deviation (s).
    pub sigma_s: f32,
    /// Correlation of the two signals at this delay.
    pub correlation: f32,
}

#[derive(Clone, Copy, Debug)]
struct Level {
    past: [f32; LAGS],
    next: usize,
    products: [f32; LAGS],
    mean: [f32; 2],
    energy: [f32; 2],
    filled: f32,
    /// Sum of the samples that make the next one of the coarser level.
    sum: [f32; 2],
    summed: u8,
}

impl Level {
    const NEW: Self = Self {
        past: [0.0; LAGS],
        next: 0,
        products: [0.0; LAGS],
        mean: [0.0; 2],
        energy: [0.0; 2],
        filled: 0.0,
        sum: [0.0; 2],
        summed: 0,
    };

    /// Takes a sample; gives the next one of the coarser level each fourth time.
    #[inline]
    fn push(&mut self, pair: [f32; 2]) -> Option<[f32; 2]> {
        self.filled += 1.0;
        let weight = 1.0 / self.filled.min(MEMORY);
        let mut centred = [0.0; 2];
        for i in 0..2 {
            self.mean[i] += weight * (pair[i] - self.mean[i]);
            centred[i] = pair[i] - self.mean[i];
            self.energy[i] += weight * (centred[i] * centred[i] - self.energy[i]);
            self.sum[i] += pair[i];
        }
        let [first, second] = centred;
        self.next = (self.next + LAGS - 1) % LAGS;
        if let Some(slot) = self.past.get_mut(self.next) {
            *slot = first;
        }
        // The newest stands at `next`; what follows it is older, around the end.
        let (newer, older) = self.past.split_at(self.next.min(LAGS));
        let by_age = older.iter().chain(newer);
        for (product, past) in self.products.iter_mut().zip(by_age) {
            *product += weight * (second * past - *product);
        }
        self.summed += 1;
        if self.summed < 4 {
            return None;
        }
        let mean = self.sum.map(|sum| 0.25 * sum);
        self.sum = [0.0; 2];
        self.summed = 0;
        Some(mean)
    }

    /// Lag (steps), its deviation and the correlation of the highest peak within the lags from `first` on.
    fn peak(&self, first: usize) -> Option<(f32, f32, f32)> {
        let scale = libm::sqrtf(self.energy[0] * self.energy[1]);
        let inner = self.products.get(first..LAGS - 1)?;
        let (at, &height) = inner.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1))?;
        let lag = first + at;
        let (before, after) =
            (*self.products.get(lag.checked_sub(1)?)?, *self.products.get(lag + 1)?);
        let bend = 2.0 * height - before - after;
        if height <= before || height <= after || bend <= 0.0 || scale <= 0.0 {
            return None;
        }
        let steps = lag as f32;
        let samples = self.filled.min(MEMORY);
        let waves = libm::sqrtf(bend / height) * (self.filled - steps).min(MEMORY);
        if waves < CYCLES * core::f32::consts::TAU {
            return None;
        }
        let place = steps + 0.5 * (after - before) / bend;
        let rho = (height / scale).min(0.9999);
        let variance = (1.0 - rho * rho) / (rho * rho * samples * (bend / height));
        Some((place, libm::sqrtf(variance + PARABOLA * PARABOLA), rho))
    }
}

/// The correlator.
#[derive(Clone, Copy, Debug)]
pub struct TwoStylusDelay {
    levels: [Level; LEVELS],
    origin: Option<[f32; 2]>,
    period_s: f32,
    least: f32,
}

impl TwoStylusDelay {
    /// A correlator for samples at `rate_hz` that believes a correlation of at least `least`.
    #[must_use]
    pub fn new(rate_hz: f32, least: f32) -> Self {
        Self { levels: [Level::NEW; LEVELS], origin: None, period_s: 1.0 / rate_hz, least }
    }

    /// Forgets everything.
    pub fn reset(&mut self) {
        self.levels = [Level::NEW; LEVELS];
        self.origin = None;
    }

    /// Takes the next readings of the first and the second stylus (finite, same unit).
    #[inline]
    pub fn push(&mut self, first: f32, second: f32) {
        // Counted from the first reading, so that a large offset costs no digits.
        let origin = *self.origin.get_or_insert([first, second]);
        let mut pair = [first - origin[0], second - origin[1]];
        for level in &mut self.levels {
            match level.push(pair) {
                Some(coarser) => pair = coarser,
                None => return,
            }
        }
    }

    /// The delay; `None` where no level sees both styli pass the same surface.
    #[must_use]
    pub fn delay(&self) -> Option<Delay> {
        let mut best: Option<Delay> = None;
        let mut period_s = self.period_s;
        for (i, level) in self.levels.iter().enumerate() {
            let first = if i == 0 { 2 } else { FIRST_COARSE };
            if let Some((steps, sigma, correlation)) = level.peak(first)
                && correlation >= self.least
                && best.is_none_or(|best| correlation > best.correlation + BETTER)
            {
                let (seconds, sigma_s) = (steps * period_s, sigma * period_s);
                best = Some(Delay { seconds, sigma_s, correlation });
            }
            period_s *= 4.0;
        }
        best
    }
}
