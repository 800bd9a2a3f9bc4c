//! Stylus readings in, the fault of a dead, frozen or saturated sensor out (rule R7 of the failsafe).

use crate::scene::Scene;
use grip_link::message::FaultCode;

/// End of the stylus's range (m).
const RANGE_M: f32 = 1e-3;
/// No reading for this long is a dead sensor (s).
const DEAD_S: f64 = 5e-3;
/// The same reading, or one at the end of the range, for this long is a fault (s).
const STUCK_S: f64 = 20e-3;

/// How a stylus may fail.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SensorFault {
    /// No reading: NaN.
    Dead,
    /// The reading stays at 0.2 mm.
    Frozen,
    /// The reading stays beyond the end of its range.
    Saturated,
}

/// A task of the firmware.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Task {
    /// The force loop.
    Control,
    /// Reading and writing the port.
    Link,
    /// Reading the sensors.
    Sampling,
}

/// The reading of a stylus with `fault`.
pub(super) fn broken(fault: Option<SensorFault>, reading_m: f32) -> f32 {
    match fault {
        None => reading_m,
        Some(SensorFault::Dead) => f32::NAN,
        Some(SensorFault::Frozen) => 0.2e-3,
        Some(SensorFault::Saturated) => 1.1 * RANGE_M,
    }
}

/// Counts suspicious readings in a row.
#[derive(Clone, Copy, Debug)]
pub(super) struct SensorWatch {
    /// A sensor without noise may well repeat itself.
    noisy: bool,
    rate_hz: f64,
    last: f32,
    dead: u32,
    same: u32,
    saturated: u32,
}

impl SensorWatch {
    pub(super) fn new(scene: &Scene) -> Self {
        Self {
            noisy: scene.config().noise.stylus_um > 0.0,
            rate_hz: f64::from(scene.config().sample_rate_hz),
            last: f32::NAN,
            dead: 0,
            same: 0,
            saturated: 0,
        }
    }

    pub(super) fn at_rate(self, rate_hz: u32) -> Self {
        Self { rate_hz: f64::from(rate_hz), ..self }
    }

    /// The fault that the last readings show.
    pub(super) fn push(&mut self, reading_m: f32) -> Option<FaultCode> {
        let repeated = reading_m.to_bits() == self.last.to_bits() && !reading_m.is_nan();
        self.last = reading_m;
        count(&mut self.dead, reading_m.is_nan());
        count(&mut self.same, repeated && self.noisy);
        count(&mut self.saturated, reading_m.abs() >= RANGE_M);
        if self.lasts(self.dead, DEAD_S) {
            Some(FaultCode::SENSOR_DEAD)
        } else if self.lasts(self.saturated, STUCK_S) {
            Some(FaultCode::SENSOR_SATURATED)
        } else if self.lasts(self.same, STUCK_S) {
            Some(FaultCode::SENSOR_FROZEN)
        } else {
            None
        }
    }

    fn lasts(&self, readings: u32, time_s: f64) -> bool {
        f64::from(readings) >= (time_s * self.rate_hz).max(2.0)
    }
}

fn count(counter: &mut u32, seen: bool) {
    *counter = if seen { counter.saturating_add(1) } else { 0 };
}
