//! The moved distance of a slip, block by block: where it is, with which variance, and whether it moves or stands.

use super::bank::TravelBlock;

/// Block means that are kept.
const KEPT: usize = 64;
/// Least deviation of a block (m): the model's own.
const LEAST_M: f32 = 3e-7;
/// A travel with less noise than this (m) is fine: it shows the start of a slip.
const FINE_M: f32 = 4e-6;
/// It has moved where it is further than this many deviations, and this far (m) ...
const MOVES: f32 = 5.0;
const MOVES_M: f32 = 1.5e-6;
/// ... and stands where it stays within these for this time (s).
const STANDS: f32 = 6.0;
const STANDS_M: f32 = 3e-6;
const STANDS_S: f32 = 6e-3;
/// Third differences of block means show noise that came since: their mean over this time (s), 20 variances each.
const NOISE_S: f32 = 5e-3;
const THIRD: f32 = 20.0;
/// A reading is missing after so many times the time between two.
const MISSING: f32 = 4.0;
/// More equal readings than this, and twice the most at rest, are those of a sensor that is stuck.
const EQUAL: u32 = 20;
/// Further back than this (m) than where it stood, it counts the other way.
const TURNS_M: f32 = 3e-6;

/// The sensor, as it was at rest.
#[derive(Clone, Copy, Debug, Default)]
pub struct TravelSensor {
    /// Where it stood before the alarm (m), and how far the object has moved since then, with its sign.
    pub rest_m: f32,
    /// Deviation of one reading (m).
    pub sigma_m: f32,
    /// Step of its readings (m).
    pub step_m: f32,
    /// Time between two readings (s), where it is asked more often.
    pub read_s: Option<f32>,
    /// Most readings that were equal to the one before.
    pub equal: u32,
}

/// The readings of a slip.
#[derive(Clone, Debug)]
pub(super) struct Travel {
    sensor: TravelSensor,
    sign: f32,
    signed: bool,
    block_s: f32,
    sum: f32,
    filled: f32,
    last: Option<f32>,
    news: bool,
    equal: u32,
    unread_s: f32,
    /// Time between two readings (s).
    every_s: f32,
    means: [f32; KEPT],
    at: usize,
    kept: usize,
    third: [f32; 3],
    noise2: f32,
    /// For how long it has stood (s).
    pub(super) stood_s: f32,
}

impl Travel {
    pub(super) const NEW: Self = Self {
        sensor: TravelSensor { rest_m: 0.0, sigma_m: 0.0, step_m: 0.0, read_s: None, equal: 0 },
        sign: 1.0,
        signed: false,
        block_s: 3e-4,
        sum: 0.0,
        filled: 0.0,
        last: None,
        news: false,
        equal: 0,
        unread_s: f32::INFINITY,
        every_s: 0.0,
        means: [0.0; KEPT],
        at: 0,
        kept: 0,
        third: [f32::NAN; 3],
        noise2: 0.0,
        stood_s: 0.0,
    };

    /// An alarm, where the object has moved by `moved_m` (m, with its sign) since it stood.
    pub(super) fn begin(&mut self, sensor: Option<TravelSensor>, moved_m: f32, block_s: f32) {
        *self = Self { sensor: sensor.unwrap_or_default(), block_s, ..Self::NEW };
        if let Some(sensor) = sensor {
            self.unread_s = 0.0;
            self.every_s = sensor.read_s.unwrap_or(0.0);
        }
        self.sign = if moved_m < 0.0 { -1.0 } else { 1.0 };
        self.signed = moved_m.abs() > self.moves_m();
    }

    /// Takes the reading of a sample, if there is one.
    pub(super) fn push(&mut self, travel_m: Option<f32>, dt_s: f32) {
        self.unread_s += dt_s;
        let Some(travel_m) = travel_m else { return };
        let news = self.last != Some(travel_m);
        if news || self.sensor.read_s.is_none() {
            if self.last.is_some() && self.unread_s < 0.1 {
                self.every_s = self.every_s.max(self.unread_s);
            }
            self.unread_s = 0.0;
        }
        self.equal = if news { 0 } else { self.equal.saturating_add(1) };
        self.news |= news;
        self.last = Some(travel_m);
        self.sum += travel_m - self.sensor.rest_m;
        self.filled += 1.0;
    }

    /// Whether readings come that are not stuck: equal for much longer than the noise at rest ever left them.
    pub(super) fn is_there(&self) -> bool {
        let stuck = self.equal > EQUAL + 2 * self.sensor.equal;
        !stuck && self.unread_s <= MISSING * self.every_s.max(self.block_s)
    }

    /// Whether it shows the start of a slip.
    pub(super) fn is_fine(&self) -> bool {
        self.sigma_m() < FINE_M
    }

    /// Deviation of a block (m).
    pub(super) fn sigma_m(&self) -> f32 {
        libm::sqrtf(self.variance(self.block_s / self.every_s.max(1e-4)))
    }

    /// Variance of the mean of so many readings (m^2).
    fn variance(&self, readings: f32) -> f32 {
        let TravelSensor { sigma_m, step_m, .. } = self.sensor;
        let (noise2, step2) = (sigma_m * sigma_m, step_m * step_m / 12.0);
        // Noise below the step is no dither: rounding errors do not average out.
        let rounded = sigma_m < 0.4 * step_m;
        let all = noise2 + step2;
        let all = if rounded { all } else { all / readings.max(1.0) };
        let known = all + LEAST_M * LEAST_M;
        if self.noise2 > 2.0 * known { self.noise2 } else { known }
    }

    /// What a movement exceeds (m).
    fn moves_m(&self) -> f32 {
        (MOVES * self.sigma_m()).max(MOVES_M)
    }

    /// The end of a block: its reading, where there is a new one.
    pub(super) fn block(&mut self) -> Option<TravelBlock> {
        let (sum, filled, news) = (self.sum, self.filled, self.news);
        self.sum = 0.0;
        self.filled = 0.0;
        self.news = false;
        let held = self.sensor.read_s.is_some();
        let before = if self.kept > 0 { self.means[self.at % KEPT] } else { 0.0 };
        let mean = if filled <= 0.0 {
            None
        } else if held {
            self.last.filter(|_| news).map(|last| last - self.sensor.rest_m)
        } else {
            Some(sum / filled)
        };
        let y = mean.map(|mean| self.signed(mean));
        self.at = (self.at + 1) % KEPT;
        self.means[self.at] = y.unwrap_or(before);
        self.kept = (self.kept + 1).min(KEPT);
        if let (Some(y), false) = (y, held) {
            let [one, two, three] = self.third;
            let third = y - 3.0 * one + 3.0 * two - three;
            self.third = [y, one, two];
            if third.is_finite() {
                let square = (third * third / THIRD).min(1e-8);
                self.noise2 += self.block_s / NOISE_S * (square - self.noise2);
            }
        }
        let stands = self.range(STANDS_S) < (STANDS * self.sigma_m()).max(STANDS_M);
        self.stood_s = if stands { self.stood_s + self.block_s } else { 0.0 };
        let readings = if held { 1.0 } else { filled };
        y.map(|y| TravelBlock { y, variance: self.variance(readings) })
    }

    /// The distance since the rest, positive the way it goes.
    fn signed(&mut self, mean: f32) -> f32 {
        if !self.signed {
            let least = self.moves_m().max(TURNS_M);
            if (self.sign * mean).abs() > least {
                self.signed = true;
                if self.sign * mean < 0.0 {
                    self.sign = -self.sign;
                }
            }
        }
        self.sign * mean
    }

    /// Distance since the rest (m), as of the last block.
    pub(super) fn y(&self) -> f32 {
        if self.kept > 0 { self.means[self.at % KEPT] } else { 0.0 }
    }

    fn range(&self, s: f32) -> f32 {
        let blocks = blocks(s, self.block_s).min(self.kept);
        let (mut low, mut high) = (f32::INFINITY, f32::NEG_INFINITY);
        for back in 0..blocks {
            let mean = self.means[(self.at + KEPT - back) % KEPT];
            low = low.min(mean);
            high = high.max(mean);
        }
        high - low
    }

    /// Whether it stands.
    pub(super) fn stands(&self) -> bool {
        self.stood_s > 0.0 && self.kept >= blocks(STANDS_S, self.block_s)
    }

    /// The distance counts from here; what has stood is followed by this share of a block.
    pub(super) fn rest(&mut self, share: f32) {
        let most_m = 2.0 * self.sigma_m();
        let y = self.y();
        if share >= 1.0 {
            self.sensor.rest_m += self.sign * y;
            self.kept = 0;
            self.stood_s = 0.0;
            // Where the distance begins anew its differences do too: the step back to zero is no noise.
            self.third = [f32::NAN; 3];
        } else {
            self.sensor.rest_m += self.sign * share * y.max(-most_m).min(most_m);
        }
    }

    /// Deviations of the distance since the last stop (m) that are a movement: without a stylus fewer.
    pub(super) fn moved_again_m(&self, stylus: bool) -> f32 {
        (STANDS * self.sigma_m()).max(if stylus { 2.0 * STANDS_M } else { STANDS_M })
    }
}

/// Blocks of `block_s` (s) that make `s` (s).
fn blocks(s: f32, block_s: f32) -> usize {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "some blocks")]
    let blocks = (s / block_s + 0.5) as usize;
    blocks.max(2)
}

#[cfg(test)]
mod tests;
