//! Estimate of one property from its measurements: its value with its uncertainty.

use serde::{Deserialize, Serialize};

/// Deviation of a single measurement, relative, before there are several to show it; it is never less than half of that.
const SINGLE: f64 = 0.1;
/// Measurements that count: of what lies further back less and less is left, because objects change.
const MOST: u32 = 20;

/// A figure above this (N, um) is none.
const MOST_VALUE: f64 = 5000.0;

/// A property that was measured several times: mean and spread of its logarithm.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Figure {
    /// Geometric mean, in the unit of the property; 0 where it was never measured.
    pub value: f64,
    /// Relative standard deviation of one measurement.
    pub deviation: f64,
    /// Measurements.
    pub grasps: u32,
}

impl Figure {
    /// Whether it was never measured.
    #[must_use]
    pub fn is_unknown(&self) -> bool {
        self.grasps == 0
    }

    /// With another measurement, which is above 0.
    #[must_use]
    pub(super) fn with(self, value: f64) -> Self {
        if self.is_unknown() {
            return Self { value, deviation: SINGLE, grasps: 1 };
        }
        let count = f64::from(self.grasps.min(MOST - 1));
        let step = (value / self.value).ln();
        let share = 1.0 / (count + 1.0);
        // The first deviation is a guess and counts as one measurement.
        let variance = (1.0 - share) * (self.deviation.powi(2) + share * step * step);
        Self {
            value: self.value * (share * step).exp(),
            deviation: variance.sqrt().max(0.5 * SINGLE),
            grasps: self.grasps.saturating_add(1),
        }
    }

    /// Relative standard deviation of the mean.
    #[must_use]
    pub fn uncertainty(&self) -> f64 {
        self.deviation / f64::from(self.grasps.clamp(1, MOST)).sqrt()
    }

    /// By how many standard deviations another measurement differs; `None` where nothing is known.
    #[must_use]
    pub(super) fn deviations(&self, value: f64) -> Option<f64> {
        let sigma = self.deviation.max(SINGLE).hypot(self.uncertainty());
        (!self.is_unknown()).then(|| (value / self.value).ln().abs() / sigma)
    }

    /// Whether it can be what a file states: a positive value with a deviation, or nothing.
    pub(super) fn is_possible(&self) -> bool {
        let within = |value: f64, most: f64| value.is_finite() && value > 0.0 && value <= most;
        self.is_unknown() && self.value == 0.0
            || within(self.value, MOST_VALUE) && within(self.deviation, 10.0) && self.grasps > 0
    }
}
