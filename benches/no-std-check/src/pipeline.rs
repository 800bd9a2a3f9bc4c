//! Exported functions of the pipeline, from samples to steps.

use mlp_core::{Model, Network, Scaler};
use slip_core::{
    ConfigError, Pipeline, PipelineConfig, Sample, Step,
    estimate::{Estimator, EstimatorError, Feature},
};

/// Weights in flash.
type Weights = &'static [f32];

/// Joins the parts of a model.
#[unsafe(no_mangle)]
pub fn estimator_new(
    network: Network<Weights>,
    scalers: [Scaler; 2],
    features: &[Feature],
) -> Option<Result<Estimator<Weights>, EstimatorError>> {
    let [inputs, targets] = scalers;
    Some(Estimator::new(Model::new(network, inputs, targets).ok()?, features))
}

/// Checks a configuration.
#[unsafe(no_mangle)]
pub fn pipeline_new(
    config: PipelineConfig,
    estimator: Estimator<Weights>,
) -> Result<Pipeline<Weights>, ConfigError> {
    Pipeline::new(config, Some(estimator))
}

/// Handles a sample.
#[unsafe(no_mangle)]
pub fn pipeline_handle(pipeline: &mut Pipeline<Weights>, sample: &Sample) -> Step {
    pipeline.handle(sample)
}
