//! Clock of a sample rate, with time stamps that do not drift.

use slip_core::units::Micros;

/// Counts samples; the end of each period is rounded to microseconds without drift.
#[derive(Clone, Copy, Debug)]
pub(super) struct SampleClock {
    since: Micros,
    samples: u64,
    rate_hz: u32,
}

impl SampleClock {
    /// Time zero.
    pub(super) fn new(rate_hz: u32) -> Self {
        Self { since: Micros(0), samples: 0, rate_hz }
    }

    /// Goes on from here at another rate.
    pub(super) fn at_rate(self, rate_hz: u32) -> Self {
        Self { since: self.last(), samples: 0, rate_hz }
    }

    /// One more sample.
    pub(super) fn count(&mut self) {
        self.samples += 1;
    }

    /// Samples a second.
    pub(super) fn rate_hz(&self) -> u32 {
        self.rate_hz
    }

    pub(super) fn last(&self) -> Micros {
        self.ahead(0)
    }

    pub(super) fn ahead(&self, more: u64) -> Micros {
        let rate = u64::from(self.rate_hz);
        let samples = self.samples + more;
        let (seconds, rest) = (samples / rate, samples % rate);
        self.since.plus(Micros(seconds * 1_000_000 + (rest * 1_000_000 + rate / 2) / rate))
    }
}
