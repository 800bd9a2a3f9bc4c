//! Noise of a stylus's electronics told from a surface: white and far above the floor.

/// Whether the stylus shows the noise of its electronics instead of a surface.
///
/// The energy of second differences over that of first differences is 3 for white noise and below 0.4 for anything below a tenth of the sample
/// rate.
#[derive(Clone, Copy, Debug, Default)]
pub struct Whiteness {
    last: Option<[f32; 2]>,
    first_energy: f32,
    second_energy: f32,
    seen: u16,
    noisy: bool,
}

impl Whiteness {
    /// Readings of a running mean, and before the first verdict.
    const READINGS: u16 = 32;
    const WHITE: f32 = 2.0;
    const NOT_WHITE: f32 = 1.0;
    /// First differences over the noise in the vibration band: 3.8 for white noise at 10 kHz; five times that is no noise of a sound stylus.
    const LOUD: f32 = 19.0;

    /// A new slip.
    pub fn begin(&mut self) {
        *self = Self { noisy: self.noisy, ..Self::default() };
    }

    /// Whether the stylus is not to be believed.
    #[must_use]
    #[inline]
    pub fn is_noisy(&self) -> bool {
        self.noisy
    }

    /// Whether enough of this slip was seen for a verdict.
    #[must_use]
    #[inline]
    pub fn is_known(&self) -> bool {
        self.seen >= Self::READINGS
    }

    /// Takes the next reading; `noise` is the noise of a sound stylus in its vibration band (rms).
    pub fn step(&mut self, x: f32, noise: f32) {
        let Some([one, two]) = self.last.replace([x, self.last.map_or(x, |[one, _]| one)]) else {
            return;
        };
        let (first, second) = (x - one, x - 2.0 * one + two);
        self.seen = self.seen.saturating_add(1).min(Self::READINGS);
        let share = 1.0 / f32::from(self.seen);
        self.first_energy += share * (first * first - self.first_energy);
        self.second_energy += share * (second * second - self.second_energy);
        if self.seen < Self::READINGS {
            return;
        }
        let loud = Self::LOUD * noise;
        let loud = noise > 0.0 && self.first_energy > loud * loud;
        let ratio = if self.noisy { Self::NOT_WHITE } else { Self::WHITE };
        self.noisy = loud && self.second_energy > ratio * self.first_energy;
    }
}
