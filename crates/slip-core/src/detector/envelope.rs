//! Mean energy of each band over its mean floor, for how strong a slip is.

use super::{
    config::{BANDS, VIBRATION},
    sum::Block,
};

/// Below this fraction of its recent peak the energy is the fading memory of a slip that has stopped.
const FRESH: f32 = 0.5;

/// `e <- e + a (energy - e)`, `f <- f + a (floor - f)`, a = 1 - exp(-block/tau) with a tau for each band.
#[derive(Clone, Copy, Debug)]
pub(super) struct Envelope {
    weight: [f32; BANDS],
    energy: [f32; BANDS],
    floor: [f32; BANDS],
    carried: [bool; BANDS],
    /// The highest energy of what slides in the last milliseconds, decaying half as fast as the energy does at rest.
    recent_peak: f32,
    peak_decay: f32,
}

impl Envelope {
    /// Means with the time constants `tau_s` (s) over blocks of `block_s` (s), of the bands that the rate carries.
    pub(super) fn new(tau_s: [f32; BANDS], block_s: f32, carried: [bool; BANDS]) -> Self {
        Self {
            weight: tau_s.map(|tau_s| -libm::expm1f(-block_s / tau_s)),
            energy: [1.0; BANDS],
            floor: [1.0; BANDS],
            carried,
            recent_peak: 0.0,
            peak_decay: libm::expf(-0.5 * block_s / tau_s[VIBRATION]),
        }
    }

    /// Starts afresh, as at rest.
    pub(super) fn reset(&mut self) {
        self.energy = [1.0; BANDS];
        self.floor = [1.0; BANDS];
        self.recent_peak = 0.0;
    }

    /// Takes the next block.
    #[inline]
    pub(super) fn step(&mut self, block: &Block) {
        for b in 0..BANDS {
            self.energy[b] += self.weight[b] * (block.energy[b] - self.energy[b]);
            self.floor[b] += self.weight[b] * (block.floor[b] - self.floor[b]);
        }
        self.recent_peak = self.sliding().max(self.recent_peak * self.peak_decay);
    }

    /// Whether the energy is of now, and not only of the last milliseconds.
    #[inline]
    pub(super) fn is_fresh(&self) -> bool {
        self.sliding() >= FRESH * self.recent_peak
    }

    /// Which bands the rate carries.
    pub(super) fn carried(&self) -> [bool; BANDS] {
        self.carried
    }

    /// Mean energy of each band over its floor.
    #[inline]
    pub(super) fn over_floor(&self) -> [f32; BANDS] {
        core::array::from_fn(|b| self.energy[b] / self.floor[b])
    }

    /// The highest of vibration and the two highest octaves, as far as the rate carries them.
    #[inline]
    pub(super) fn sliding(&self) -> f32 {
        let over = |b: usize| if self.carried[b] { self.energy[b] / self.floor[b] } else { 0.0 };
        over(VIBRATION).max(over(BANDS - 2).max(over(BANDS - 1)))
    }
}

#[cfg(test)]
mod tests {
    use super::{BANDS, Block, Envelope};

    #[test]
    fn a_band_that_the_rate_does_not_carry_makes_nothing_gross() {
        let carried = |last: bool| core::array::from_fn(|b| b < BANDS - 1 || last);
        let mut energy = [1.0; BANDS];
        energy[BANDS - 1] = 1e6;
        for gross in [true, false] {
            let mut envelope = Envelope::new([0.005; BANDS], 5e-4, carried(gross));
            envelope.step(&Block { energy, floor: [1.0; BANDS], moving: false });
            assert_eq!(envelope.sliding() > 25.0, gross);
        }
    }
}
