//! Latency from a sample, or the bytes of a frame, to the force command: percentiles beside the stated limits.
//!
//! A limit that is not kept is printed as `over`, and the exit code is 1. They stand far above what a machine takes that is not busy with something else.

mod handle;
mod session;
mod table;

use core::error::Error;
use std::process::ExitCode;

use slip_benches::time::now;
use table::{Limits, Table};

/// One sample through the pipeline.
const HANDLE: Limits = Limits { p50_us: None, p99_9_us: Some(10.0) };
/// Bytes of a frame to the bytes of the command, in memory.
const IN_MEMORY: Limits = Limits { p50_us: Some(25.0), p99_9_us: Some(250.0) };

/// How much is measured.
#[derive(Clone, Copy, Debug)]
struct Extent {
    /// Repeats of a second of samples.
    seconds: u32,
    /// Simulated grasps of two seconds.
    grasps: u64,
}

fn main() -> Result<ExitCode, Box<dyn Error>> {
    // `cargo test --benches` runs this without `--bench`: then it only has to work.
    let measure = std::env::args().any(|argument| argument == "--bench");
    let extent = if measure {
        Extent { seconds: 100, grasps: 100 }
    } else {
        Extent { seconds: 1, grasps: 1 }
    };
    let mut table = Table::default();
    table.add("reading the clock twice", &handle::clock(1_000_000)?, Limits::NONE);
    handle::scenes(extent.seconds, &mut table)?;
    table.add(
        "SAMPLES bytes -> GRIP bytes, in memory",
        &session::grasps(extent.grasps)?,
        IN_MEMORY,
    );
    table.print();
    // A single second without optimisation shows nothing of the limits.
    let kept = !measure || table.over() == 0;
    Ok(if kept { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}
