//! Time of one epoch of training, in both precisions: 2-10-1 on 100 rows and 14-16-3 on 2104 rows.
#![expect(clippy::expect_used, reason = "a bench that cannot be set up has to stop")]

mod rounds;

use core::hint::black_box;
use criterion::{BenchmarkId, Criterion, Throughput};
use mlp::train::{Algorithm, NetworkObjective, Real};
use slip_benches::peers::{Case, building, surface};

fn epoch<T: Real>(criterion: &mut Criterion, case: &Case, epochs: usize) {
    let objective = NetworkObjective::<T>::new(&case.topology, &case.inputs, &case.targets)
        .expect("rows fit the network");
    let weights: Vec<T> = case.weights.iter().map(|&weight| T::of(weight)).collect();
    let mut group = criterion.benchmark_group(format!("epoch of {}", case.name));
    group.throughput(Throughput::Elements(1));
    for algorithm in Algorithm::all() {
        group.bench_function(BenchmarkId::new(algorithm.name(), T::NAME), |bencher| {
            rounds::by_item(
                bencher,
                epochs,
                || (algorithm.trainer::<T>(weights.len()), objective.clone(), weights.clone()),
                |(trainer, objective, weights), count| {
                    for _ in 0..count {
                        black_box(trainer.step(objective, weights));
                    }
                },
            );
        });
    }
    group.finish();
}

fn main() {
    let mut criterion = Criterion::default().configure_from_args();
    // Each round starts from the same weights and ends before the error is level.
    for (case, epochs) in [(surface(), 100), (building(), 20)] {
        let case = case.expect("the shape is possible");
        epoch::<f32>(&mut criterion, &case, epochs);
        epoch::<f64>(&mut criterion, &case, epochs);
    }
    criterion.final_summary();
}
