//! Scenes in, the times of single calls of `Pipeline::handle` out.

use crate::{
    HANDLE, now,
    table::{Table, histogram, record},
};
use core::{error::Error, hint::black_box};
use hdrhistogram::{CreationError, Histogram};
use slip_benches::scenes::{SCENES, SceneRun};

/// What a measurement of nothing shows; part of every other time here.
pub(crate) fn clock(times: u32) -> Result<Histogram<u64>, CreationError> {
    let mut seen = histogram()?;
    for _ in 0..times {
        let start = now();
        record(&mut seen, start.elapsed());
    }
    Ok(seen)
}

/// Adds a row for every scene, with and without skipping, from `seconds` times a second of samples.
pub(crate) fn scenes(seconds: u32, table: &mut Table) -> Result<(), Box<dyn Error>> {
    for no_skip in [false, true] {
        for scene in SCENES {
            let run = SceneRun::new(scene, no_skip)?;
            let mut times = histogram()?;
            for _ in 0..seconds {
                let mut pipeline = run.pipeline.clone();
                for sample in &run.samples {
                    let start = now();
                    black_box(pipeline.handle(black_box(sample)));
                    record(&mut times, start.elapsed());
                }
            }
            let skipping = if no_skip { ", no skipping" } else { "" };
            table.add(&format!("Pipeline::handle, {}{skipping}", scene.name()), &times, HANDLE);
        }
    }
    Ok(())
}
