//! Blocks of band energies in, a statistic over its threshold out: the one trait of all sequential tests, and the energy test.

use super::config::BANDS;

/// What one block of samples (half a millisecond) showed, in units of the sensor noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Block {
    /// Mean energy of each band, own motion taken off.
    pub energy: [f32; BANDS],
    /// What noise and motion may have caused of it.
    pub floor: [f32; BANDS],
    /// The robot moves, so that the four bands that do not overlap decide too. In a still scene shear and vibration are enough.
    pub moving: bool,
}

/// A sequential test for slip.
pub trait SequentialTest {
    /// Takes the next block; gives the statistic over its threshold: 1 and above is a slip.
    fn step(&mut self, block: &Block) -> f32;

    /// Starts afresh, as at rest.
    fn reset(&mut self);
}

/// Mean energy over mean floor of each band against its threshold:
/// `e <- e + a (energy - e)`, `f <- f + a (floor - f)`, a = 1 - exp(-block/tau) with a tau for each band, statistic max e / (f h).
#[derive(Clone, Copy, Debug)]
pub struct EnergyTest {
    weight: [f32; BANDS],
    energy: [f32; BANDS],
    floor: [f32; BANDS],
    per_threshold: [f32; BANDS],
}

impl EnergyTest {
    /// A test with the time constants `tau_s` (s) for blocks of `block_s` (s); bands with a threshold of infinity are left out.
    #[must_use]
    pub fn new(tau_s: [f32; BANDS], block_s: f32, thresholds: [f32; BANDS]) -> Self {
        Self {
            weight: tau_s.map(|tau_s| -libm::expm1f(-block_s / tau_s)),
            energy: [1.0; BANDS],
            floor: [1.0; BANDS],
            per_threshold: thresholds.map(|threshold| 1.0 / threshold),
        }
    }

    /// Which bands are not left out.
    pub(super) fn has_bands(&self) -> [bool; BANDS] {
        self.per_threshold.map(|reciprocal| reciprocal > 0.0)
    }

    /// Mean energy of each band over its floor.
    #[must_use]
    #[inline]
    pub fn over_floor(&self) -> [f32; BANDS] {
        core::array::from_fn(|b| self.energy[b] / self.floor[b])
    }
}

impl SequentialTest for EnergyTest {
    #[inline]
    fn step(&mut self, block: &Block) -> f32 {
        let mut over = [0.0_f32; BANDS];
        for (b, over) in over.iter_mut().enumerate() {
            self.energy[b] += self.weight[b] * (block.energy[b] - self.energy[b]);
            self.floor[b] += self.weight[b] * (block.floor[b] - self.floor[b]);
            *over = self.energy[b] / self.floor[b] * self.per_threshold[b];
        }
        let [shear, vibration, a, b, c, d] = over;
        let still = shear.max(vibration);
        if block.moving { still.max(a.max(b).max(c.max(d))) } else { still }
    }

    fn reset(&mut self) {
        self.energy = [1.0; BANDS];
        self.floor = [1.0; BANDS];
    }
}
