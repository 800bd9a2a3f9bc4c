//! `gripctl grasp --faults`: what a sensor that fails costs, by sensor, fault, phase and friction.

use super::super::{estimator, host_config};
use super::{Axis, cells, in_parallel};
use crate::{
    cli::grasp::{GraspArgs, flat},
    output, table,
};
use grip_eval::grasp::{
    Friction,
    faults::{
        FAULT_SENSORS, FaultBench, FaultCell, FaultKind, FaultPhase, FaultPlan, FaultTrial,
        fault_cell,
    },
};
use grip_session::exit::Exit;

/// Objects per cell where nobody asks for more.
const TRIALS: u64 = 8;

pub(super) fn run(args: &GraspArgs) -> anyhow::Result<Exit> {
    let config = host_config(args.config.as_deref())?;
    let estimator = estimator(args.model.as_deref(), &config)?;
    let bench = FaultBench { config: &config, estimator: &estimator };
    let plan = FaultPlan {
        sensors: or_all(&args.tables.fault_sensor, &FAULT_SENSORS.map(|(_, sensor)| sensor)),
        faults: or_all(&args.tables.fault, &FaultKind::ALL),
        phases: or_all(&args.tables.phase, &FaultPhase::ALL),
    };
    let frictions = or_all(&args.tables.friction, &Friction::ALL);
    let seeds = args.seeds(TRIALS);
    let jobs: Vec<(u64, Friction)> =
        seeds.flat_map(|seed| frictions.iter().map(move |friction| (seed, *friction))).collect();
    let run = |(seed, friction)| bench.trials(&plan, friction, seed);
    let trials: Vec<FaultTrial> = in_parallel(jobs, "faults", "objects", run)?.concat();
    let axes = axes(&plan, &frictions);
    let cells = |kind, by| {
        cells(&axes, by, &trials, |names, own| {
            fault_cell(kind, names.each_ref().map(String::as_str), own)
        })
    };
    if args.each && args.json {
        trials.iter().try_for_each(output::json)?;
    }
    print(args, "every cell", &cells("fault", [true; 4]))?;
    for (title, by) in [
        ("by sensor and fault", [true, true, false, false]),
        ("by sensor", [true, false, false, false]),
        ("by fault", [false, true, false, false]),
        ("by phase", [false, false, true, false]),
        ("by friction", [false, false, false, true]),
        ("in all", [false; 4]),
    ] {
        print(args, title, &cells("fault_total", by))?;
    }
    Ok(Exit::Done)
}

/// What was chosen; everything where nothing was.
fn or_all<T: Copy>(chosen: &[crate::cli::grasp::Chosen<T>], all: &[T]) -> Vec<T> {
    let chosen = flat(chosen);
    if chosen.is_empty() { all.to_vec() } else { chosen }
}

fn axes(plan: &FaultPlan, frictions: &[Friction]) -> [Axis<FaultTrial>; 4] {
    let sensors = FAULT_SENSORS.iter().filter(|(_, sensor)| plan.sensors.contains(sensor));
    [
        (sensors.map(|(name, _)| (*name).to_owned()).collect(), |trial| trial.sensor.to_owned()),
        (plan.faults.iter().map(|kind| kind.name.to_owned()).collect(), |trial| {
            trial.fault.to_owned()
        }),
        (plan.phases.iter().map(|phase| phase.name().to_owned()).collect(), |trial| {
            trial.phase.to_owned()
        }),
        (frictions.iter().map(|friction| friction.name.to_owned()).collect(), |trial| {
            trial.friction.to_owned()
        }),
    ]
}

fn print(args: &GraspArgs, title: &str, cells: &[FaultCell]) -> anyhow::Result<()> {
    if args.json {
        return cells.iter().try_for_each(output::json);
    }
    output::line(title)?;
    let names = ["sensor", "fault", "phase", "friction", "trials"];
    let lost = ["dropped", "crushed", "dropped_absent", "crushed_absent", "dropped_sound"];
    let beside = ["crushed_sound", "dropped_holdable", "crushed_holdable", "oracle_dropped"];
    let oracle = ["oracle_lost", "peak/needed=peak_ratio"];
    table::print(cells, &[&names[..], &lost, &beside, &oracle].concat())?;
    Ok(output::line("")?)
}
