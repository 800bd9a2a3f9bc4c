//! The pipeline as a detector among others.

use super::trials::Alarm;
use slip_core::{ConfigError, Phase, Pipeline, PipelineConfig, Sample};

/// The shipped pipeline, observing only.
#[derive(Clone, Debug)]
pub struct Ours {
    pipeline: Pipeline<&'static [f32]>,
    slips: bool,
    statistic: f64,
}

impl Ours {
    /// # Errors
    /// Where the configuration is refused.
    pub fn new(config: PipelineConfig) -> Result<Self, ConfigError> {
        Ok(Self { pipeline: Pipeline::new(config, None)?, slips: false, statistic: 0.0 })
    }
}

impl Alarm for Ours {
    fn step(&mut self, sample: &Sample) -> bool {
        let step = self.pipeline.handle(sample);
        self.statistic = f64::from(step.statistic);
        if let Some(slip) = step.event {
            self.slips = slip.phase != Phase::Ended;
        }
        self.slips
    }

    fn statistic(&self) -> f64 {
        self.statistic
    }

    fn levels(&self) -> [f64; 7] {
        self.pipeline.detector().levels().evidence_s.map(f64::from)
    }
}
