//! Checks that every enclosure of E_sc holds the exact value; fails where one does not.
//!
//! `esc-containment [RANDOM [STEERED]]`: trials of each path, 1,000,000 and 100,000 unless said otherwise.
#![expect(clippy::print_stdout, reason = "a program that prints a table")]

use rayon::prelude::*;
use slip_benches::{
    containment::{Path, Tally, check},
    exact::pool::{Kind, Known, Width, pool},
};
use std::process::ExitCode;

/// Irregularities of each kind; the trials combine them.
const POOL: usize = 40_000;
/// Trials of one seed.
const BLOCK: u64 = 1000;

fn main() -> ExitCode {
    let mut counts = std::env::args().skip(1).map(|text| text.parse::<u64>());
    let mut count = |default| counts.next().unwrap_or(Ok(default));
    let (Ok(random), Ok(steered)) = (count(1_000_000), count(100_000)) else {
        println!("usage: esc-containment [RANDOM [STEERED]]");
        return ExitCode::from(2);
    };
    println!(
        "path, inputs, irregularities: trials, failures, open, without value, tightest (share of the half width used)"
    );
    let mut failures = 0;
    for width in [Width::Double, Width::Single] {
        for kind in [Kind::Machined, Kind::Wide] {
            let known = pool(kind, width, POOL, 1);
            for path in Path::ALL.into_iter().filter(|path| path.width() == width) {
                for (steered, count) in [(false, random.div_ceil(2)), (true, steered.div_ceil(2))] {
                    let tally = all(path, &known, count, steered);
                    let inputs = if steered { "steered" } else { "random" };
                    println!(
                        "{}, {inputs}, {kind:?}: {}, {}, {}, {}, {:.3}",
                        path.name(),
                        tally.trials,
                        tally.failures,
                        tally.open,
                        tally.missing,
                        tally.tightest
                    );
                    failures += tally.failures + tally.missing;
                }
            }
        }
    }
    println!("{failures} failures");
    if failures == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

fn all(path: Path, known: &[Known], count: u64, steered: bool) -> Tally {
    (0..count.div_ceil(BLOCK))
        .into_par_iter()
        .map(|block| check(path, known, BLOCK.min(count - block * BLOCK), steered, block))
        .reduce(Tally::default, Tally::plus)
}
