//! Stretches of rest in, the mean noise energy of each band out.
//!
//! For recordings whose rest is known beforehand; a running gripper learns its floor with [`crate::floor::Floor`].

use super::{BANDS, DetectorConfig, lanes::Lanes, primed::PrimedBank};
use crate::{
    error::ConfigError,
    floor::FloorConfig,
    resolution::Resolution,
    sample::{FURTHER_AXES, Vector},
};

const AXES: usize = 1 + FURTHER_AXES;

/// Pools the noise of several stretches.
#[derive(Clone, Copy, Debug)]
pub struct RestMeter {
    /// One for each axis.
    banks: [PrimedBank; AXES],
    resolution: [Resolution; AXES],
    sum: [f64; BANDS],
    samples: u64,
}

impl RestMeter {
    /// A meter for samples at `rate_hz`.
    ///
    /// # Errors
    /// Where a band does not fit the sample rate.
    pub fn new(config: &DetectorConfig, rate_hz: f32) -> Result<Self, ConfigError> {
        let lanes = Lanes::new(config, rate_hz)?;
        Ok(Self {
            banks: [PrimedBank::new(&lanes, rate_hz)?; AXES],
            resolution: [Resolution::default(); AXES],
            sum: [0.0; BANDS],
            samples: 0,
        })
    }

    /// Begins another stretch of rest.
    pub fn start(&mut self) {
        self.banks.iter_mut().for_each(PrimedBank::start);
    }

    /// Takes the next reading of a stretch with one axis; one that is not finite is left out.
    pub fn push(&mut self, x: f32) {
        self.push_vector([x, 0.0, 0.0]);
    }

    /// Takes the next reading of all axes of the stretch; one with a component that is not finite is left out.
    pub fn push_vector(&mut self, vector: Vector) {
        if !vector.iter().all(|x| x.is_finite()) {
            return;
        }
        let mut used = false;
        for ((bank, resolution), x) in self.banks.iter_mut().zip(&mut self.resolution).zip(vector) {
            resolution.push(x);
            let Some(y) = bank.step(x) else { continue };
            for (sum, y) in self.sum.iter_mut().zip(y) {
                *sum += f64::from(y) * f64::from(y);
            }
            bank.flush_tiny();
            used = true;
        }
        self.samples += u64::from(used);
    }

    /// Mean energy of the bands since the last call (signal unit squared), if there were samples; what was measured up to
    /// now counts no more, and the stretch goes on.
    pub fn take(&mut self) -> Option<[f32; BANDS]> {
        let energy = self.energy();
        (self.sum, self.samples) = ([0.0; BANDS], 0);
        energy
    }

    /// Samples that were used.
    #[must_use]
    pub fn samples(&self) -> u64 {
        self.samples
    }

    /// The floor of this rest (signal unit squared): the mean energy of the bands, and not less than the resolution.
    /// `None` before the first sample, and where all readings were the same and no resolution is configured.
    #[must_use]
    pub fn floor(&self, config: FloorConfig) -> Option<[f32; BANDS]> {
        let least = self.least_energy(config);
        let energy = self.energy()?.map(|energy| energy.max(least));
        energy.iter().all(|energy| *energy > 0.0).then_some(energy)
    }

    /// The least energy that is believed (signal unit squared).
    #[must_use]
    pub fn least_energy(&self, config: FloorConfig) -> f32 {
        let rms = if config.min_rms > 0.0 { config.min_rms } else { self.resolution_rms() };
        rms * rms
    }

    /// What rounding makes (rms) over all axes.
    fn resolution_rms(&self) -> f32 {
        let [first, further @ ..] = &self.resolution;
        further.iter().fold(first.rms(), |all, axis| libm::hypotf(all, axis.rms()))
    }

    /// Mean energy of the bands (signal unit squared); `None` before the first sample.
    #[must_use]
    #[expect(
        clippy::cast_precision_loss,
        clippy::cast_possible_truncation,
        reason = "a mean in f32"
    )]
    pub fn energy(&self) -> Option<[f32; BANDS]> {
        (self.samples > 0).then(|| self.sum.map(|sum| (sum / self.samples as f64) as f32))
    }
}
