//! Instructions of one inference.

use crate::board::{Board, print};
use crate::model;
use crate::stack;
use core::hint::black_box;

const TIMES: u16 = 1000;

/// Prints the mean of each way to run the 2-10-1 network.
pub fn measure(board: &Board) {
    let (Some(network), Some(model)) = (model::network(), model::model()) else {
        print(&["no model\n"], &[]);
        return;
    };
    let inputs = |i: u16| [f32::from(i % 100) * 0.02 - 1.0, f32::from(i % 37) * 0.05 - 0.9];
    let raw = |i: u16| [f32::from(i % 100) * 0.2 - 11.0, f32::from(i % 37) * 0.5 + 1.0];
    report("forward pass, Network 2-10-1", board, |i| {
        let mut out = [0.0];
        let _ = black_box(network.forward(black_box(&inputs(i)), &mut out));
        black_box(out);
    });
    report("Model::estimate with logarithms", board, |i| {
        let _ = black_box(model.estimate(black_box(&raw(i))));
    });
    stack::paint();
    let _ = black_box(model.estimate(black_box(&raw(1))));
    print(
        &["RAM: Model ", " bytes, stack below the caller of estimate ", " bytes\n"],
        &[u32::try_from(size_of_val(&model)).unwrap_or(0), stack::used()],
    );
}

fn report(name: &str, board: &Board, mut work: impl FnMut(u16)) {
    let mut sum = 0;
    for i in 0..TIMES {
        sum += board.instructions(|| work(i));
    }
    print(&[name], &[]);
    print(&[": mean ", " instructions\n"], &[sum.unsigned_abs() / u32::from(TIMES)]);
}
