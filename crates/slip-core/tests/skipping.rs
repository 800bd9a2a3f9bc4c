//! Skipping never changes a step: grasps whose samples are plain for long stretches, with everything in between that may end one.
#![expect(clippy::unwrap_used, reason = "test code")]

use proptest::prelude::*;
use slip_core::{
    Arrival, Pipeline, PipelineConfig, Sample, StageCounters, Step,
    alarm::{Method, Methods},
    grip::GripEvent,
    sample::Scene,
    units::{Hertz, Micros},
};

/// What happens in a stretch of samples.
#[derive(Clone, Copy, Debug)]
enum Stretch {
    Open,
    /// The same with nine milliseconds from sample to sample.
    OpenForLong,
    Held,
    Texture(f32),
    Sliding(f32),
    Motion,
    Commanded,
    Squeezed,
    LeapOfTravel(f32),
    Lost,
    Gap,
    Frozen,
    WithoutTravel,
}

fn any_stretch() -> impl Strategy<Value = (Stretch, usize)> {
    let kind = prop_oneof![
        4 => Just(Stretch::Held),
        2 => Just(Stretch::Open),
        2 => Just(Stretch::OpenForLong),
        2 => (0.2e-6_f32..5e-6).prop_map(Stretch::Texture),
        1 => (0.0_f32..0.1).prop_map(Stretch::Sliding),
        1 => Just(Stretch::Motion),
        1 => Just(Stretch::Commanded),
        1 => Just(Stretch::Squeezed),
        1 => (-2e-3_f32..2e-3).prop_map(Stretch::LeapOfTravel),
        1 => Just(Stretch::Lost),
        1 => Just(Stretch::Gap),
        1 => Just(Stretch::Frozen),
        1 => Just(Stretch::WithoutTravel),
    ];
    (kind, 1_usize..700)
}

/// Noise in [-1, 1), seeded.
struct Noise(u32);

impl Noise {
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f32::from(i16::try_from(self.0 >> 17).unwrap()) / 16384.0 - 1.0
    }
}

/// A gripper with force, travel, reference and sometimes taxels that goes through the stretches.
struct Gripper {
    noise: Noise,
    t: u64,
    travel_m: f32,
    phase: f32,
}

impl Gripper {
    fn sample(&mut self, stretch: Stretch) -> Sample {
        self.t += match stretch {
            Stretch::Gap => 30_000,
            Stretch::OpenForLong => 9000,
            _ => 100,
        };
        self.phase += 0.15;
        let mut sample = Sample {
            normal_force_n: Some(2.5 + 0.01 * self.noise.next()),
            reference: Some(1e-7 * self.noise.next()),
            ..Sample::stylus(Micros(self.t), 1e-3 + 1e-7 * self.noise.next())
        };
        match stretch {
            Stretch::Open | Stretch::OpenForLong => {
                sample.normal_force_n = Some(0.01 * self.noise.next());
                // The roller turns freely.
                self.travel_m += 2e-5;
            }
            Stretch::Texture(height_m) => sample.stylus += height_m * libm::sinf(self.phase),
            Stretch::Sliding(speed_m_s) => self.travel_m += 1e-4 * speed_m_s,
            Stretch::Motion => {
                sample.stylus += 2e-6 * libm::sinf(self.phase);
                sample.reference = Some(2e-6 * libm::sinf(self.phase));
            }
            Stretch::Squeezed => sample.normal_force_n = Some(3.5),
            Stretch::Commanded => sample.motion = Some(1.0),
            Stretch::LeapOfTravel(leap_m) if self.t.is_multiple_of(7_700) => {
                self.travel_m += leap_m;
            }
            Stretch::Lost => sample.stylus = f32::NAN,
            Stretch::Frozen => sample.stylus = 1e-3,
            _ => {}
        }
        let travel_m = self.travel_m + 1e-6 * libm::roundf(self.noise.next());
        sample.travel_m = (!matches!(stretch, Stretch::WithoutTravel)).then_some(travel_m);
        sample
    }
}

fn grasp(plan: &[(Stretch, usize)], seed: u32) -> Vec<Sample> {
    let mut gripper = Gripper { noise: Noise(seed), t: 0, travel_m: 0.0, phase: 0.0 };
    let learned = [(Stretch::Open, 2200), (Stretch::Held, 3000)];
    let stretches = learned.iter().chain(plan);
    stretches
        .flat_map(|&(stretch, len)| core::iter::repeat_n(stretch, len))
        .map(|stretch| gripper.sample(stretch))
        .collect()
}

fn run(config: PipelineConfig, samples: &[Sample], frames: usize) -> (Vec<Step>, StageCounters) {
    run_and_release(config, samples, frames, None)
}

/// The same; the object is let go at sample `released`, and the fingers may close again 700 samples later.
fn run_and_release(
    config: PipelineConfig,
    samples: &[Sample],
    frames: usize,
    released: Option<usize>,
) -> (Vec<Step>, StageCounters) {
    let mut pipeline = Pipeline::<&'static [f32]>::new(config, None).unwrap();
    let mut steps = Vec::new();
    for (i, sample) in samples.iter().enumerate() {
        if released == Some(i) {
            pipeline.release();
        } else if released.is_some_and(|at| at + 700 == i) {
            pipeline.close_again();
        }
        let wave = 0.1 * libm::sinf(f32::from(u16::try_from(i % 1000).unwrap()));
        let taxels = [1.0 + wave, 2.0 - wave, 3.0];
        let frame = frames > 0 && i.is_multiple_of(frames);
        steps.push(pipeline.handle_with(sample, if frame { &taxels } else { &[] }));
    }
    (steps, pipeline.stage_counters())
}

fn methods() -> impl Strategy<Value = Methods> {
    prop::sample::select(vec![
        Methods::ALL,
        Methods::only(Method::Stylus),
        Methods::only(Method::Travel),
        Methods::only(Method::Travel).with(Method::Pressure),
    ])
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    #[test]
    fn skipping_never_changes_a_step(
        plan in prop::collection::vec(any_stretch(), 1..12),
        seed in any::<u32>(),
        frames in prop::sample::select(vec![0_usize, 1, 3, 97]),
        methods in methods(),
        rate in prop::sample::select(vec![10_000.0_f32, 1000.0]),
        has_force in prop::bool::weighted(0.7),
        batch_us in prop::option::of(prop::sample::select(vec![1000_u64, 7000, 40_000])),
        released in prop::option::weighted(0.4, 4500_usize..8000),
    ) {
        let config = PipelineConfig { methods, ..PipelineConfig::gripping(Hertz(rate)) };
        let mut samples = grasp(&plan, seed);
        for sample in &mut samples {
            sample.normal_force_n = sample.normal_force_n.filter(|_| has_force);
            sample.arrival = batch_us.map(|batch_us| {
                let at = Micros((sample.t.0 / batch_us + 1) * batch_us);
                Arrival { at, age: at.since(sample.t) }
            });
        }
        let (skipping, _) = run_and_release(config, &samples, frames, released);
        let every = PipelineConfig { no_skip: true, ..config };
        let (all, _) = run_and_release(every, &samples, frames, released);
        for (at, (one, other)) in skipping.iter().zip(&all).enumerate() {
            prop_assert_eq!(one, other, "sample {}", at);
        }
    }
}

/// Fingers that close on nothing report it once, and then wait for touch, skipped or not.
#[test]
fn fingers_that_closed_on_nothing_wait_for_touch() {
    let plan = [
        (Stretch::Held, 1000),
        (Stretch::Open, 1000),
        (Stretch::OpenForLong, 600),
        (Stretch::Open, 1000),
        (Stretch::WithoutTravel, 2000),
        (Stretch::Texture(3e-6), 100),
        (Stretch::Held, 2000),
    ];
    for rate in [10_000.0, 1000.0] {
        let config = PipelineConfig::gripping(Hertz(rate));
        let samples = grasp(&plan, 3);
        let (skipping, _) = run_and_release(config, &samples, 0, Some(6200));
        let every = PipelineConfig { no_skip: true, ..config };
        let (all, _) = run_and_release(every, &samples, 0, Some(6200));
        assert_eq!(skipping, all);
        let empty = |step: &&Step| step.grip == Some(GripEvent::Empty);
        assert_eq!(skipping.iter().filter(empty).count(), 1);
        assert!(skipping.iter().skip(9000).any(|step| step.scene == Scene::Holding));
    }
}

/// A reading that shows touch again ends the doubt of one that did not, skipped or not.
#[test]
fn a_force_sensor_that_shows_touch_again_is_believed_again() {
    let plan = [
        (Stretch::Open, 1),
        (Stretch::Texture(4.793_191_7e-6), 284),
        (Stretch::Open, 532),
        (Stretch::Held, 1),
        (Stretch::Open, 1),
    ];
    let methods = Methods::only(Method::Stylus);
    let config = PipelineConfig { methods, ..PipelineConfig::gripping(Hertz(1000.0)) };
    let samples = grasp(&plan, 0);
    let (skipping, _) = run(config, &samples, 0);
    let (all, _) = run(PipelineConfig { no_skip: true, ..config }, &samples, 0);
    assert_eq!(skipping, all);
}

/// The grasps above contain what they are meant to: rest, slips by stylus and travel, motion.
#[test]
fn the_grasps_pass_through_every_scene() {
    let plan = [
        (Stretch::Held, 3000),
        (Stretch::Sliding(0.05), 300),
        (Stretch::Held, 6000),
        (Stretch::Motion, 400),
        (Stretch::Held, 3000),
        // It contradicts a travel that stands, which raises no alarm from then on.
        (Stretch::Texture(3e-6), 60),
        (Stretch::Held, 2000),
        (Stretch::Open, 2000),
    ];
    let config = PipelineConfig::gripping(Hertz(10_000.0));
    let (steps, stages) = run(config, &grasp(&plan, 1), 0);
    for scene in [Scene::Idle, Scene::Moving, Scene::Holding, Scene::Slipping] {
        let seen = steps.iter().filter(|step| step.scene == scene).count();
        assert!(seen > 200, "{}: {seen}", scene.name());
    }
    let slips = steps.iter().filter(|step| step.event.is_some()).count();
    assert!(slips >= 4, "two slips with their ends: {slips}");
    assert!(stages.bands < stages.samples, "nothing was skipped");
}
