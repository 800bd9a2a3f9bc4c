//! Stylus readings in, band signals out, from a start that is not a step.

use super::{BANDS, DetectorConfig};
use crate::{
    config::ConfigError,
    filter::{Band, FilterBank},
};

/// Time whose mean becomes the zero of the filters (ms): one reading alone would turn its noise into a step.
const PRIME_MS: f32 = 2.0;

/// The filter bank of the detector with its start.
#[derive(Clone, Copy, Debug)]
pub(super) struct PrimedBank {
    bank: FilterBank<BANDS>,
    len: u32,
    left: u32,
    sum: f32,
    first: f32,
    offset: f32,
}

impl PrimedBank {
    pub(super) fn new(config: &DetectorConfig, rate_hz: f32) -> Result<Self, ConfigError> {
        let corners = [config.shear, config.vibration]
            .map(|band| Band { low_hz: band.low_hz, high_hz: band.high_hz });
        let len = samples(PRIME_MS, rate_hz);
        let bank = FilterBank::new(&corners, rate_hz)?;
        Ok(Self { bank, len, left: len, sum: 0.0, first: 0.0, offset: 0.0 })
    }

    /// Starts afresh with the next readings.
    pub(super) fn start(&mut self) {
        self.left = self.len;
    }

    /// The band signals of the next reading (finite); `None` while the start lasts.
    #[inline]
    pub(super) fn step(&mut self, x: f32) -> Option<[f32; BANDS]> {
        if self.left > 0 {
            self.prime(x);
            return None;
        }
        Some(self.bank.step(x - self.offset))
    }

    #[cold]
    fn prime(&mut self, x: f32) {
        if self.left == self.len {
            self.first = x;
            self.sum = 0.0;
        }
        // Summed about the first reading, so that a large offset costs no digits.
        self.sum += x - self.first;
        self.left -= 1;
        if self.left == 0 {
            #[expect(clippy::cast_precision_loss, reason = "at most 100 samples")]
            let mean = self.sum / self.len as f32;
            self.offset = self.first + mean;
            self.bank.prime(0.0);
        }
    }
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
