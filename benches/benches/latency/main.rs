//! Latency from a sample, or the bytes of a frame, to the force command: quantiles (us) beside the stated limits, one JSON object each.
//!
//! The exit code is 1 where a limit is not kept. They stand far above what a machine takes that is not busy with something else.
#![expect(clippy::print_stdout, reason = "the result of the program")]

mod session;

use core::{error::Error, hint::black_box, time::Duration};
use hdrhistogram::{CreationError, Histogram};
use serde_json::json;
use slip_benches::{
    scenes::{SCENES, SceneRun},
    time::now,
};
use std::process::ExitCode;

/// Limits of the median and of the 99.9 % quantile (us).
type Limits = [Option<f64>; 2];

/// One sample through the pipeline.
const HANDLE: Limits = [None, Some(10.0)];
/// Bytes of a frame to the bytes of the command, in memory.
const IN_MEMORY: Limits = [Some(25.0), Some(250.0)];

fn main() -> Result<ExitCode, Box<dyn Error>> {
    // `cargo test --benches` runs this without `--bench`: then it only has to work.
    let measure = std::env::args().any(|argument| argument == "--bench");
    let (seconds, grasps) = if measure { (100, 100) } else { (1, 1) };
    let mut clock = histogram()?;
    (0..1_000_000).for_each(|_| record(&mut clock, now().elapsed()));
    let mut kept = is_kept("reading the clock twice", &clock, [None; 2]);
    for no_skip in [false, true] {
        for scene in SCENES {
            let times = scene_times(&SceneRun::new(scene, no_skip)?, seconds)?;
            let skipping = if no_skip { ", no skipping" } else { "" };
            kept &= is_kept(&format!("handle, {}{skipping}", scene.name()), &times, HANDLE);
        }
    }
    kept &= is_kept("SAMPLES bytes -> GRIP bytes", &session::grasps(grasps)?, IN_MEMORY);
    // A single second without optimisation shows nothing of the limits.
    Ok(if kept || !measure { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// Single calls of `Pipeline::handle`, `seconds` times a second of samples.
fn scene_times(run: &SceneRun, seconds: u32) -> Result<Histogram<u64>, CreationError> {
    let mut times = histogram()?;
    for _ in 0..seconds {
        let mut pipeline = run.pipeline.clone();
        for sample in &run.samples {
            let start = now();
            black_box(pipeline.handle(black_box(sample)));
            record(&mut times, start.elapsed());
        }
    }
    Ok(times)
}

/// Times up to a second (ns), three digits.
fn histogram() -> Result<Histogram<u64>, CreationError> {
    Histogram::new_with_max(1_000_000_000, 3)
}

/// Counts `time`; what is longer than a second counts as a second.
fn record(times: &mut Histogram<u64>, time: Duration) {
    times.saturating_record(u64::try_from(time.as_nanos()).unwrap_or(u64::MAX));
}

/// Prints the quantiles of `times` (ns), and whether they keep `limits`.
fn is_kept(what: &str, times: &Histogram<u64>, limits: Limits) -> bool {
    let us = |ns| Duration::from_nanos(ns).as_secs_f64() * 1e6;
    let [p50, p99, p99_9] = [0.5, 0.99, 0.999].map(|q| us(times.value_at_quantile(q)));
    let kept =
        [p50, p99_9].iter().zip(limits).all(|(time, limit)| limit.is_none_or(|l| *time <= l));
    println!(
        "{}",
        json!({"what": what, "times": times.len(), "p50": p50, "p99": p99, "p99_9": p99_9,
            "max": us(times.max()), "limits": limits, "kept": kept})
    );
    kept
}
