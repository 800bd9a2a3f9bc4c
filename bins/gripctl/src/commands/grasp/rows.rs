//! `gripctl grasp --rows`: what gripd measured in the slips of many objects, as rows for `gripctl train`.

use super::{TRIALS, bench, in_parallel, inputs, print_totals, scenes, totals_of};
use crate::{cli::grasp::GraspArgs, output};
use anyhow::Context as _;
use grip_eval::grasp::{Reading, Way};
use grip_record::outputs::OutputKind;
use grip_session::exit::Exit;
use std::{io::Write as _, path::Path};

/// No other command writes these columns.
const ROWS: OutputKind = OutputKind {
    is_ours: |head| {
        head.starts_with(format!("scene,seed,{}", Reading::columns().join(",")).as_bytes())
    },
    ..output::TABLE
};

pub(super) fn run(args: &GraspArgs, file: &Path) -> anyhow::Result<Exit> {
    let out = output::path(file, ROWS, &args.force, &inputs(args))?;
    let bench = bench(args)?;
    let scenes = scenes(args)?;
    let unwritable = || format!("--rows {}", file.display());
    let mut rows = out.create()?;
    writeln!(rows, "scene,seed,{}", Reading::columns().join(",")).with_context(unwritable)?;
    for scene in &scenes {
        let name = &scene.config().name;
        let jobs: Vec<u64> = args.seeds(TRIALS).collect();
        let read = in_parallel(jobs, name, "grasps", |seed| bench.read(scene, seed))?;
        for (grasp, readings) in &read {
            for reading in readings {
                writeln!(rows, "{name},{},{}", grasp.seed, reading.csv())
                    .with_context(unwritable)?;
            }
        }
        let grasps: Vec<_> = read.into_iter().map(|(grasp, _)| grasp).collect();
        print_totals(args, &totals_of(name, &[Way::default()], &grasps))?;
    }
    rows.finish()?;
    Ok(Exit::Done)
}
