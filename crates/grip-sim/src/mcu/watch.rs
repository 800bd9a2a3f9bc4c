//! Monitor of the readings: the fault of a gripper without a usable slip sensor (rule R7 of the failsafe).
//!
//! The stylus is out of use while it is dead, frozen or saturated. That is a fault only where no other slip sensor is left: a second stylus
//! (judged as the first), the tangential force (not dead, not frozen) or the moved distance (not dead; at rest it repeats itself).

use super::fault::RANGE_M;
use crate::scene::{ACCELERATION_SPAN_M_S2, STYLUS_SPAN_M, Scene};
use grip_link::message::FaultCode;
use slip_core::sample::Sample;

/// No finite reading for this long is a dead sensor (s).
const DEAD_S: f64 = 5e-3;
/// The same reading, or one at the end of the range, for this long is a fault (s).
const STUCK_S: f64 = 20e-3;

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

/// Watches every slip sensor.
#[derive(Clone, Copy, Debug)]
pub(super) struct SensorWatch {
    stylus: Suspicion,
    second: Suspicion,
    tangential: Suspicion,
    travel: Suspicion,
    dead_after: f64,
    stuck_after: f64,
}

impl SensorWatch {
    pub(super) fn new(scene: &Scene) -> Self {
        let (noise, reading) = (scene.config().noise, scene.config().reading);
        let (rms, span, range) = match scene.config().vibration {
            Some(vibration) => {
                (vibration.noise_m_s2, ACCELERATION_SPAN_M_S2, ACCELERATION_SPAN_M_S2)
            }
            None => (1e-6 * noise.stylus_um, STYLUS_SPAN_M, f64::from(RANGE_M)),
        };
        // Where a step of the converter hides the noise, a sensor at rest repeats itself.
        let noisy = rms > 0.0 && rms >= reading.adc_step(span);
        #[expect(clippy::cast_possible_truncation, reason = "the end of a range")]
        let stylus = Suspicion { noisy, range: range as f32, ..Suspicion::default() };
        let rate_hz = scene.config().sample_rate_hz;
        Self {
            stylus,
            second: stylus,
            tangential: Suspicion { noisy: noise.tangential_mn > 0.0, ..Suspicion::default() },
            travel: Suspicion::default(),
            dead_after: 0.0,
            stuck_after: 0.0,
        }
        .at_rate(rate_hz)
    }

    pub(super) fn at_rate(self, rate_hz: u32) -> Self {
        let readings = |time_s: f64| (time_s * f64::from(rate_hz)).max(2.0);
        Self { dead_after: readings(DEAD_S), stuck_after: readings(STUCK_S), ..self }
    }

    /// The fault that the last readings show. `sample` has the sensors that the host asked for.
    pub(super) fn push(&mut self, sample: &Sample) -> Option<FaultCode> {
        self.stylus.push(sample.stylus);
        let others = [
            (&mut self.second, sample.second_stylus),
            (&mut self.tangential, sample.tangential_n),
            (&mut self.travel, sample.travel_m),
        ];
        let mut usable = false;
        for (sensor, reading) in others {
            if let Some(reading) = reading {
                sensor.push(reading);
                usable |= sensor.fault(self.dead_after, self.stuck_after).is_none();
            }
        }
        self.stylus.fault(self.dead_after, self.stuck_after).filter(|_| !usable)
    }
}

/// Counts suspicious readings of a sensor in a row.
#[derive(Clone, Copy, Debug)]
struct Suspicion {
    /// A sensor without noise may well repeat itself.
    noisy: bool,
    /// Readings of this size are at the end of its range.
    range: f32,
    last: f32,
    dead: u32,
    same: u32,
    saturated: u32,
}

impl Default for Suspicion {
    fn default() -> Self {
        Self { noisy: false, range: f32::INFINITY, last: f32::NAN, dead: 0, same: 0, saturated: 0 }
    }
}

impl Suspicion {
    fn push(&mut self, reading: f32) {
        let repeated = reading.to_bits() == self.last.to_bits() && reading.is_finite();
        self.last = reading;
        count(&mut self.dead, !reading.is_finite());
        count(&mut self.same, repeated && self.noisy);
        count(&mut self.saturated, reading.is_finite() && reading.abs() >= self.range);
    }

    fn fault(&self, dead_after: f64, stuck_after: f64) -> Option<FaultCode> {
        if f64::from(self.dead) >= dead_after {
            Some(FaultCode::SENSOR_DEAD)
        } else if f64::from(self.saturated) >= stuck_after {
            Some(FaultCode::SENSOR_SATURATED)
        } else if f64::from(self.same) >= stuck_after {
            Some(FaultCode::SENSOR_FROZEN)
        } else {
            None
        }
    }
}

fn count(counter: &mut u32, seen: bool) {
    *counter = if seen { counter.saturating_add(1) } else { 0 };
}

#[cfg(test)]
mod tests {
    use super::SensorWatch;
    use crate::scene;
    use grip_link::message::FaultCode;
    use slip_core::sample::Sample;
    use slip_core::units::Micros;

    /// The first fault in 0.1 s at 10 kHz of a stylus that stands still and these other readings.
    fn fault(others: fn(u64) -> Sample) -> Option<FaultCode> {
        let mut watch = SensorWatch::new(&scene::load("default").unwrap());
        (0..1000).find_map(|at| watch.push(&Sample { stylus: 0.2e-3, ..others(at) }))
    }

    fn alone(_: u64) -> Sample {
        Sample::stylus(Micros(0), 0.0)
    }

    #[test]
    fn a_stylus_out_of_use_is_a_fault_only_without_another_sensor() {
        let frozen = Some(FaultCode::SENSOR_FROZEN);
        assert_eq!(fault(alone), frozen);
        assert_eq!(fault(|_| Sample { normal_force_n: Some(1.0), ..alone(0) }), frozen);
        // A travel sensor at rest repeats itself, a force or a stylus with noise does not.
        assert_eq!(fault(|_| Sample { travel_m: Some(0.0), ..alone(0) }), None);
        assert_eq!(fault(|_| Sample { tangential_n: Some(1.0), ..alone(0) }), frozen);
        assert_eq!(fault(|at| Sample { tangential_n: Some(at as f32), ..alone(0) }), None);
        assert_eq!(fault(|_| Sample { second_stylus: Some(1e-4), ..alone(0) }), frozen);
        assert_eq!(fault(|at| Sample { second_stylus: Some(1e-9 * at as f32), ..alone(0) }), None);
        assert_eq!(fault(|_| Sample { second_stylus: Some(2e-3), ..alone(0) }), frozen);
    }

    #[test]
    fn the_last_sensor_that_dies_makes_the_fault() {
        for last in [f32::NAN, f32::INFINITY] {
            let mut watch = SensorWatch::new(&scene::load("default").unwrap());
            let sample = |travel_m: f32| Sample {
                travel_m: Some(travel_m),
                ..Sample::stylus(Micros(0), f32::INFINITY)
            };
            assert!((0..1000).all(|_| watch.push(&sample(1e-6)).is_none()));
            // Single readings that are missing are no dead sensor.
            assert!((0..49).all(|_| watch.push(&sample(last)).is_none()));
            assert!(watch.push(&sample(1e-6)).is_none());
            let after = (1..100).find(|_| watch.push(&sample(last)).is_some());
            assert_eq!(after, Some(50), "5 ms of 10 kHz");
        }
    }
}
