//! Time of one sample through the pipeline, scene by scene, with and without skipping.
#![expect(clippy::expect_used, reason = "a bench that cannot be set up has to stop")]

mod rounds;

use core::hint::black_box;
use criterion::{BenchmarkGroup, BenchmarkId, Criterion, Throughput, measurement::WallTime};
use slip_benches::scenes::{SCENES, STRETCH, SceneRun};
use slip_core::sample::Scene;

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

fn main() {
    let mut criterion = Criterion::default().configure_from_args();
    handle(&mut criterion);
    criterion.final_summary();
}
