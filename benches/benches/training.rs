//! Time of one epoch of training: a 2-10-1 network on 100 rows.
#![expect(clippy::expect_used, reason = "a bench that cannot be set up has to stop")]

mod rounds;

use core::hint::black_box;
use criterion::{Criterion, Throughput};
use mlp::train::{Algorithm, init::nguyen_widrow};
use slip_benches::training::objective;

/// Epochs of a round: each starts from the same weights.
const EPOCHS: usize = 100;

fn epoch(criterion: &mut Criterion) {
    let objective = objective().expect("the data set is generated");
    let weights = nguyen_widrow(objective.topology(), 1);
    let mut group = criterion.benchmark_group("epoch of 100 rows, 2-10-1");
    group.throughput(Throughput::Elements(1));
    for algorithm in Algorithm::all() {
        group.bench_function(algorithm.name(), |bencher| {
            rounds::by_item(
                bencher,
                EPOCHS,
                || (algorithm.trainer(weights.len()), objective.clone(), weights.clone()),
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
    epoch(&mut criterion);
    criterion.final_summary();
}
