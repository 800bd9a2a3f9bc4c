//! Readings of a stylus in; how many peaks and valleys it has passed, and whether it passes fewer and fewer, out.
//!
//! One stylus cannot tell how fast an object slides, since the spacing of the surface is not known. But the rate of its turns follows the speed,
//! so that it falls where the object slows down.

/// Turns of one slip, counted.
#[derive(Clone, Copy, Debug, Default)]
pub struct TurnCount {
    /// The readings, smoothed.
    smooth: f32,
    extreme: Option<f32>,
    rising: bool,
    count: u32,
}

impl TurnCount {
    /// Takes the next reading; `noise` is the noise in the vibration band (rms, same unit). Whether there was a turn.
    #[inline]
    pub fn step(&mut self, x: f32, noise: f32) -> bool {
        let Some(extreme) = &mut self.extreme else {
            (self.smooth, self.extreme) = (x, Some(x));
            return false;
        };
        self.smooth += SMOOTHING * (x - self.smooth);
        let x = self.smooth;
        let ahead = if self.rising { x - *extreme } else { *extreme - x };
        if ahead >= 0.0 {
            *extreme = x;
        } else if -ahead > NOISES * noise {
            *extreme = x;
            self.rising = !self.rising;
            self.count = self.count.saturating_add(1);
            return true;
        }
        false
    }

    /// Peaks and valleys so far.
    #[must_use]
    #[inline]
    pub fn count(&self) -> u32 {
        self.count
    }
}

/// Turns of one slip, with their rate.
#[derive(Clone, Copy, Debug, Default)]
pub struct Turns {
    turns: TurnCount,
    /// Turns per second, lately and at most.
    rate: f32,
    most: f32,
    /// Range of the readings.
    low: f32,
    high: f32,
    countable: bool,
}

/// What the turns say of the movement.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Passing {
    /// Peaks and valleys a second.
    pub turns_per_s: f32,
    /// Whether that falls: the object slows down.
    pub slows: bool,
}

/// Deviations of the noise in the vibration band that a turn exceeds.
const NOISES: f32 = 12.0;
/// Weight of a reading in the smoothed signal, which leaves 0.38 of white noise.
const SMOOTHING: f32 = 0.25;
/// Time constant of the rate (s).
const TAU_S: f32 = 0.01;
/// Share of the largest rate below which the object slows down.
const SLOWER: f32 = 0.85;
/// A rate is believed from this many turns on.
const ENOUGH: u32 = 6;

impl Turns {
    /// Below this sample rate (Hz) a fast surface is not resolved.
    pub const LEAST_RATE_HZ: f32 = 6000.0;

    /// Takes the next reading, `dt_s` after the one before; `noise` is the noise in the vibration band (rms, same unit).
    #[inline]
    pub fn step(&mut self, x: f32, noise: f32, dt_s: f32) {
        if self.turns.extreme.is_none() {
            (self.low, self.high) = (x, x);
        }
        let turns = self.turns.step(x, noise);
        if !self.countable {
            let x = self.turns.smooth;
            (self.low, self.high) = (self.low.min(x), self.high.max(x));
            self.countable = self.high - self.low > 2.0 * NOISES * noise;
        }
        let share = (dt_s / TAU_S).min(1.0);
        self.rate -= share * self.rate;
        if turns {
            self.rate += 1.0 / TAU_S;
            if self.turns.count() >= ENOUGH {
                self.most = self.most.max(self.rate);
            }
        }
    }

    /// What they say; `None` where the surface is too smooth to count them.
    #[must_use]
    pub fn passing(&self) -> Option<Passing> {
        let slows = self.most > 0.0 && self.rate < SLOWER * self.most;
        self.countable.then_some(Passing { turns_per_s: self.rate, slows })
    }
}
