//! Pipelines in the middle of a scene, with samples that keep them there.

use crate::signals::{RATE_HZ, Signals};
use anyhow::{Result, bail};
use grip_session::model;
use slip_core::{
    Pipeline, PipelineConfig, Sample,
    detector::{BANDS, Certificate, ScoreLaw},
    sample::Scene,
    units::Hertz,
};

/// The pipeline of a host.
pub type HostPipeline = Pipeline<std::sync::Arc<[f32]>>;

/// Samples of a measured stretch: one second.
pub const STRETCH: usize = 10_000;
/// Samples in which the noise floor is learned, and some more.
const LEARN: usize = 2_100;
/// Samples in which the fingers close and settle, and some more.
const CLOSE: usize = 3_000;
/// Samples after which a new slip or contact has become steady.
const SETTLE: usize = 1_000;

const HELD_N: f64 = 3.0;
/// Below the force that counts as contact.
const OPEN_N: f64 = 0.0;
const SLIP_M_S: f64 = 0.05;

/// Every scene, cheapest first.
pub const SCENES: [Scene; 4] = [Scene::Idle, Scene::Moving, Scene::Holding, Scene::Slipping];

/// A pipeline in the middle of a scene.
#[derive(Clone, Debug)]
pub struct SceneRun {
    /// The pipeline, about to handle the first of `samples`.
    pub pipeline: HostPipeline,
    /// One second during which the scene does not change.
    pub samples: Vec<Sample>,
}

impl SceneRun {
    /// A gripper with floor learned, in the middle of `scene`; `no_skip` runs every stage.
    ///
    /// # Errors
    /// Where the pipeline cannot be made or does not stay in the scene.
    pub fn new(scene: Scene, no_skip: bool) -> Result<Self> {
        Self::with(pipeline(no_skip)?, scene, |sample| sample)
    }

    /// A gripper that certifies slips as well, in the middle of `scene`.
    ///
    /// # Errors
    /// As [`SceneRun::new`].
    pub fn certifying(scene: Scene) -> Result<Self> {
        let mut learns = pipeline(false)?;
        for sample in Signals::new(1).stretch(LEARN, OPEN_N, 0.0) {
            learns.handle(&sample);
        }
        let law = |moving: u8| ScoreLaw {
            blocks: [2, 1, 8, 4, 2, 1],
            limits: [core::array::from_fn(|j| f32::from(4 + moving) * (1.0 + j as f32)); BANDS],
            chances: [core::array::from_fn(|j| libm::exp2f(-2.0 * (2.0 + j as f32))); BANDS],
        };
        let (rest, motion) = (Some(law(0)), Some(law(1)));
        let config = PipelineConfig {
            known_floor: learns.detector().floor(),
            certificate: Some(Certificate { interval_s: 600.0, rest, motion }),
            ..PipelineConfig::gripping(Hertz(RATE_HZ))
        };
        let pipeline = Pipeline::new(config, Some(model::default_estimator()?))?;
        Self::with(pipeline, scene, |sample| sample)
    }

    /// A slip in which the stylus is the only sensor that reports movement.
    ///
    /// # Errors
    /// As [`SceneRun::new`].
    pub fn stylus_alone() -> Result<Self> {
        Self::with(pipeline(false)?, Scene::Slipping, |sample| Sample { travel_m: None, ..sample })
    }

    fn with(
        mut pipeline: HostPipeline,
        scene: Scene,
        seen: impl Fn(Sample) -> Sample,
    ) -> Result<Self> {
        let mut signals = Signals::new(1);
        let mut before = signals.stretch(LEARN, OPEN_N, 0.0);
        if scene != Scene::Moving {
            before.extend(signals.stretch(CLOSE, HELD_N, 0.0));
        }
        let (force_n, speed_m_s) = match scene {
            Scene::Idle | Scene::Moving => (OPEN_N, 0.0),
            Scene::Holding => (HELD_N, 0.0),
            Scene::Slipping | Scene::Other(_) => (HELD_N, SLIP_M_S),
        };
        before.extend(signals.stretch(SETTLE, force_n, speed_m_s));
        for sample in before {
            pipeline.handle(&seen(sample));
        }
        let samples: Vec<_> =
            signals.stretch(STRETCH, force_n, speed_m_s).into_iter().map(seen).collect();
        let mut left = pipeline.clone();
        for (at, sample) in samples.iter().enumerate() {
            let seen = left.handle(sample).scene;
            if seen != scene {
                bail!(
                    "sample {at} was handled in the scene {}, not in {}",
                    seen.name(),
                    scene.name()
                );
            }
        }
        Ok(Self { pipeline, samples })
    }
}

/// A pipeline that commands the grip force, with the embedded model, before its first sample.
///
/// # Errors
/// Where settings or model are refused.
pub fn pipeline(no_skip: bool) -> Result<HostPipeline> {
    let config = PipelineConfig { no_skip, ..PipelineConfig::gripping(Hertz(RATE_HZ)) };
    Ok(Pipeline::new(config, Some(model::default_estimator()?))?)
}
