//! `gripctl grasp --faults`: what a sensor that fails costs, by sensor, fault, phase and friction.

use super::super::{estimator, host_config};
use super::in_parallel;
use crate::{
    cli::grasp::{GraspArgs, flat},
    output::{self, or_dash},
};
use grip_eval::grasp::{
    Friction, Spread,
    faults::{
        FAULT_SENSORS, FaultBench, FaultCell, FaultKind, FaultPhase, FaultPlan, FaultTrial,
        fault_cell,
    },
};
use grip_session::exit::Exit;

/// Objects per cell where nobody asks for more.
const TRIALS: u64 = 8;
/// Stands for several names in a row of totals.
const ALL: &str = "all";

/// One dimension of the table: the names, and the name of a trial.
type Axis = (Vec<&'static str>, fn(&FaultTrial) -> &'static str);

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
    if args.each && args.json {
        trials.iter().try_for_each(output::json)?;
    }
    print(args, "every cell", &table("fault", &axes, [true; 4], &trials))?;
    for (title, by) in [
        ("by sensor and fault", [true, true, false, false]),
        ("by sensor", [true, false, false, false]),
        ("by fault", [false, true, false, false]),
        ("by phase", [false, false, true, false]),
        ("by friction", [false, false, false, true]),
        ("in all", [false; 4]),
    ] {
        print(args, title, &table("fault_total", &axes, by, &trials))?;
    }
    Ok(Exit::Done)
}

/// What was chosen; everything where nothing was.
fn or_all<T: Copy>(chosen: &[crate::cli::grasp::Chosen<T>], all: &[T]) -> Vec<T> {
    let chosen = flat(chosen);
    if chosen.is_empty() { all.to_vec() } else { chosen }
}

fn axes(plan: &FaultPlan, frictions: &[Friction]) -> [Axis; 4] {
    let sensors = FAULT_SENSORS.iter().filter(|(_, sensor)| plan.sensors.contains(sensor));
    [
        (sensors.map(|(name, _)| *name).collect(), |trial| trial.sensor),
        (plan.faults.iter().map(|kind| kind.name).collect(), |trial| trial.fault),
        (plan.phases.iter().map(|phase| phase.name()).collect(), |trial| trial.phase),
        (frictions.iter().map(|friction| friction.name).collect(), |trial| trial.friction),
    ]
}

/// A cell for every combination of names on the axes in `by`; the others are summed up.
fn table(
    kind: &'static str,
    axes: &[Axis; 4],
    by: [bool; 4],
    trials: &[FaultTrial],
) -> Vec<FaultCell> {
    let mut rows = vec![[ALL; 4]];
    for (place, (names, _)) in axes.iter().enumerate() {
        if by.get(place) == Some(&true) {
            let with = |row: &[&'static str; 4], name: &'static str| {
                let mut row = *row;
                if let Some(slot) = row.get_mut(place) {
                    *slot = name;
                }
                row
            };
            let with = &with;
            rows =
                rows.iter().flat_map(|row| names.iter().map(move |name| with(row, name))).collect();
        }
    }
    let belongs = |row: &[&str; 4], trial: &FaultTrial| {
        row.iter().zip(axes).all(|(name, (_, of))| *name == ALL || *name == of(trial))
    };
    let cell = |row: [&'static str; 4]| {
        let own: Vec<&FaultTrial> = trials.iter().filter(|trial| belongs(&row, trial)).collect();
        fault_cell(kind, row, &own)
    };
    rows.into_iter().map(cell).collect()
}

fn print(args: &GraspArgs, title: &str, cells: &[FaultCell]) -> anyhow::Result<()> {
    if args.json {
        return cells.iter().try_for_each(output::json);
    }
    output::line(title)?;
    output::line(&format!(
        "  {:7} {:8} {:8} {:11} {:>6}  {:>13}  {:>13}  {:>13}  {:>13}  {:>13}  {:>18}",
        "sensor",
        "fault",
        "phase",
        "friction",
        "trials",
        "dropped crush",
        "absent  crush",
        "sound   crush",
        "holdable crsh",
        "oracle   lost",
        "peak/needed"
    ))?;
    cells.iter().try_for_each(|cell| output::line(&row(cell)))?;
    Ok(output::line("")?)
}

fn row(cell: &FaultCell) -> String {
    let pair = |first: usize, second: usize| format!("{first:>7} {second:>5}");
    let FaultCell { sensor, fault, phase, friction, trials, .. } = cell;
    format!(
        "  {sensor:7} {fault:8} {phase:8} {friction:11} {trials:>6}  {}  {}  {}  {}  {}  {:>18}",
        pair(cell.dropped, cell.crushed),
        pair(cell.dropped_absent, cell.crushed_absent),
        pair(cell.dropped_sound, cell.crushed_sound),
        pair(cell.dropped_holdable, cell.crushed_holdable),
        pair(cell.oracle_dropped, cell.oracle_lost),
        spread(cell.peak_ratio)
    )
}

/// Median, 95 % quantile and largest value.
pub(super) fn spread(spread: Spread) -> String {
    let Spread { p50, p95, max } = spread;
    format!("{} / {} / {}", or_dash(p50, 2), or_dash(p95, 2), or_dash(max, 2))
}
