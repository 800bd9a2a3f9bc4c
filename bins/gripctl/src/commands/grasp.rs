//! `gripctl grasp`: many simulated objects in the gripper.

use super::{estimator, host_config};
use crate::{cli::GraspArgs, output, output::or_dash};
use grip_host::{
    HostConfig, HostEstimator,
    exit::{Exit, WrongArgument},
    scene,
    score::Quantiles,
    trial::{self, Outcome},
};
use grip_sim::Scene;
use indicatif::{ParallelProgressIterator as _, ProgressBar, ProgressStyle};
use rayon::iter::{IntoParallelIterator as _, ParallelIterator as _};
use serde::Serialize;
use slip_core::units::Micros;

/// One grasp.
#[derive(Clone, Serialize)]
struct Grasp {
    #[serde(rename = "type")]
    kind: &'static str,
    scene: String,
    seed: u64,
    held: bool,
    dropped: bool,
    crushed: bool,
    /// For a dropped object: whether a controller that knows everything would have kept it.
    holdable: Option<bool>,
    slip_mm: f64,
    slips: u64,
    force_needed_n: f64,
    force_final_n: f64,
    force_peak_n: f64,
    force_ratio: f64,
    peak_command_n: f32,
}

/// All grasps of a scene.
#[derive(Serialize)]
struct Total {
    scene: String,
    trials: usize,
    dropped: usize,
    crushed: usize,
    /// Dropped although a controller that knows everything would have kept it.
    dropped_holdable: usize,
    slip_mm: Quantiles,
    force_ratio: Quantiles,
    peak_ratio: Quantiles,
    /// Final force within 1.0 to 1.6 of the needed one.
    within_1_6: usize,
    /// Final force within 1.0 to 1.4 of the needed one.
    within_1_4: usize,
    /// Highest force that was commanded or applied (N).
    peak_n: f64,
    slips: Quantiles,
}

pub(crate) fn run(args: &GraspArgs) -> anyhow::Result<Exit> {
    if !(args.duration > 0.0 && args.duration <= 600.0) {
        let message =
            format!("--duration {}: expected seconds, more than 0 and up to 600", args.duration);
        return Err(WrongArgument(message).into());
    }
    let config = host_config(args.config.as_deref())?;
    let estimator = estimator(args.model.as_deref(), &config)?;
    let mut all = Vec::new();
    for name in scene_names(args)? {
        let scene = scene::load(&name)?;
        let grasps = grasp_many(args, &scene, &config, &estimator)?;
        if args.each {
            for grasp in &grasps {
                print_grasp(args, grasp)?;
            }
        }
        print_total(args, &total(&scene.config().name, &grasps))?;
        all.extend(grasps);
    }
    print_total(args, &total("all", &all))?;
    Ok(Exit::Done)
}

fn scene_names(args: &GraspArgs) -> anyhow::Result<Vec<String>> {
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

fn grasp_many(
    args: &GraspArgs,
    scene: &Scene,
    config: &HostConfig,
    estimator: &HostEstimator,
) -> anyhow::Result<Vec<Grasp>> {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "0 to 600 s, checked"
    )]
    let duration = Micros((args.duration * 1e6) as u64);
    let bar = ProgressBar::new(args.trials);
    if let Ok(style) = ProgressStyle::with_template("{msg:12} {bar:30} {pos}/{len} grasps") {
        bar.set_style(style);
    }
    bar.set_message(scene.config().name.clone());
    (0..args.trials)
        .into_par_iter()
        .progress_with(bar)
        .map(|trial| {
            let seed = args.seed.wrapping_add(trial);
            let scene = scene.reseeded(seed)?;
            let outcome = trial::grasp(&scene, config, estimator.clone(), duration, &mut |_| ())?;
            let holdable = outcome.truth.dropped().then(|| trial::could_be_held(&scene, config));
            Ok(grasp_of(&scene.config().name, seed, &outcome, holdable))
        })
        .collect()
}

fn grasp_of(scene: &str, seed: u64, outcome: &Outcome, holdable: Option<bool>) -> Grasp {
    let truth = outcome.truth;
    Grasp {
        kind: "grasp",
        scene: scene.to_owned(),
        seed,
        held: outcome.held(),
        dropped: truth.dropped(),
        crushed: truth.crushed,
        holdable,
        slip_mm: truth.slip_mm(),
        slips: outcome.slips,
        force_needed_n: truth.force_needed_n,
        force_final_n: truth.applied_n,
        force_peak_n: truth.force_peak_n,
        force_ratio: outcome.force_ratio(),
        peak_command_n: outcome.peak_command_n,
    }
}

fn total(scene: &str, grasps: &[Grasp]) -> Total {
    let count = |test: &dyn Fn(&Grasp) -> bool| grasps.iter().filter(|g| test(g)).count();
    let kept = || grasps.iter().filter(|g| !g.dropped);
    #[expect(clippy::cast_precision_loss, reason = "a count of slips")]
    let slips = Quantiles::of(grasps.iter().map(|g| g.slips as f64).collect());
    Total {
        scene: scene.to_owned(),
        trials: grasps.len(),
        dropped: count(&|g| g.dropped),
        crushed: count(&|g| g.crushed),
        dropped_holdable: count(&|g| g.holdable == Some(true)),
        slip_mm: Quantiles::of(kept().map(|g| g.slip_mm).collect()),
        force_ratio: Quantiles::of(kept().map(|g| g.force_ratio).collect()),
        peak_ratio: Quantiles::of(kept().map(|g| g.force_peak_n / g.force_needed_n).collect()),
        within_1_6: count(&|g| (1.0..=1.6).contains(&g.force_ratio)),
        within_1_4: count(&|g| (1.0..=1.4).contains(&g.force_ratio)),
        peak_n: grasps
            .iter()
            .map(|g| g.force_peak_n.max(f64::from(g.peak_command_n)))
            .fold(0.0, f64::max),
        slips,
    }
}

fn print_grasp(args: &GraspArgs, grasp: &Grasp) -> anyhow::Result<()> {
    if args.json {
        return output::json(grasp);
    }
    let fate = if grasp.dropped {
        "dropped"
    } else if grasp.crushed {
        "crushed"
    } else {
        "held"
    };
    Ok(output::line(&format!(
        "{:12} seed {:4}  {fate:8} slip {:6.2} mm in {:2} slips, force {:6.2} N of {:6.2} N needed (x {:.2}), peak {:6.2} N",
        grasp.scene,
        grasp.seed,
        grasp.slip_mm,
        grasp.slips,
        grasp.force_final_n,
        grasp.force_needed_n,
        grasp.force_ratio,
        grasp.force_peak_n
    ))?)
}

fn print_total(args: &GraspArgs, total: &Total) -> anyhow::Result<()> {
    if args.json {
        return output::json(total);
    }
    Ok(output::line(&format!(
        "{:12} {} grasps: {} dropped ({} of them holdable), {} crushed; slip median {} mm, 95 % {} mm; final force over needed median {}, 95 % {}; within 1.0-1.6: {}, within 1.0-1.4: {}; highest force {:.1} N",
        total.scene,
        total.trials,
        total.dropped,
        total.dropped_holdable,
        total.crushed,
        or_dash(total.slip_mm.p50, 2),
        or_dash(total.slip_mm.p95, 2),
        or_dash(total.force_ratio.p50, 2),
        or_dash(total.force_ratio.p95, 2),
        total.within_1_6,
        total.within_1_4,
        total.peak_n
    ))?)
}
