//! `gripctl grasp --memory`: the same objects grasped again and again, with memory and without.

use super::{bench, faults::spread, in_parallel, scenes, ways};
use crate::{cli::grasp::GraspArgs, output};
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
    output::line(&format!("{}, {}: {} objects", first.scene, first.sensors, first.trials))?;
    output::line(&format!(
        "  {:8} {:7} {:>8} {:>8} {:>8} {:>18} {:>18} {:>18}",
        "grasp",
        "memory",
        "dropped",
        "crushed",
        "noticed",
        "slip mm",
        "peak/needed",
        "final/needed"
    ))?;
    for total in totals {
        let grasp = match total.grasp.checked_sub(GRASPS) {
            Some(swapped @ 1..) => format!("other {swapped}"),
            _ => total.grasp.to_string(),
        };
        output::line(&format!(
            "  {grasp:8} {:7} {:>8} {:>8} {:>8} {:>18} {:>18} {:>18}",
            if total.memory { "yes" } else { "no" },
            total.dropped,
            total.crushed,
            total.noticed,
            spread(total.slip_mm),
            spread(total.peak_ratio),
            spread(total.force_ratio)
        ))?;
    }
    Ok(output::line("")?)
}
