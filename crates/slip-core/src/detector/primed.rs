//! Stylus readings in, band signals out, from a start that is not a step.

use super::{
    lanes::{LANES, Lanes, samples},
    pending::Pending,
};
use crate::{error::ConfigError, filter::FilterBank};

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
            #[expect(clippy::cast_precision_loss, reason = "at most 100 samples")]
            let mean = self.sum / self.len as f32;
            self.offset = self.first + mean;
            self.bank.prime(0.0);
        }
    }
}
