//! Time of one forward pass and of one tanh.
#![expect(clippy::expect_used, reason = "a bench that cannot be set up has to stop")]

use core::hint::black_box;
use criterion::{Criterion, Throughput};
use mlp::{tanh, train::Isa};
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

/// Values of a block: they stay in the first-level cache.
const BLOCK: usize = 1024;

fn tanh_of_a_block(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("tanh of 1024 values");
    group.throughput(Throughput::Elements(BLOCK as u64));
    let values: Vec<f32> = networks::weights(BLOCK).into_iter().map(|x| 4.0 * x).collect();
    let mut place = values.clone();
    let mut each = |name: &str, f: &dyn Fn(&mut [f32])| {
        group.bench_function(name, |bencher| {
            bencher.iter(|| {
                place.copy_from_slice(black_box(&values));
                f(&mut place);
                black_box(&mut place);
            });
        });
    };
    for isa in Isa::available() {
        each(&format!("rational, {isa}"), &|xs| isa.tanh(xs));
    }
    each("rational, a loop", &|xs| xs.iter_mut().for_each(|x| *x = tanh::rational(*x)));
    each("exact, a loop", &|xs| xs.iter_mut().for_each(|x| *x = tanh::exact(*x)));
    each("platform, a loop", &|xs| xs.iter_mut().for_each(|x| *x = x.tanh()));
    group.finish();
}

fn main() {
    let mut criterion = Criterion::default().configure_from_args();
    tanh_of_a_block(&mut criterion);
    forward(&mut criterion);
    criterion.final_summary();
}
