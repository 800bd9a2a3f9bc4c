//! Time of one sample through the pipeline, scene by scene, with and without skipping.
#![expect(
    clippy::expect_used,
    clippy::cast_precision_loss,
    reason = "a bench that cannot be set up has to stop; signals of some thousand samples"
)]

mod rounds;

use core::hint::black_box;
use criterion::{BenchmarkGroup, BenchmarkId, Criterion, Throughput, measurement::WallTime};
use slip_benches::scenes::{SCENES, STRETCH, SceneRun};
use slip_core::{
    filter::{Band, FilterBank},
    sample::Scene,
};

fn handle(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("Pipeline::handle");
    group.throughput(Throughput::Elements(1));
    for scene in SCENES {
        for (skipping, no_skip) in [("skip", false), ("no_skip", true)] {
            let run = SceneRun::new(scene, no_skip).expect("the scene stands");
            time(&mut group, &BenchmarkId::new(scene.name(), skipping), &run);
        }
    }
    for scene in SCENES {
        let run = SceneRun::certifying(scene).expect("the scene stands");
        time(&mut group, &BenchmarkId::new(scene.name(), "certifying"), &run);
    }
    let run = SceneRun::stylus_alone().expect("the scene stands");
    time(&mut group, &BenchmarkId::new(Scene::Slipping.name(), "stylus alone"), &run);
    group.finish();
}

fn time(group: &mut BenchmarkGroup<'_, WallTime>, id: &BenchmarkId, run: &SceneRun) {
    group.bench_with_input(id.clone(), run, |bencher, run| {
        rounds::by_item(
            bencher,
            STRETCH,
            || run.pipeline.clone(),
            |pipeline, count| {
                for sample in run.samples.iter().take(count) {
                    black_box(&pipeline.handle(black_box(sample)));
                }
            },
        );
    });
}

/// Blocks of 5 samples through eight lanes of band-passes, by one bank and by several side by side: what the recursion of one bank leaves
/// idle, the others use (docs/results/run-time.md).
fn bank(criterion: &mut Criterion) {
    const BLOCK: usize = 5;
    let bands: [Band; 8] = core::array::from_fn(|i| {
        let low_hz = 8.0 * f32::from(1_u16 << i);
        Band { low_hz, high_hz: 2.0 * low_hz }
    });
    let bank = FilterBank::new(&bands, 10_000.0).expect("the bands fit");
    let blocks: Vec<[f32; BLOCK]> = (0..STRETCH / BLOCK)
        .map(|i| core::array::from_fn(|j| ((i * BLOCK + j) as f32 * 0.37).sin()))
        .collect();
    let mut group = criterion.benchmark_group("FilterBank::energy, a sample of a bank");
    for banks in [1, 2, 4] {
        group.throughput(Throughput::Elements(1));
        group.bench_with_input(BenchmarkId::new("banks", banks), &banks, |bencher, &banks| {
            rounds::by_item(
                bencher,
                STRETCH * banks,
                || vec![bank; banks],
                |side_by_side, count| {
                    for block in blocks.iter().take(count / (BLOCK * banks)) {
                        for bank in side_by_side.iter_mut() {
                            black_box(bank.energy(black_box(block), 0.1, &[1.0; 8]));
                        }
                    }
                },
            );
        });
    }
    group.finish();
}

fn main() {
    let mut criterion = Criterion::default().configure_from_args();
    handle(&mut criterion);
    bank(&mut criterion);
    criterion.final_summary();
}
