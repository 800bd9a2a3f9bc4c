//! The shipped pipeline as a detector, observing only.

use grip_session::HostConfig;
use slip_core::{Phase, Pipeline, PipelineConfig, Sample, Signal, units::Hertz};
use std::path::Path;

/// The pipeline with what it has seen.
#[derive(Clone, Debug)]
pub struct Ours {
    pipeline: Pipeline<&'static [f32]>,
    slips: bool,
    statistic: f64,
}

impl Ours {
    /// At 10 kHz, with the settings of `file`, or the shipped ones.
    ///
    /// # Errors
    /// Where the file cannot be read or its settings are refused.
    pub fn configured(file: Option<&Path>) -> anyhow::Result<Self> {
        let rate = Hertz(10_000.0);
        let config = match file {
            None => PipelineConfig::observing(Signal::Displacement, rate),
            Some(file) => PipelineConfig {
                grip: None,
                ..HostConfig::read(file)?.pipeline(Signal::Displacement, rate)
            },
        };
        Ok(Self { pipeline: Pipeline::new(config, None)?, slips: false, statistic: 0.0 })
    }

    /// Takes the next sample; true while it sees a slip.
    pub fn step(&mut self, sample: &Sample) -> bool {
        let step = self.pipeline.handle(sample);
        self.statistic = f64::from(step.statistic);
        if let Some(slip) = step.event {
            self.slips = slip.phase != Phase::Ended;
        }
        self.slips
    }

    /// The statistic over its threshold.
    #[must_use]
    pub fn statistic(&self) -> f64 {
        self.statistic
    }
}
