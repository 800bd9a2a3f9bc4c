//! `gripctl grasp`: many simulated objects in the gripper.

mod faults;
mod matrix;
mod memory;
mod plot;
mod rows;
mod stalls;
mod text;

use super::{estimator, host_config};
use crate::{
    cli::grasp::{GraspArgs, flat},
    output,
};
use grip_eval::grasp::{Bench, GraspError, GraspResult, Law, SensorSet, Stress, Total, Way, total};
use grip_session::exit::{Exit, WrongArgument};
use grip_sim::scene;
use grip_sim::{Scene, scene::BUILT_IN};
use indicatif::ParallelProgressIterator as _;
use rayon::iter::{IntoParallelIterator as _, ParallelIterator as _};
use slip_core::units::Micros;
use std::path::Path;

/// Longest grasp (s).
const LONGEST_S: f64 = 600.0;

/// Grasps per scene where nobody asks for another number.
const TRIALS: u64 = 100;

pub(crate) fn run(args: &GraspArgs) -> anyhow::Result<Exit> {
    if args.tables.faults {
        return faults::run(args);
    }
    if args.tables.stalls {
        return stalls::run(args);
    }
    if args.tables.matrix {
        return matrix::run(args);
    }
    if args.tables.memory {
        return memory::run(args);
    }
    if let Some(file) = &args.tables.rows {
        return rows::run(args, file);
    }
    let plot = args.plot.as_deref();
    let plot = output::optional(plot, output::PICTURE, &args.force, &inputs(args))?;
    let bench = bench(args)?;
    let ways = ways(args);
    let scenes = scenes(args)?;
    let mut totals = Vec::new();
    let mut all = Vec::new();
    for scene in &scenes {
        let grasps = grasp_many(args, scene, &ways, &bench)?;
        if args.each {
            for grasp in &grasps {
                print_grasp(args, grasp)?;
            }
        }
        let of_scene = totals_of(&scene.config().name, &ways, &grasps);
        print_totals(args, &of_scene)?;
        totals.extend(of_scene);
        all.extend(grasps);
    }
    print_totals(args, &totals_of("all", &ways, &all))?;
    if let Some(out) = &plot {
        output::draw(&plot::chart(&totals, &all, &ways), out)?;
    }
    Ok(Exit::Done)
}

/// Files that are read.
fn inputs(args: &GraspArgs) -> Vec<Option<&Path>> {
    let named = [&args.scene, &args.equip.gripper, &args.equip.sensing];
    let files = [&args.scenes, &args.config, &args.model].map(Option::as_deref);
    named.into_iter().flatten().map(|name| Some(Path::new(name))).chain(files).collect()
}

fn bench(args: &GraspArgs) -> anyhow::Result<Bench> {
    let duration = duration(args)?;
    let config = host_config(args.config.as_deref())?;
    let estimator = estimator(args.model.as_deref(), &config)?;
    Ok(Bench { config, estimator, duration })
}

/// All scenes with gripper and sensors: a mistake in the last one is reported before the first grasp.
fn scenes(args: &GraspArgs) -> anyhow::Result<Vec<Scene>> {
    let names = scene_names(args)?;
    let scenes = names.iter().map(|name| scene::open(name)).collect::<Result<Vec<_>, _>>()?;
    let scenes = scenes.into_iter().map(|scene| matrix::equipped(args, scene));
    Ok(scenes.collect::<Result<Vec<_>, _>>()?)
}

fn duration(args: &GraspArgs) -> Result<Micros, WrongArgument> {
    if !(args.duration > 0.0 && args.duration <= LONGEST_S) {
        let message =
            format!("--duration {}: expected seconds, more than 0 and up to 600", args.duration);
        return Err(WrongArgument(message));
    }
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "0 to 600 s, checked"
    )]
    let duration = Micros((args.duration * 1e6) as u64);
    Ok(duration)
}

/// The ways of grasping, one row each.
fn ways(args: &GraspArgs) -> Vec<Way> {
    let or =
        |chosen: Vec<SensorSet>| if chosen.is_empty() { vec![SensorSet::Scene] } else { chosen };
    let pairs: Vec<(Law, SensorSet)> = if args.compare {
        let own = SensorSet::ALL.map(|sensors| (Law::Own, sensors));
        let others = Law::BASELINES.map(|law| (law, SensorSet::Travel));
        own.into_iter().chain(others).collect()
    } else {
        let laws = flat(&args.baseline);
        let laws = if laws.is_empty() { vec![Law::Own] } else { laws };
        let sensors = or(flat(&args.sensors));
        laws.iter().flat_map(|&law| sensors.iter().map(move |&set| (law, set))).collect()
    };
    let troubles = flat(&args.stress);
    let troubles = if troubles.is_empty() { vec![Stress::NONE] } else { troubles };
    let with = |(law, sensors): (Law, SensorSet)| {
        troubles.clone().into_iter().map(move |stress| Way { law, sensors, stress })
    };
    pairs.into_iter().flat_map(with).collect()
}

fn scene_names(args: &GraspArgs) -> anyhow::Result<Vec<String>> {
    if args.all {
        return Ok(BUILT_IN.map(|(name, _)| name.to_owned()).to_vec());
    }
    let mut names = args.scene.clone();
    if let Some(folder) = &args.scenes {
        let wrong = |what: &str| WrongArgument(format!("--scenes {}: {what}", folder.display()));
        let entries = std::fs::read_dir(folder).map_err(|error| wrong(&error.to_string()))?;
        for entry in entries {
            let path = entry?.path();
            if path.extension().is_some_and(|extension| extension == "toml") {
                names.push(path.display().to_string());
            }
        }
        names.sort();
        if names.is_empty() {
            return Err(wrong("no scene file (.toml) in this folder").into());
        }
    }
    if names.is_empty() {
        names.push("default".to_owned());
    }
    Ok(names)
}

/// All grasps of a scene: of the first way, then of the next.
fn grasp_many(
    args: &GraspArgs,
    scene: &Scene,
    ways: &[Way],
    bench: &Bench,
) -> anyhow::Result<Vec<GraspResult>> {
    let jobs: Vec<(&Way, u64)> =
        ways.iter().flat_map(|way| args.seeds(TRIALS).map(move |seed| (way, seed))).collect();
    let grasp = |(way, seed)| bench.grasp(scene, seed, way);
    Ok(in_parallel(jobs, &scene.config().name, "grasps", grasp)?)
}

/// What comes of each job, in their order, with a bar for the jobs, which are called `unit`.
fn in_parallel<J: Send, T: Send>(
    jobs: Vec<J>,
    name: &str,
    unit: &str,
    run: impl Fn(J) -> Result<T, GraspError> + Sync + Send,
) -> Result<Vec<T>, GraspError> {
    let bar = output::progress(jobs.len(), unit);
    bar.set_message(format!("{name:18} "));
    jobs.into_par_iter().progress_with(bar).map(run).collect()
}

/// A total for each way.
fn totals_of(name: &str, ways: &[Way], grasps: &[GraspResult]) -> Vec<Total> {
    let of = |way: &Way| {
        let same = |grasp: &&GraspResult| {
            grasp.law == way.law.name()
                && grasp.sensors == way.sensors.name()
                && grasp.stress == way.stress.name
        };
        total(name, &grasps.iter().filter(same).collect::<Vec<_>>())
    };
    ways.iter().map(of).collect()
}

fn print_grasp(args: &GraspArgs, grasp: &GraspResult) -> anyhow::Result<()> {
    if args.json { output::json(grasp) } else { Ok(output::line(&text::grasp(grasp))?) }
}

fn print_totals(args: &GraspArgs, totals: &[Total]) -> anyhow::Result<()> {
    if args.json {
        return totals.iter().try_for_each(output::json);
    }
    match totals {
        [one] => Ok(output::line(&text::total(one))?),
        many => text::table(many),
    }
}

/// One dimension of a table of trials: the names, and the name of a trial.
type Axis<T> = (Vec<String>, fn(&T) -> String);

/// A cell for every combination of names on the axes in `by`; the others are summed up, under the name `all`.
fn cells<T, C>(
    axes: &[Axis<T>; 4],
    by: [bool; 4],
    trials: &[T],
    cell: impl Fn([String; 4], &[&T]) -> C,
) -> Vec<C> {
    const ALL: &str = "all";
    let mut rows = vec![[ALL; 4]];
    for (place, (names, _)) in axes.iter().enumerate().filter(|(place, _)| by[*place]) {
        let mut named = Vec::new();
        for row in rows {
            for name in names {
                let mut row = row;
                row[place] = name.as_str();
                named.push(row);
            }
        }
        rows = named;
    }
    let belongs = |row: &[&str; 4], trial: &T| {
        row.iter().zip(axes).all(|(name, (_, of))| *name == ALL || *name == of(trial))
    };
    let own = |row| trials.iter().filter(|trial| belongs(row, trial)).collect::<Vec<_>>();
    rows.iter().map(|row| cell(row.map(str::to_owned), &own(row))).collect()
}
