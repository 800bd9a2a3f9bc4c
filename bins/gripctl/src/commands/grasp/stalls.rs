//! `gripctl grasp --stalls`: what a line or a daemon that stops in the middle of a slip costs.

use super::super::{estimator, host_config};
use super::{Axis, cells, in_parallel};
use crate::{cli::grasp::GraspArgs, output, table};
use grip_eval::grasp::stalls::{
    MASSES_KG, SLIPS, STALLS_MS, StallCell, StallPlace, StallTrial, stall_cell, stall_trials,
};
use grip_session::exit::Exit;

/// Objects per cell where nobody asks for more.
const TRIALS: u64 = 8;

pub(super) fn run(args: &GraspArgs) -> anyhow::Result<Exit> {
    let config = host_config(args.config.as_deref())?;
    let estimator = estimator(args.model.as_deref(), &config)?;
    let mut jobs = Vec::new();
    for seed in args.seeds(TRIALS) {
        for slip in SLIPS {
            jobs.extend(MASSES_KG.map(|mass_kg| (seed, slip, mass_kg)));
        }
    }
    let run = |(seed, (friction, ramp_s), mass_kg)| {
        stall_trials(&config, &estimator, friction, ramp_s, mass_kg, seed)
    };
    let trials: Vec<StallTrial> = in_parallel(jobs, "stalls", "objects", run)?.concat();
    if args.each && args.json {
        trials.iter().try_for_each(output::json)?;
    }
    let names = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect();
    let axes: [Axis<StallTrial>; 4] = [
        (names(&StallPlace::ALL.map(StallPlace::name)), |trial| trial.place.to_owned()),
        (STALLS_MS.map(|ms| ms.to_string()).to_vec(), |trial| trial.stall_ms.to_string()),
        (names(&SLIPS.map(|(friction, _)| friction.name)), |trial| trial.friction.to_owned()),
        (MASSES_KG.map(|kg| kg.to_string()).to_vec(), |trial| trial.mass_kg.to_string()),
    ];
    let cells = |kind, by| cells(&axes, by, &trials, |names, own| stall_cell(kind, names, own));
    print(args, "every cell", &cells("stall", [true; 4]))?;
    print(args, "all masses", &cells("stall_total", [true, true, true, false]))?;
    Ok(Exit::Done)
}

fn print(args: &GraspArgs, title: &str, cells: &[StallCell]) -> anyhow::Result<()> {
    if args.json {
        return cells.iter().try_for_each(output::json);
    }
    output::line(title)?;
    let names = ["place", "stall_ms", "friction", "mass_kg", "trials", "unreached"];
    let lost = ["dropped", "crushed", "dropped_holdable", "oracle_dropped"];
    let ratios = ["peak/needed=peak_ratio", "without a stall=peak_ratio_sound"];
    table::print(cells, &[&names[..], &lost, &ratios].concat())?;
    Ok(output::line("")?)
}
