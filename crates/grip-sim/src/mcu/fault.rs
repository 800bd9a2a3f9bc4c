//! Model of broken sensors: the sample that they show.

use crate::random::{self, Purpose};
use crate::scene::{NoiseConfig, Scene};
use rand_chacha::ChaCha8Rng;
use slip_core::sample::Sample;
use slip_core::units::Micros;
use std::collections::VecDeque;

/// End of the stylus's range (m).
pub(super) const RANGE_M: f32 = 1e-3;
/// Noise of a noisy sensor over that of the scene.
const NOISE_RATIO: f64 = 30.0;

/// A sensor that may fail.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sensor {
    /// Displacement of the stylus (m).
    Stylus,
    /// Normal force of a finger (N).
    NormalForce,
    /// Moved distance of the object (m).
    Travel,
    /// Tangential force of a finger (N).
    TangentialForce,
    /// Displacement of the second stylus (m).
    SecondStylus,
}

impl Sensor {
    /// Every sensor, in the order of their places.
    pub const ALL: [Self; 5] =
        [Self::Stylus, Self::NormalForce, Self::Travel, Self::TangentialForce, Self::SecondStylus];

    /// Its reading in `sample`; `None` where the gripper has no such sensor.
    fn reading(self, sample: &mut Sample) -> Option<&mut f32> {
        match self {
            Self::Stylus => Some(&mut sample.stylus),
            Self::NormalForce => sample.normal_force_n.as_mut(),
            Self::Travel => sample.travel_m.as_mut(),
            Self::TangentialForce => sample.tangential_n.as_mut(),
            Self::SecondStylus => sample.second_stylus.as_mut(),
        }
    }

    /// Noise (rms, SI) of the sensor in a scene; that of the default scene where this one has none.
    fn noise_rms(self, noise: &NoiseConfig) -> f64 {
        let of = |noise: &NoiseConfig| match self {
            Self::Stylus | Self::SecondStylus => 1e-6 * noise.stylus_um,
            Self::NormalForce => 1e-3 * noise.force_mn,
            Self::Travel => 1e-6 * noise.travel_um,
            Self::TangentialForce => 1e-3 * noise.tangential_mn,
        };
        let own = of(noise);
        if own > 0.0 { own } else { of(&NoiseConfig::default()) }
    }
}

/// How a sensor may fail.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SensorFault {
    /// No reading: NaN.
    Dead,
    /// Positive infinity.
    Infinite,
    /// The last reading before the fault is repeated.
    Stuck,
    /// White noise of 30 times the rms of the scene on top.
    Noise,
    /// The reading of that much earlier; time stamps stay right.
    Late(Micros),
    /// The reading is wrong by this share (%).
    Gain(i8),
    /// The reading stays at 0.2 mm (0.2e-3 in its unit).
    Frozen,
    /// The reading stays at 1.1 mm, beyond the end of the stylus's range.
    Saturated,
}

/// The faults in force, and what they need to know of the past.
#[derive(Clone, Debug)]
pub(super) struct SensorFaults {
    faults: [Option<SensorFault>; Sensor::ALL.len()],
    noise_rms: [f64; Sensor::ALL.len()],
    travel_step_m: f64,
    rng: ChaCha8Rng,
    /// The last sample before each fault.
    stuck: [Sample; Sensor::ALL.len()],
    last: Sample,
    /// True samples of the last `memory`, the oldest first.
    history: VecDeque<Sample>,
    memory: Micros,
}

impl SensorFaults {
    /// No fault.
    pub(super) fn new(scene: &Scene) -> Self {
        let config = scene.config();
        let nothing = Sample::stylus(Micros(0), 0.0);
        Self {
            faults: [None; Sensor::ALL.len()],
            noise_rms: Sensor::ALL.map(|sensor| sensor.noise_rms(&config.noise)),
            travel_step_m: 1e-6 * config.noise.travel_step_um,
            rng: random::stream(config.seed, Purpose::SensorFault),
            stuck: [nothing; Sensor::ALL.len()],
            last: nothing,
            history: VecDeque::new(),
            memory: Micros(0),
        }
    }

    /// Keeps the samples of the last `memory`, so that a reading may come late from the first sample of its fault on.
    pub(super) fn remember(&mut self, memory: Micros) {
        self.memory = Micros(self.memory.0.max(memory.0));
    }

    /// Breaks `sensor`, or repairs it with `None`.
    pub(super) fn set(&mut self, sensor: Sensor, fault: Option<SensorFault>) {
        let place = sensor as usize;
        let (Some(slot), Some(stuck)) = (self.faults.get_mut(place), self.stuck.get_mut(place))
        else {
            return;
        };
        if *slot != fault {
            *stuck = self.last;
        }
        *slot = fault;
        if let Some(SensorFault::Late(delay)) = fault {
            self.remember(delay);
        }
    }

    /// What the sensors show of `sample`.
    pub(super) fn apply(&mut self, sample: Sample) -> Sample {
        self.last = sample;
        if self.memory.0 > 0 {
            self.history.push_back(sample);
            while self.history.front().is_some_and(|old| sample.t.since(old.t).0 > self.memory.0) {
                self.history.pop_front();
            }
        }
        let mut shown = sample;
        for (sensor, place) in Sensor::ALL.into_iter().zip(0..) {
            if let Some(fault) = self.faults.get(place).copied().flatten() {
                self.falsify(sensor, fault, &mut shown);
            }
        }
        shown
    }

    fn falsify(&mut self, sensor: Sensor, fault: SensorFault, shown: &mut Sample) {
        let now = shown.t;
        let Some(reading) = sensor.reading(shown) else { return };
        let earlier = |mut sample: Sample| sensor.reading(&mut sample).map(|reading| *reading);
        *reading = match fault {
            SensorFault::Dead => f32::NAN,
            SensorFault::Infinite => f32::INFINITY,
            SensorFault::Frozen => 0.2e-3,
            SensorFault::Saturated => 1.1 * RANGE_M,
            SensorFault::Gain(percent) => *reading * (1.0 + 0.01 * f32::from(percent)),
            SensorFault::Stuck => {
                let last = self.stuck.get(sensor as usize).copied();
                last.and_then(earlier).unwrap_or(*reading)
            }
            SensorFault::Late(delay) => {
                let due = self.history.partition_point(|old| now.since(old.t).0 > delay.0);
                self.history.get(due).copied().and_then(earlier).unwrap_or(*reading)
            }
            SensorFault::Noise => {
                let rms = self.noise_rms.get(sensor as usize).copied().unwrap_or_default();
                let noisy = f64::from(*reading) + NOISE_RATIO * rms * random::normal(&mut self.rng);
                let step = self.travel_step_m;
                let travel = sensor == Sensor::Travel;
                crate::grasp::narrow(if travel { (noisy / step).round() * step } else { noisy })
            }
        };
    }
}
