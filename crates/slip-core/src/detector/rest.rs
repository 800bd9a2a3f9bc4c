//! Noise floor from stretches of rest: the mean noise energy of each band, and whether the floor was learned on something that moves.
//!
//! For recordings whose rest is known beforehand; a running gripper learns its floor with [`crate::floor::Floor`].

use super::{
    DetectorConfig,
    config::BANDS,
    lanes::{Lanes, PrimedBank},
};
use crate::{
    error::ConfigError,
    floor::{FloorConfig, Stretch},
    sample::{FURTHER_AXES, Resolution, Vector},
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
    #[expect(clippy::cast_possible_truncation, reason = "a mean in f32")]
    pub fn energy(&self) -> Option<[f32; BANDS]> {
        (self.samples > 0).then(|| self.sum.map(|sum| (sum / self.samples as f64) as f32))
    }
}

// Health of the floor: whether it was learned on something that moves, from stretches of rest.

slip_msg::named! {
    /// What is known of the noise floor.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub enum FloorHealth {
        fn name: "The name used in output lines.";
    }
    #[default]
    Good: "Nothing speaks against it.", "good";
    Doubtful: "Steady stillness has not confirmed it yet: what it was learned on may have moved or slid.", "doubtful";
}

/// The band that is looked at: shear, which low rates carry as well.
const BAND: usize = 0;
/// Scatter that noise alone does not reach, over the expected one and at least.
const UNSTEADY: f32 = 2.0;
const LEAST_UNSTEADY: f32 = 0.42;
/// Scatter that is steady, over the expected one and at least.
const STEADY: f32 = 1.5;
const LEAST_STEADY: f32 = 0.3;
/// Steady stretches in a row that confirm the floor, and the energy over it that they may have.
const CONFIRMS: u8 = 3;
const SAME: f32 = 2.5;
/// A floor that fell below this share of what was believed was none.
const QUIETER: f32 = 0.4;

/// The doubt and its memory.
///
/// The energy of noise in a part of a stretch scatters as the number of its independent readings n states: the logarithm
/// has the deviation sqrt(2 / n). What slides or moves becomes louder and quieter. A floor is doubtful where parts
/// scatter twice as far before three steady stretches in a row have confirmed it, and where something quieter than it
/// has come. A knock or a slip of a quarter of a stretch changes no quartile.
#[derive(Clone, Copy, Debug)]
pub(super) struct Doubt {
    /// Independent readings in a block.
    readings: f32,
    health: FloorHealth,
    steady: u8,
    /// A slip went on in this stretch, which shows nothing of the floor then.
    disturbed: bool,
}

impl Doubt {
    pub(super) fn new(readings: &[f32; BANDS]) -> Self {
        let readings = readings[BAND];
        Self { readings, health: FloorHealth::Good, steady: 0, disturbed: false }
    }

    #[inline]
    pub(super) fn health(&self) -> FloorHealth {
        self.health
    }

    /// A slip goes on.
    #[inline]
    pub(super) fn disturb(&mut self) {
        self.disturbed = true;
    }

    #[cold]
    pub(super) fn judge(&mut self, stretch: &Stretch<BANDS>) {
        let expected = libm::sqrtf(2.0 / (self.readings * stretch.part_blocks as f32));
        let (spread, over_floor) = (stretch.spread[BAND], stretch.over_floor[BAND]);
        if over_floor < QUIETER {
            (self.health, self.steady) = (FloorHealth::Doubtful, 0);
        }
        let disturbed = core::mem::take(&mut self.disturbed);
        if self.steady >= CONFIRMS || disturbed {
            return;
        }
        if spread > LEAST_UNSTEADY.max(UNSTEADY * expected) {
            (self.health, self.steady) = (FloorHealth::Doubtful, 0);
        } else if spread < LEAST_STEADY.max(STEADY * expected) && over_floor < SAME {
            self.steady += 1;
            if self.steady >= CONFIRMS {
                self.health = FloorHealth::Good;
            }
        } else {
            self.steady = 0;
        }
    }
}

#[cfg(test)]
mod doubt_tests {
    use super::{Doubt, FloorHealth};
    use crate::{detector::BANDS, floor::Stretch};

    /// 40 independent readings in a part: noise scatters by 0.22.
    fn after(doubt: &mut Doubt, spread: f32, over_floor: f32) -> FloorHealth {
        let stretch =
            Stretch { spread: [spread; BANDS], over_floor: [over_floor; BANDS], part_blocks: 40 };
        doubt.judge(&stretch);
        doubt.health()
    }

    #[test]
    fn what_scatters_is_no_rest_until_three_steady_stretches() {
        let mut doubt = Doubt::new(&[1.0; BANDS]);
        assert_eq!(after(&mut doubt, 0.2, 1.0), FloorHealth::Good);
        assert_eq!(after(&mut doubt, 0.6, 1.0), FloorHealth::Doubtful);
        for (spread, over_floor) in [(0.2, 1.0), (0.2, 1.0), (0.2, 9.0), (0.2, 1.0), (0.2, 1.0)] {
            assert_eq!(after(&mut doubt, spread, over_floor), FloorHealth::Doubtful);
        }
        assert_eq!(after(&mut doubt, 0.2, 1.0), FloorHealth::Good);
        assert_eq!(
            after(&mut doubt, 2.0, 1.0),
            FloorHealth::Good,
            "confirmed: this is another thing"
        );
        assert_eq!(after(&mut doubt, 0.2, 0.1), FloorHealth::Doubtful, "it was none");
    }

    #[test]
    fn a_slip_states_nothing_of_the_floor() {
        let mut doubt = Doubt::new(&[1.0; BANDS]);
        doubt.disturb();
        assert_eq!(after(&mut doubt, 2.0, 1.0), FloorHealth::Good);
        assert_eq!(after(&mut doubt, 2.0, 1.0), FloorHealth::Doubtful);
    }
}
