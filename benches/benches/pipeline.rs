//! Time of one sample through the pipeline, scene by scene, with and without skipping.
#![expect(clippy::expect_used, reason = "a bench that cannot be set up has to stop")]

mod rounds;

use core::hint::black_box;
use criterion::{BenchmarkId, Criterion, Throughput};
use slip_benches::scenes::{SCENES, STRETCH, SceneRun};

fn handle(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("Pipeline::handle");
    group.throughput(Throughput::Elements(1));
    for scene in SCENES {
        for (skipping, no_skip) in [("skip", false), ("no_skip", true)] {
            let run = SceneRun::new(scene, no_skip).expect("the scene stands");
            group.bench_function(BenchmarkId::new(scene.name(), skipping), |bencher| {
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
    }
    group.finish();
}

fn main() {
    let mut criterion = Criterion::default().configure_from_args();
    handle(&mut criterion);
    criterion.final_summary();
}
