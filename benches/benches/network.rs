//! Time of one forward pass; of one tanh, beside its error: the program `accuracy`.
#![expect(clippy::expect_used, reason = "a bench that cannot be set up has to stop")]

use core::hint::black_box;
use criterion::{Criterion, Throughput};
use slip_benches::networks;

fn forward(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("forward pass");
    group.throughput(Throughput::Elements(1));
    for (name, sizes) in
        [("Network 2-10-1", &[2, 10, 1][..]), ("Network 16-32-16-1", &[16, 32, 16, 1])]
    {
        let network = networks::network(sizes).expect("sizes are within the limits");
        let input = vec![0.25; network.inputs()];
        let mut output = [0.0];
        group.bench_function(name, |bencher| {
            bencher.iter(|| black_box(&network).forward(black_box(&input), black_box(&mut output)));
        });
    }
    let model = networks::model().expect("2-10-1");
    group.bench_function("Model::estimate 2-10-1", |bencher| {
        bencher.iter(|| black_box(&model).estimate(black_box(&[3.0, 2.0])));
    });
    group.finish();
}

fn main() {
    let mut criterion = Criterion::default().configure_from_args();
    forward(&mut criterion);
    criterion.final_summary();
}
