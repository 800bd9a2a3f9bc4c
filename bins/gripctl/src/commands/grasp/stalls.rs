//! `gripctl grasp --stalls`: what a line or a daemon that stops in the middle of a slip costs.

use super::super::{estimator, host_config};
use super::{faults::spread, in_parallel};
use crate::{cli::grasp::GraspArgs, output};
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
    let (mut cells, mut totals) = (Vec::new(), Vec::new());
    for place in StallPlace::ALL {
        for stall_ms in STALLS_MS {
            let stall =
                |trial: &StallTrial| trial.place == place.name() && trial.stall_ms == stall_ms;
            for (friction, _) in SLIPS {
                let own = |trial: &StallTrial| stall(trial) && trial.friction == friction.name;
                for mass_kg in MASSES_KG {
                    let names = [
                        place.name().to_owned(),
                        stall_ms.to_string(),
                        friction.name.to_owned(),
                        format!("{mass_kg}"),
                    ];
                    let row: Vec<&StallTrial> = trials
                        .iter()
                        .filter(|trial| own(trial) && trial.mass_kg.total_cmp(&mass_kg).is_eq())
                        .collect();
                    cells.push(stall_cell("stall", names, &row));
                }
                let names = [place.name(), &stall_ms.to_string(), friction.name, "all"];
                let row: Vec<&StallTrial> = trials.iter().filter(|trial| own(trial)).collect();
                totals.push(stall_cell("stall_total", names.map(str::to_owned), &row));
            }
        }
    }
    print(args, "every cell", &cells)?;
    print(args, "all masses", &totals)?;
    Ok(Exit::Done)
}

fn print(args: &GraspArgs, title: &str, cells: &[StallCell]) -> anyhow::Result<()> {
    if args.json {
        return cells.iter().try_for_each(output::json);
    }
    output::line(title)?;
    output::line(&format!(
        "  {:7} {:>6} {:11} {:>5} {:>6} {:>9} {:>8} {:>8} {:>9} {:>7} {:>18} {:>18}",
        "stalls",
        "ms",
        "friction",
        "kg",
        "trials",
        "unreached",
        "dropped",
        "crushed",
        "holdable",
        "oracle",
        "peak/needed",
        "without a stall"
    ))?;
    for cell in cells {
        let StallCell { place, stall_ms, friction, mass_kg, trials, unreached, .. } = cell;
        output::line(&format!(
            "  {place:7} {stall_ms:>6} {friction:11} {mass_kg:>5} {trials:>6} {unreached:>9} {:>8} {:>8} {:>9} {:>7} {:>18} {:>18}",
            cell.dropped,
            cell.crushed,
            cell.dropped_holdable,
            cell.oracle_dropped,
            spread(cell.peak_ratio),
            spread(cell.peak_ratio_sound)
        ))?;
    }
    Ok(output::line("")?)
}
