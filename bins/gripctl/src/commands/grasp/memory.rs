//! `gripctl grasp --memory`: the same objects grasped again and again, with memory and without.

use super::{bench, in_parallel, scenes, ways};
use crate::{cli::grasp::GraspArgs, output, table};
use grip_eval::grasp::{
    Bench, Way,
    memory::{GRASPS, MemoryGrasp, MemoryTotal, SWAPPED, memory_total},
};
use grip_session::exit::Exit;
use grip_sim::Scene;

/// Objects per scene where nobody asks for more.
const TRIALS: u64 = 20;

pub(super) fn run(args: &GraspArgs) -> anyhow::Result<Exit> {
    let bench = bench(args)?;
    for scene in &scenes(args)? {
        for way in ways(args) {
            series(args, scene, &way, &bench)?;
        }
    }
    Ok(Exit::Done)
}

fn series(args: &GraspArgs, scene: &Scene, way: &Way, bench: &Bench) -> anyhow::Result<()> {
    let jobs: Vec<(u64, bool)> =
        args.seeds(TRIALS).flat_map(|seed| [(seed, false), (seed, true)]).collect();
    let other = args.trials.unwrap_or(TRIALS);
    let run = |(seed, memory): (u64, bool)| {
        bench.remember(scene, seed, seed.wrapping_add(other), way, memory)
    };
    let grasps: Vec<MemoryGrasp> =
        in_parallel(jobs, &scene.config().name, "objects", run)?.concat();
    if args.each && args.json {
        grasps.iter().try_for_each(output::json)?;
    }
    let mut totals = Vec::new();
    for grasp in 1..=GRASPS + SWAPPED {
        for memory in [false, true] {
            let same = |one: &&MemoryGrasp| one.grasp == grasp && one.memory == memory;
            totals.extend(memory_total(&grasps.iter().filter(same).collect::<Vec<_>>()));
        }
    }
    print(args, &totals)
}

fn print(args: &GraspArgs, totals: &[MemoryTotal]) -> anyhow::Result<()> {
    if args.json {
        return totals.iter().try_for_each(output::json);
    }
    let Some(first) = totals.first() else { return Ok(()) };
    let (scene, sensors, trials) = (&first.scene, first.sensors, first.trials);
    output::line(&format!(
        "{scene}, {sensors}: {trials} objects; {GRASPS} grasps of each, then another one under its name"
    ))?;
    let lost = ["grasp", "memory", "dropped", "crushed", "noticed", "slip_mm"];
    let ratios = ["peak/needed=peak_ratio", "final/needed=force_ratio"];
    table::print(totals, &[&lost[..], &ratios].concat())?;
    Ok(output::line("")?)
}
