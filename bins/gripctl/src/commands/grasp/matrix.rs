//! `gripctl grasp --matrix`: grippers by sensors by laws.

use super::super::{estimator, host_config};
use super::{duration, grasp_many, print_grasp, scene_names};
use crate::{cli::grasp::GraspArgs, output, table};
use grip_eval::grasp::{
    Bench, Law, Way,
    matrix::{MatrixRow, own_is_first, rows},
};
use grip_session::exit::{Exit, WrongArgument};
use grip_sim::{
    Scene, SceneError,
    scene::{self, GRIPPERS, Part, SENSORS},
};

/// The laws of a cell.
const LAWS: [Law; 5] = [Law::Own, Law::Fixed, Law::Pr2, Law::Fft, Law::Oracle];

/// What was asked for, or everything that is built in.
fn names(asked: &[String], built_in: &[(&str, &str)]) -> Vec<String> {
    let known = || built_in.iter().map(|(name, _)| (*name).to_owned()).collect();
    if asked.is_empty() { known() } else { asked.to_vec() }
}

/// `scene` with the gripper and the sensors of `args`, where they are named.
pub(super) fn equipped(args: &GraspArgs, scene: Scene) -> Result<Scene, SceneError> {
    let equip = &args.equip;
    let parts = [
        equip.gripper.iter().map(|name| Part::gripper(name)).collect::<Vec<_>>(),
        equip.sensing.iter().map(|name| Part::sensors(name)).collect(),
    ];
    parts.into_iter().flatten().try_fold(scene, |scene, part| scene.with(&part?))
}

pub(super) fn run(args: &GraspArgs) -> anyhow::Result<Exit> {
    let config = host_config(args.config.as_deref())?;
    let estimator = estimator(args.model.as_deref(), &config)?;
    let bench = Bench { config, estimator, duration: duration(args)? };
    let grippers = names(&args.equip.gripper, &GRIPPERS);
    let sensing = names(&args.equip.sensing, &SENSORS);
    let asked = super::ways(args);
    let [Way { stress, .. }] = asked[..] else {
        return Err(WrongArgument("--matrix takes one --stress".to_owned()).into());
    };
    let ways = LAWS.map(|law| Way { law, stress, ..Way::default() });
    let mut cells = Vec::new();
    for name in scene_names(args)? {
        let scene = scene::open(&name)?;
        for gripper in &grippers {
            let scene = scene.with(&Part::gripper(gripper)?)?;
            for sensing in &sensing {
                let scene = scene.with(&Part::sensors(sensing)?)?;
                let grasps = grasp_many(args, &scene, &ways, &bench)?;
                if args.each {
                    grasps.iter().try_for_each(|grasp| print_grasp(args, grasp))?;
                }
                let rows = rows(gripper, sensing, &LAWS, &grasps);
                print(args, &rows)?;
                cells.push(rows);
            }
        }
    }
    if !args.json {
        summary(&cells)?;
    }
    Ok(Exit::Done)
}

fn print(args: &GraspArgs, rows: &[MatrixRow]) -> anyhow::Result<()> {
    if args.json {
        return rows.iter().try_for_each(output::json);
    }
    let lost = ["dropped", "crushed", "lost % (95 %)=lost_share%"];
    let kept = ["lost_of_kept", "kept_by_oracle", "% (95 %)=lost_of_kept_share%", "slip_mm"];
    let forces = ["peak/needed=peak_ratio", "final/needed=force_ratio"];
    table::print(rows, &[&["gripper", "sensing", "law"][..], &lost, &kept, &forces].concat())?;
    Ok(output::line("")?)
}

/// Where gripd loses no more than any older law, and the cells in which one loses fewer.
fn summary(cells: &[Vec<MatrixRow>]) -> anyhow::Result<()> {
    let behind: Vec<String> = cells
        .iter()
        .filter(|rows| !own_is_first(rows))
        .filter_map(|rows| rows.first().map(|row| format!("{} with {}", row.gripper, row.sensing)))
        .collect();
    let first = cells.len() - behind.len();
    output::line(&format!(
        "gripd loses no more than any older law in {first} of {} cells",
        cells.len()
    ))?;
    if behind.is_empty() {
        return Ok(());
    }
    Ok(output::line(&format!("an older law loses fewer: {}", behind.join(", ")))?)
}
