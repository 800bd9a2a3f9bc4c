//! The bands of a configuration at a sample rate: which of them exist, their filters and how much they can tell.

use super::{
    config::{BANDS, BandThreshold, DetectorConfig, FIRST_OCTAVE},
    pending::MOST,
};
use crate::{
    error::ConfigError,
    filter::{Band, FilterBank, MAX_CORNER},
};

/// Filters that run for the [`BANDS`]: a whole number of vectors where the processor has them. Those without a band have a part in
/// nothing.
pub(super) const LANES: usize =
    if cfg!(any(target_arch = "x86_64", target_arch = "aarch64")) { 8 } else { BANDS };

/// Length of a block (s): the tests decide this often, at low sample rates with every sample.
const BLOCK_S: f32 = 5e-4;

/// Lower corner of a shear or vibration band that had to be lowered, over the highest corner that the sample rate can carry.
const LOWERED: f32 = 0.25;

/// Independent readings in the mean energy of shear and vibration, twice the time constant long: the mean of fewer reaches the
/// thresholds by itself.
const MEAN_READINGS: f32 = 6.0;
/// Independent readings in a part of the noise floor: the median of parts with fewer lies far below their mean.
const PART_READINGS: f32 = 4.0;

/// What all parts of the detector have to know of the bands.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lanes {
    /// Corners. An octave that the rate cannot carry has no part in any decision; the shear and the vibration band are lowered.
    pub(super) corners: [Band; BANDS],
    /// Thresholds of the energy; infinite where the band does not exist.
    pub(super) thresholds: [f32; BANDS],
    /// Samples in a block, 1 to [`MOST`].
    pub(super) block_len: usize,
    /// Length of a block (s).
    pub(super) block_s: f32,
    /// Independent readings of each band in a block: twice its width times its length.
    pub(super) readings: [f32; BANDS],
    /// Whether the rate carries the shear band, which begins where the motion of hands and robots ends.
    pub(super) above_motion: bool,
}

impl Lanes {
    /// # Errors
    /// Where a corner is no frequency; [`PipelineConfig::check`](crate::PipelineConfig::check) refuses more.
    pub(super) fn new(config: &DetectorConfig, rate_hz: f32) -> Result<Self, ConfigError> {
        let limit_hz = MAX_CORNER * rate_hz;
        let bands = config.bands();
        // A sliver of a band below the limit would tell nothing.
        let fits = |band: &BandThreshold| band.low_hz < 0.8 * limit_hz;
        let block_len = (samples(1e3 * BLOCK_S * 0.999, rate_hz) as usize).min(MOST);
        #[expect(clippy::cast_precision_loss, reason = "at most 25 samples")]
        let block_s = block_len as f32 / rate_hz;
        let mut lanes = Self {
            corners: [Band { low_hz: LOWERED * limit_hz, high_hz: limit_hz }; BANDS],
            thresholds: [f32::INFINITY; BANDS],
            block_len,
            block_s,
            readings: [0.0; BANDS],
            above_motion: bands.first().is_some_and(fits),
        };
        for (b, band) in bands.iter().enumerate() {
            let corners = if fits(band) {
                Band { low_hz: band.low_hz, high_hz: band.high_hz }
            } else if b < FIRST_OCTAVE {
                Band { low_hz: LOWERED * limit_hz, high_hz: limit_hz }
            } else {
                continue;
            };
            lanes.corners[b] = corners;
            lanes.thresholds[b] = band.threshold;
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

    pub(super) fn bank(&self, rate_hz: f32) -> Result<FilterBank<LANES>, ConfigError> {
        Ok(FilterBank::new(&padded(self.corners, self.corners[0]), rate_hz)?)
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
