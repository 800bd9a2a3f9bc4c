//! The bands of a configuration at a sample rate: their filters, and the readings of all axes in the block that is being filled.

use super::config::{BANDS, DetectorConfig, FIRST_OCTAVE};
use crate::{
    error::ConfigError,
    filter::{Band, FilterBank, MAX_CORNER},
    sample::{FURTHER_AXES, Resolution},
};

/// Filters that run for the [`BANDS`]: a whole number of vectors where the processor has them. Those without a band have a part in
/// nothing.
pub(super) const LANES: usize =
    if cfg!(any(target_arch = "x86_64", target_arch = "aarch64")) { 8 } else { BANDS };

/// Length of a block (s): the tests decide this often, at low sample rates with every sample.
const BLOCK_S: f32 = 5e-4;

/// Lower corner of a shear or vibration band that had to be lowered, over the highest corner that the sample rate can carry.
const LOWERED: f32 = 0.25;

/// Independent readings in the mean energy of shear and vibration, twice the time constant long: the mean of fewer becomes gross by itself.
const MEAN_READINGS: f32 = 6.0;
/// Independent readings in a part of the noise floor: the median of parts with fewer lies far below their mean.
const PART_READINGS: f32 = 4.0;

/// What all parts of the detector have to know of the bands.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lanes {
    /// Corners. An octave that the rate cannot carry has no part in any decision; the shear and the vibration band are lowered.
    pub(super) corners: [Band; BANDS],
    /// Samples in a block, 1 to [`MOST`].
    pub(super) block_len: usize,
    /// Length of a block (s).
    pub(super) block_s: f32,
    /// Independent readings of each band in a block: twice its width times its length; 0 where the rate does not carry it.
    pub(super) readings: [f32; BANDS],
    /// Whether the rate carries the shear band, which begins where the motion of hands and robots ends.
    pub(super) above_motion: bool,
}

impl Lanes {
    /// # Errors
    /// Where a corner is no frequency; [`PipelineConfig::check`](crate::PipelineConfig::check) refuses more.
    pub(super) fn new(config: &DetectorConfig, rate_hz: f32) -> Result<Self, ConfigError> {
        let limit_hz = MAX_CORNER * rate_hz;
        let block_len = (samples(1e3 * BLOCK_S * 0.999, rate_hz) as usize).min(MOST);
        let block_s = block_len as f32 / rate_hz;
        let mut lanes = Self {
            corners: [Band { low_hz: LOWERED * limit_hz, high_hz: limit_hz }; BANDS],
            block_len,
            block_s,
            readings: [0.0; BANDS],
            above_motion: config.reaches_above_motion(rate_hz),
        };
        for (b, band) in config.bands().iter().enumerate() {
            let corners = if fits(band, rate_hz) {
                *band
            } else if b < FIRST_OCTAVE {
                Band { low_hz: LOWERED * limit_hz, high_hz: limit_hz }
            } else {
                continue;
            };
            lanes.corners[b] = corners;
            lanes.readings[b] = 2.0 * (corners.high_hz.min(limit_hz) - corners.low_hz) * block_s;
        }
        Self::bank(&lanes, rate_hz)?;
        Ok(lanes)
    }

    /// Blocks that have [`PART_READINGS`] independent readings of shear and vibration each.
    pub(super) fn part_blocks(&self) -> u32 {
        let least = self.readings.iter().take(FIRST_OCTAVE).copied().fold(f32::INFINITY, f32::min);
        samples(1e3, PART_READINGS / least)
    }

    /// Time constants (s) of the energy of each band, `envelope_s` unless a low rate leaves too little of shear and vibration.
    pub(super) fn envelopes_s(&self, envelope_s: f32) -> [f32; BANDS] {
        core::array::from_fn(|b| {
            let readings_hz = self.readings[b] / self.block_s;
            let least_s = 0.5 * MEAN_READINGS / readings_hz;
            if b < FIRST_OCTAVE { envelope_s.max(least_s) } else { envelope_s }
        })
    }

    /// Which bands the rate carries.
    pub(super) fn carried(&self) -> [bool; BANDS] {
        self.readings.map(|readings| readings > 0.0)
    }

    pub(super) fn bank(&self, rate_hz: f32) -> Result<FilterBank<LANES>, ConfigError> {
        Ok(FilterBank::new(&padded(self.corners, self.corners[0]), rate_hz)?)
    }
}

/// Whether a rate carries a band: a sliver of it below the highest corner shows nothing.
fn fits(band: &Band, rate_hz: f32) -> bool {
    band.low_hz < 0.8 * MAX_CORNER * rate_hz
}

impl DetectorConfig {
    /// The bands as samples at `rate_hz` carry them: shear and vibration, the first two, lowered where they do not fit; `None` for an octave
    /// that does not.
    ///
    /// # Errors
    /// Where a corner is no frequency.
    pub fn bands_at(&self, rate_hz: f32) -> Result<[Option<Band>; BANDS], ConfigError> {
        let lanes = Lanes::new(self, rate_hz)?;
        Ok(core::array::from_fn(|b| {
            let Band { low_hz, high_hz } = lanes.corners[b];
            let high_hz = high_hz.min(MAX_CORNER * rate_hz);
            lanes.carried()[b].then_some(Band { low_hz, high_hz })
        }))
    }

    /// Independent readings of each band in a block of samples at `rate_hz`, 0 where the rate does not carry it; and the
    /// length of a block (s).
    ///
    /// # Errors
    /// Where a corner is no frequency.
    pub fn readings_at(&self, rate_hz: f32) -> Result<([f32; BANDS], f32), ConfigError> {
        Lanes::new(self, rate_hz).map(|lanes| (lanes.readings, lanes.block_s))
    }

    /// Whether `rate_hz` carries the shear band, which begins where the motion of hands and robots ends.
    #[must_use]
    pub fn reaches_above_motion(&self, rate_hz: f32) -> bool {
        self.bands().first().is_some_and(|shear| fits(shear, rate_hz))
    }
}

/// One value for each filter: those of the bands, and `rest` for filters without one.
#[inline]
pub(super) fn padded<T: Copy>(bands: [T; BANDS], rest: T) -> [T; LANES] {
    core::array::from_fn(|lane| bands.get(lane).copied().unwrap_or(rest))
}

/// The values of the bands among those of all filters.
#[inline]
pub(super) fn of_bands(lanes: &[f32; LANES]) -> [f32; BANDS] {
    core::array::from_fn(|band| lanes[band])
}

/// Samples in `ms` milliseconds, at least one.
pub(super) fn samples(ms: f32, rate_hz: f32) -> u32 {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "clamped; the cast saturates"
    )]
    let n = libm::ceilf(1e-3 * ms * rate_hz).clamp(1.0, 1e9) as u32;
    n
}

// The block of readings that is being filled.

/// Longest block: half a millisecond at 50 kHz.
pub(super) const MOST: usize = 25;

/// Readings of stylus and motion reference, side by side, oldest first.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pending {
    stylus: [f32; MOST],
    reference: [f32; MOST],
    len: usize,
}

impl Default for Pending {
    fn default() -> Self {
        Self { stylus: [0.0; MOST], reference: [0.0; MOST], len: 0 }
    }
}

impl Pending {
    /// Appends the next reading of the stylus and of the reference (off its mean); gives the new length. What does not
    /// fit is left out, which a block of at most [`MOST`] readings never meets.
    #[inline]
    pub(super) fn push(&mut self, stylus: f32, reference: f32) -> usize {
        if let (Some(x), Some(u)) =
            (self.stylus.get_mut(self.len), self.reference.get_mut(self.len))
        {
            (*x, *u) = (stylus, reference);
            self.len += 1;
        }
        self.len
    }

    /// The readings of the stylus.
    #[inline]
    pub(super) fn stylus(&self) -> &[f32] {
        self.stylus.get(..self.len).unwrap_or(&[])
    }

    /// The readings of the reference.
    #[inline]
    pub(super) fn reference(&self) -> &[f32] {
        self.reference.get(..self.len).unwrap_or(&[])
    }

    /// Begins another block.
    #[inline]
    pub(super) fn clear(&mut self) {
        self.len = 0;
    }
}

// Filter bank of the stylus: band signals of its readings, from a start that is not a step.

/// Time whose mean becomes the zero of the filters (ms): one reading alone would turn its noise into a step.
const PRIME_MS: f32 = 2.0;

/// The filter bank of the detector with its start.
#[derive(Clone, Copy, Debug)]
pub(super) struct PrimedBank {
    bank: FilterBank<LANES>,
    len: u32,
    left: u32,
    sum: f32,
    first: f32,
    offset: f32,
}

impl PrimedBank {
    pub(super) fn new(lanes: &Lanes, rate_hz: f32) -> Result<Self, ConfigError> {
        let len = samples(PRIME_MS, rate_hz);
        Ok(Self { bank: lanes.bank(rate_hz)?, len, left: len, sum: 0.0, first: 0.0, offset: 0.0 })
    }

    /// Starts afresh with the next readings.
    pub(super) fn start(&mut self) {
        self.left = self.len;
    }

    /// Whether the start lasts: the next reading belongs to it.
    #[inline]
    pub(super) fn is_starting(&self) -> bool {
        self.left > 0
    }

    /// The band signals of the next reading (finite); `None` while the start lasts.
    #[inline]
    pub(super) fn step(&mut self, x: f32) -> Option<[f32; LANES]> {
        if self.is_starting() {
            self.start_with(x);
            return None;
        }
        Some(self.bank.step(x - self.offset))
    }

    /// Runs the bands over a block that is no part of the start: the sum of squares of each band signal times its `scale`.
    #[inline]
    pub(super) fn energy(&mut self, block: &Pending, scale: &[f32; LANES]) -> [f32; LANES] {
        self.energy_of(block.stylus(), scale)
    }

    /// [`PrimedBank::energy`] of these readings.
    #[inline]
    pub(super) fn energy_of(&mut self, readings: &[f32], scale: &[f32; LANES]) -> [f32; LANES] {
        self.bank.energy(readings, self.offset, scale)
    }

    /// Keeps the states clear of subnormal numbers, where single readings are taken.
    #[inline]
    pub(super) fn flush_tiny(&mut self) {
        self.bank.flush_tiny();
    }

    /// Takes a reading (finite) of the start.
    #[cold]
    pub(super) fn start_with(&mut self, x: f32) {
        if self.left == self.len {
            self.first = x;
            self.sum = 0.0;
        }
        // Summed about the first reading, so that a large offset costs no digits.
        self.sum += x - self.first;
        self.left -= 1;
        if self.left == 0 {
            let mean = self.sum / self.len as f32;
            self.offset = self.first + mean;
            self.bank.prime(0.0);
        }
    }
}

// The further axes of a vibration sensor and of a motion reference: what their bands add to those of the first axis.

type Values = [f32; FURTHER_AXES];

/// Readings of the further axes in the block that is being filled, oldest first.
#[derive(Clone, Copy, Debug)]
struct Block {
    readings: [[f32; MOST]; FURTHER_AXES],
    len: usize,
}

impl Block {
    const EMPTY: Self = Self { readings: [[0.0; MOST]; FURTHER_AXES], len: 0 };

    fn push(&mut self, values: Values) {
        for (axis, value) in self.readings.iter_mut().zip(values) {
            if let Some(place) = axis.get_mut(self.len) {
                *place = value;
            }
        }
        self.len = (self.len + 1).min(MOST);
    }

    fn axes(&self) -> impl Iterator<Item = &[f32]> {
        self.readings.iter().map(|axis| axis.get(..self.len).unwrap_or(&[]))
    }
}

/// The further axes of the vibration sensor.
///
/// Each axis runs through the same filters, and the energies of a band are summed over the axes:
///
/// ```text
/// E_b = sum over axes a of sum over samples of (h_b * x_a)^2
/// ```
///
/// A filter is linear, so the band signals of an axis that is turned are the turned band signals, and the sum of their squares is the
/// same however the sensor is mounted. No single signal does that: the norm of the vector shows only what lies along its mean (for an
/// accelerometer, gravity), at twice the frequency where that is zero, and a projection is blind across its direction.
/// Floor and alarm take the sums as they take the energies of one axis. The noise of several axes varies less than that of one,
/// which the alarm does not know: it makes false alarms rarer.
///
/// An axis that never shows anything but 0 is none, and costs a comparison.
#[derive(Clone, Copy, Debug)]
pub(super) struct Axes {
    used: bool,
    next: Values,
    banks: [PrimedBank; FURTHER_AXES],
    block: Block,
    resolution: [Resolution; FURTHER_AXES],
}

impl Axes {
    pub(super) fn new(lanes: &Lanes, rate_hz: f32) -> Result<Self, ConfigError> {
        Ok(Self {
            used: false,
            next: [0.0; FURTHER_AXES],
            banks: [PrimedBank::new(lanes, rate_hz)?; FURTHER_AXES],
            block: Block::EMPTY,
            resolution: [Resolution::default(); FURTHER_AXES],
        })
    }

    /// Starts the filters afresh with the next readings.
    pub(super) fn start(&mut self) {
        self.banks.iter_mut().for_each(PrimedBank::start);
        self.block.len = 0;
    }

    /// The readings (finite) that belong to the next step.
    #[inline]
    pub(super) fn next(&mut self, values: Values) {
        if self.used || values != [0.0; FURTHER_AXES] {
            self.used = true;
            self.next = values;
        }
    }

    /// Takes the readings of this step into the block.
    #[inline]
    pub(super) fn take(&mut self) {
        if self.used {
            self.put_by();
        }
    }

    #[inline(never)]
    fn put_by(&mut self) {
        let mut starting = false;
        for (bank, value) in self.banks.iter_mut().zip(self.next) {
            if bank.is_starting() {
                bank.start_with(value);
                starting = true;
            }
        }
        if !starting {
            self.block.push(self.next);
        }
    }

    /// Runs the bands over the block and ends it: adds the sum of squares of each band signal times its `scale`.
    #[inline]
    pub(super) fn add_energy(&mut self, sums: &mut [f32; LANES], scale: &[f32; LANES]) {
        if !self.used {
            return;
        }
        for (bank, readings) in self.banks.iter_mut().zip(self.block.axes()) {
            for (sum, energy) in sums.iter_mut().zip(bank.energy_of(readings, scale)) {
                *sum += energy;
            }
        }
        self.block.len = 0;
    }

    /// The noise that rounding makes (rms) over all axes, where that of the first is `rms`. Asked at the end of each
    /// block while the floor is learned.
    pub(super) fn resolution(&mut self, rms: f32) -> f32 {
        if !self.used {
            return rms;
        }
        for (resolution, x) in self.resolution.iter_mut().zip(self.next) {
            resolution.push(x);
        }
        self.resolution.iter().fold(rms, |all, axis| libm::hypotf(all, axis.rms()))
    }
}

/// The further axes of the motion reference.
#[derive(Clone, Copy, Debug)]
pub(super) struct ReferenceAxes {
    used: bool,
    next: Values,
    changed: bool,
    mean: Option<Values>,
    slow: Values,
    banks: [FilterBank<LANES>; FURTHER_AXES],
    block: Block,
}

impl ReferenceAxes {
    pub(super) fn new(lanes: &Lanes, rate_hz: f32) -> Result<Self, ConfigError> {
        Ok(Self {
            used: false,
            next: [0.0; FURTHER_AXES],
            changed: false,
            mean: None,
            slow: [0.0; FURTHER_AXES],
            banks: [lanes.bank(rate_hz)?; FURTHER_AXES],
            block: Block::EMPTY,
        })
    }

    /// The readings (finite) that belong to the next step.
    #[inline]
    pub(super) fn next(&mut self, values: Values) {
        if self.used || values != [0.0; FURTHER_AXES] {
            self.used = true;
            self.changed = values != self.next;
            self.next = values;
        }
    }

    /// Whether a reading of this step differs from the one before.
    #[inline]
    pub(super) fn has_changed(&self) -> bool {
        self.changed
    }

    /// Adds the energy of the distance from the mean, and of the mean of that, with the weights of both means.
    #[inline]
    pub(super) fn add_distance(&mut self, energy: &mut [f32; 2], mean_share: f32, slow_share: f32) {
        if !self.used {
            return;
        }
        let mut mean = self.mean.unwrap_or(self.next);
        for ((x, mean), slow) in self.next.iter().zip(&mut mean).zip(&mut self.slow) {
            let distance = x - *mean;
            *mean += mean_share * distance;
            *slow += slow_share * (distance - *slow);
            energy[0] += distance * distance;
            energy[1] += *slow * *slow;
        }
        self.mean = Some(mean);
    }

    /// Takes the readings of this step, off their means, into the block; the means themselves where they are not `live`.
    #[inline]
    pub(super) fn put_by(&mut self, live: bool) {
        if self.used {
            let mean = self.mean.filter(|_| live).unwrap_or(self.next);
            self.block.push(core::array::from_fn(|axis| self.next[axis] - mean[axis]));
        }
    }

    /// Runs the bands over the block and ends it: adds the sum of squares of each band signal (unit squared).
    #[inline]
    pub(super) fn add_energy(&mut self, sums: &mut [f32; LANES]) {
        if !self.used {
            return;
        }
        for (bank, readings) in self.banks.iter_mut().zip(self.block.axes()) {
            for (sum, energy) in sums.iter_mut().zip(bank.energy(readings, 0.0, &[1.0; LANES])) {
                *sum += energy;
            }
        }
        self.end_block();
    }

    #[inline]
    pub(super) fn end_block(&mut self) {
        self.block.len = 0;
    }

    /// Starts the bands as if the reference had always been at its mean.
    pub(super) fn start(&mut self) {
        self.banks.iter_mut().for_each(|bank| bank.prime(0.0));
        self.end_block();
    }

    /// The means begin with the next reading.
    pub(super) fn restart(&mut self) {
        self.mean = None;
        self.slow = [0.0; FURTHER_AXES];
        self.start();
    }
}

#[cfg(test)]
mod tests {
    use super::{BANDS, DetectorConfig};

    #[test]
    fn a_rate_carries_the_bands_that_the_detector_uses() {
        let config = DetectorConfig::default();
        let carried = |rate_hz| config.bands_at(rate_hz).unwrap();
        assert_eq!(carried(10_000.0), config.bands().map(Some));
        // The shear band fits, and so does a part of the octaves.
        let at_200 = carried(200.0);
        assert_eq!(at_200[0].map(|band| (band.low_hz, band.high_hz)), Some((20.0, 80.0)));
        assert!(at_200[BANDS - 1].is_none() && config.reaches_above_motion(200.0));
        let at_40 = carried(40.0);
        assert_eq!(at_40.map(|band| band.is_some()), [true, true, false, false, false, false]);
        assert_eq!(at_40[0].map(|band| (band.low_hz, band.high_hz)), Some((4.0, 16.0)));
        assert!(!config.reaches_above_motion(40.0));
        assert!(config.bands_at(f32::NAN).is_err());
    }
}
