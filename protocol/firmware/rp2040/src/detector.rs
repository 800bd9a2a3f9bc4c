//! Slip detector of the board: changes of the slip state from readings of a sensor.

use crate::sensor::Sensor;
use slip_core::{
    ConfigError, Pipeline, PipelineConfig, Sample, Signal, SlipReport,
    units::{Hertz, Micros},
};

/// Code of the middle of the supply, where the two resistors put the piezo.
pub const MIDDLE: i16 = 2048;

/// The pipeline of the host, observing a vibration without a unit: no network, no controller.
#[derive(Debug)]
pub struct Detector {
    pipeline: Pipeline<[f32; 0]>,
    sensor: &'static Sensor,
    sum: i16,
    summed: u16,
    /// Number of the reading that follows the last one.
    next: u64,
}

impl Detector {
    /// # Errors
    /// None that this rate has; the pipeline checks every configuration.
    pub fn new(sensor: &'static Sensor) -> Result<Self, ConfigError> {
        let rate = Hertz((sensor.rate_hz / u32::from(sensor.readings_a_sample)) as f32);
        let config = PipelineConfig::observing(Signal::Vibration, rate);
        Ok(Self { pipeline: Pipeline::new(config, None)?, sensor, sum: 0, summed: 0, next: 0 })
    }

    /// Takes reading number `index` (steps, at most 13 bits with the sign); the sample that it completes, if any. No sample
    /// spans lost readings.
    #[inline]
    pub fn reading(&mut self, index: u64, value: i16) -> Option<Sample> {
        if index != self.next {
            (self.sum, self.summed) = (0, 0);
        }
        self.next = index + 1;
        self.sum = self.sum.saturating_add(value);
        self.summed += 1;
        if self.summed < self.sensor.readings_a_sample {
            return None;
        }
        let mean = f32::from(self.sum) * (1.0 / f32::from(self.sensor.readings_a_sample));
        (self.sum, self.summed) = (0, 0);
        Some(Sample::stylus(Micros(self.sensor.time_us(index)), mean))
    }

    /// Takes a sample; what it changed of the slip state.
    #[inline]
    pub fn sample(&mut self, sample: &Sample) -> Option<SlipReport> {
        self.pipeline.handle(sample).event
    }
}

/// The code about the middle of the supply.
#[must_use]
pub const fn centred(code: u16) -> i16 {
    (code & 0x0FFF) as i16 - MIDDLE
}
