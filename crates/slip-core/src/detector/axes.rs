//! The further axes of a vibration sensor and of a motion reference in, what their bands add to those of the first axis out.
//!
//! Each axis runs through the same filters, and the energies of a band are summed over the axes:
//!
//! ```text
//! E_b = sum over axes a of sum over samples of (h_b * x_a)^2
//! ```
//!
//! A filter is linear, so the band signals of an axis that is turned are the turned band signals, and the sum of their squares is the
//! same however the sensor is mounted. No single signal does that: the norm of the vector shows only what lies along its mean (for an
//! accelerometer, gravity), at twice the frequency where that is zero, and a projection is blind across its direction.
//! Floor, thresholds and tests take the sums as they take the energies of one axis. The noise of several axes varies less than that of one,
//! which the tests do not know: it makes false alarms rarer.
//!
//! An axis that never shows anything but 0 is none, and costs a comparison.

use super::{
    lanes::{LANES, Lanes},
    pending::MOST,
    primed::PrimedBank,
};
use crate::{error::ConfigError, filter::FilterBank, resolution::Resolution, sample::FURTHER_AXES};

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
