//! Time of one forward pass; of one tanh, beside its error: the program `accuracy`.
#![expect(clippy::expect_used, reason = "a bench that cannot be set up has to stop")]

mod rounds;

use core::hint::black_box;
use slip_benches::networks;

const PASSES: usize = 10_000;

fn main() {
    for (name, sizes) in
        [("Network 2-10-1", &[2, 10, 1][..]), ("Network 16-32-16-1", &[16, 32, 16, 1])]
    {
        let network = networks::network(sizes).expect("sizes are within the limits");
        let (input, mut output) = (vec![0.25; network.inputs()], [0.0]);
        let mut pass = || black_box(&network).forward(black_box(&input), black_box(&mut output));
        rounds::by_item(name, PASSES, || (), |()| (0..PASSES).for_each(|_| _ = black_box(pass())));
    }
    let model = networks::model().expect("2-10-1");
    let pass = || black_box(&model).estimate(black_box(&[3.0, 2.0]));
    let passes = |(): &mut ()| (0..PASSES).for_each(|_| _ = black_box(pass()));
    rounds::by_item("Model::estimate 2-10-1", PASSES, || (), passes);
}
