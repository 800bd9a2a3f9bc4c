//! Instructions of `Pipeline::handle` in each scene.

use crate::board::{Board, print};
use crate::model::{self, Weights};
use crate::signal::{RATE_HZ, Signal};
use crate::stack;
use core::hint::black_box;
use slip_core::{
    Pipeline, PipelineConfig,
    estimate::{Estimator, Feature},
    sample::Scene,
    units::Hertz,
};

/// Samples in which the floor is learned, the fingers close, and a scene becomes steady.
const LEARN: u32 = 2_100;
const CLOSE: u32 = 3_000;
const SETTLE: u32 = 1_000;
const STRETCH: u32 = 10_000;
const HELD_N: f32 = 3.0;
const SLIP_M_S: f32 = 0.05;

/// Count, sum and largest of the instructions of some samples.
#[derive(Clone, Copy, Debug, Default)]
struct Cost {
    count: u32,
    sum: i64,
    largest: i32,
}

impl Cost {
    fn add(&mut self, instructions: i32) {
        self.count += 1;
        self.sum += i64::from(instructions);
        self.largest = self.largest.max(instructions);
    }

    fn report(&self, name: &str, kind: &str) {
        if self.count > 0 {
            let mean = u32::try_from(self.sum / i64::from(self.count)).unwrap_or(0);
            print(&["handle, ", name, kind, ": mean "], &[]);
            print(
                &["", ", most ", " instructions a sample, ", " samples\n"],
                &[mean, self.largest.unsigned_abs(), self.count],
            );
        }
    }
}

/// Prints RAM, and mean and largest number of instructions for each scene.
pub fn measure(board: &Board) {
    print(
        &["RAM: Pipeline with model ", " bytes, its weights in flash\n"],
        &[u32::try_from(size_of::<Pipeline<Weights>>()).unwrap_or(0)],
    );
    let done = learning(board).and_then(|()| {
        [Scene::Idle, Scene::Moving, Scene::Holding, Scene::Slipping]
            .into_iter()
            .try_for_each(|scene| in_scene(board, scene))
    });
    if done.is_none() {
        print(&["failed: a scene was left\n"], &[]);
    }
}

fn pipeline() -> Option<Pipeline<Weights>> {
    let features =
        [Feature::from_name("slip_acceleration_m_s2")?, Feature::from_name("trial_force_n")?];
    let estimator = Estimator::new(model::model()?, &features).ok()?;
    Pipeline::new(PipelineConfig::gripping(Hertz(RATE_HZ)), Some(estimator)).ok()
}

/// Open fingers while the noise floor is learned.
fn learning(board: &Board) -> Option<()> {
    let (mut pipeline, mut signal) = (pipeline()?, Signal::new());
    stretch(
        board,
        &mut pipeline,
        &mut signal,
        Plan { scene: Scene::Idle, count: 1500, force_n: 0.0, speed_m_s: 0.0 },
    )?[0]
        .report("learning the floor", "");
    Some(())
}

fn in_scene(board: &Board, scene: Scene) -> Option<()> {
    let (mut pipeline, mut signal) = (pipeline()?, Signal::new());
    let (force_n, speed_m_s) = match scene {
        Scene::Idle | Scene::Moving | Scene::Other(_) => (0.0, 0.0),
        Scene::Holding => (HELD_N, 0.0),
        Scene::Slipping => (HELD_N, SLIP_M_S),
    };
    let close = if scene == Scene::Moving { 0 } else { CLOSE };
    for (count, force_n, speed_m_s) in
        [(LEARN, 0.0, 0.0), (close, HELD_N, 0.0), (SETTLE, force_n, speed_m_s)]
    {
        for _ in 0..count {
            black_box(pipeline.handle(&signal.sample(force_n, speed_m_s)));
        }
    }
    let plan = Plan { scene, count: STRETCH, force_n, speed_m_s };
    let [without, with] = stretch(board, &mut pipeline, &mut signal, plan)?;
    without.report(scene.name(), "");
    with.report(scene.name(), " with features and inference");
    if scene == Scene::Slipping {
        let all = Cost {
            count: without.count + with.count,
            sum: without.sum + with.sum,
            largest: without.largest.max(with.largest),
        };
        all.report(scene.name(), ", all");
        print(
            &["RAM: stack below the caller of handle ", " bytes\n"],
            &[deepest(&mut pipeline, &mut signal)],
        );
    }
    Some(())
}

/// Stack of `handle` while it slips (bytes); the caller's own frame is not in it.
#[inline(never)]
fn deepest(pipeline: &mut Pipeline<Weights>, signal: &mut Signal) -> u32 {
    stack::paint();
    for _ in 0..200 {
        let sample = signal.sample(HELD_N, SLIP_M_S);
        black_box(pipeline.handle(black_box(&sample)));
    }
    stack::used()
}

#[derive(Clone, Copy, Debug)]
struct Plan {
    scene: Scene,
    count: u32,
    force_n: f32,
    speed_m_s: f32,
}

/// Cost of the samples without and with features; `None` where another scene was seen.
fn stretch(
    board: &Board,
    pipeline: &mut Pipeline<Weights>,
    signal: &mut Signal,
    plan: Plan,
) -> Option<[Cost; 2]> {
    let mut costs = [Cost::default(); 2];
    for _ in 0..plan.count {
        let sample = signal.sample(plan.force_n, plan.speed_m_s);
        let mut seen = None;
        // A step is looked at where `handle` has put it, as gripd does.
        let cost = board.instructions(|| {
            let step = pipeline.handle(black_box(&sample));
            let step = black_box(&step);
            seen = Some((step.scene, step.features.is_some()));
        });
        let (scene, features) = seen?;
        if scene != plan.scene {
            return None;
        }
        costs[usize::from(features)].add(cost);
    }
    Some(costs)
}
