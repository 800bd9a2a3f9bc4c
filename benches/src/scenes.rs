//! A scene in; a pipeline that stands in it and samples that keep it there, or a whole grasp, out.

use crate::signals::{RATE_HZ, Signals};
use anyhow::{Result, bail};
use grip_session::model;
use slip_core::{
    Pipeline, PipelineConfig, Sample, StageCounters,
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
    /// How often each stage runs over `samples`.
    pub stages: StageCounters,
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
        let stages = stages_in(scene, pipeline.clone(), &samples)?;
        Ok(Self { pipeline, samples, stages })
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

/// Learning, closing, holding, a slip and its end, then the object taken away: every scene of a grasp.
#[must_use]
pub fn whole_grasp() -> Vec<Sample> {
    let mut signals = Signals::new(2);
    let plan = [
        (LEARN, OPEN_N, 0.0),
        (CLOSE, HELD_N, 0.0),
        (2 * SETTLE, HELD_N, SLIP_M_S),
        (2 * SETTLE, 2.0 * HELD_N, 0.0),
        (SETTLE, OPEN_N, 0.0),
    ];
    plan.into_iter()
        .flat_map(|(count, force, speed)| signals.stretch(count, force, speed))
        .collect()
}

fn stages_in(
    wanted: Scene,
    mut pipeline: HostPipeline,
    samples: &[Sample],
) -> Result<StageCounters> {
    let start = pipeline.stage_counters();
    for (at, sample) in samples.iter().enumerate() {
        let seen = pipeline.handle(sample).scene;
        if seen != wanted {
            bail!("sample {at} was handled in the scene {}, not in {}", seen.name(), wanted.name());
        }
    }
    let end = pipeline.stage_counters();
    Ok(StageCounters {
        methods: end.methods - start.methods,
        samples: end.samples - start.samples,
        bands: end.bands - start.bands,
        gate: end.gate - start.gate,
        observation: end.observation - start.observation,
        inferences: end.inferences - start.inferences,
        refused_estimates: end.refused_estimates - start.refused_estimates,
        floor_lowered: end.floor_lowered - start.floor_lowered,
    })
}

#[cfg(test)]
mod tests {
    use super::{STRETCH, SceneRun};
    use slip_core::sample::Scene;

    fn stages(scene: Scene, no_skip: bool) -> [u64; 4] {
        let stages = SceneRun::new(scene, no_skip).unwrap().stages;
        assert_eq!(stages.refused_estimates, 0);
        [stages.samples, stages.bands, stages.observation, stages.inferences]
    }

    #[test]
    fn each_scene_runs_its_own_stages_for_the_whole_stretch() {
        let all = u64::try_from(STRETCH).unwrap();
        assert_eq!(stages(Scene::Idle, false), [all, 0, 0, 0]);
        assert_eq!(stages(Scene::Moving, false), [all, 0, 0, 0]);
        assert_eq!(stages(Scene::Holding, false), [all, all, 0, 0]);
        let [samples, bands, observation, inferences] = stages(Scene::Slipping, false);
        assert_eq!([samples, bands, observation], [all; 3]);
        assert!(inferences > all / 20, "about one a millisecond: {inferences}");
    }

    #[test]
    fn a_stylus_alone_slips_without_a_network() {
        let stages = SceneRun::stylus_alone().unwrap().stages;
        assert_eq!([stages.observation, stages.inferences], [stages.samples, 0]);
    }

    #[test]
    fn without_skipping_every_scene_runs_every_stage() {
        for scene in super::SCENES {
            let [samples, bands, observation, _] = stages(scene, true);
            assert_eq!([bands, observation], [samples; 2], "{}", scene.name());
        }
    }
}
