//! Codes of the converter in, changes of the slip state out.

use slip_core::{
    ConfigError, Pipeline, PipelineConfig, Sample, Signal, SlipReport,
    units::{Hertz, Micros},
};

/// Readings of the converter a second (Hz).
pub const RATE_HZ: u32 = 10_000;
/// Time from one reading to the next (us).
pub const PERIOD_US: u64 = 1_000_000 / RATE_HZ as u64;
/// Code of the middle of the supply, where the two resistors put the piezo.
pub const MIDDLE: i16 = 2048;
/// Readings whose mean is a sample of the detector: a core without a unit for floats has no time for each of them.
pub const READINGS_A_SAMPLE: u16 = 8;

/// The pipeline of the host, observing a vibration without a unit: no network, no controller.
#[derive(Debug)]
pub struct Detector {
    pipeline: Pipeline<[f32; 0]>,
    sum: i16,
    summed: u16,
}

impl Detector {
    /// # Errors
    /// None that this rate has; the pipeline checks every configuration.
    pub fn new() -> Result<Self, ConfigError> {
        let rate = Hertz((RATE_HZ / u32::from(READINGS_A_SAMPLE)) as f32);
        let config = PipelineConfig::observing(Signal::Vibration, rate);
        Ok(Self { pipeline: Pipeline::new(config, None)?, sum: 0, summed: 0 })
    }

    /// Takes reading number `index` (12 bits); the sample that it completes, if any.
    #[inline]
    pub fn reading(&mut self, index: u64, code: u16) -> Option<Sample> {
        self.sum += centred(code);
        self.summed += 1;
        if self.summed < READINGS_A_SAMPLE {
            return None;
        }
        let mean = f32::from(self.sum) * (1.0 / READINGS_A_SAMPLE as f32);
        (self.sum, self.summed) = (0, 0);
        Some(Sample::stylus(Micros(index * PERIOD_US), mean))
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
