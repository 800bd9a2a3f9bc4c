//! A second model beside the one in force, in simulated grasps and in recordings of them: the grasps are the same to the last bit, and what it
//! would ask for is judged by them.
#![expect(clippy::unwrap_used, reason = "test code")]

use grip_daemon::{
    Item,
    recorder::{About, Recorder, RecordingOptions},
};
use grip_eval::trial;
use grip_fleet::{
    deploy::rehearse,
    recordings::Shelf,
    rollout::{Grasp, Rehearsal, ShadowConfig, Tally, Wrong},
};
use grip_record::mcap::Attached;
use grip_session::{
    HostConfig, Update,
    config::RecordTemplate,
    model::{default_estimator, default_text, parse_estimator},
    recording::MODEL_NAME,
};
use grip_sim::Scene;
use hand::{grasp, scaled};
use slip_core::units::Micros;
use std::{fs, path::Path};

mod hand;

const SCENE: &str = include_str!("../examples/rollouts/slow_lift.toml");
const CONFIG: ShadowConfig = ShadowConfig { alpha: 0.05, most: 1.5 };

/// Grasps of so many objects with a shadow that asks for this share of the force.
fn grasps(share: f64, objects: u64) -> Vec<Grasp> {
    let scene = Scene::from_toml(SCENE).unwrap();
    let in_force = default_estimator().unwrap();
    let shadow = parse_estimator("m.json", &scaled(share).unwrap()).unwrap();
    (0..objects)
        .filter_map(|seed| grasp(&scene, seed, &in_force, Some(&shadow), 2).unwrap())
        .collect()
}

#[test]
fn no_grasp_changes_with_a_shadow() {
    let scene = Scene::from_toml(SCENE).unwrap();
    let in_force = default_estimator().unwrap();
    let beside = grasps(5.0, 12);
    let alone: Vec<Grasp> =
        (0..12).filter_map(|seed| grasp(&scene, seed, &in_force, None, 2).unwrap()).collect();
    let compared = beside.iter().filter(|grasp| grasp.compared.is_some()).count();
    assert!(alone.len() > 9 && compared > 6, "{} {compared}", alone.len());
    let without = beside.iter().map(|grasp| Grasp { compared: None, ..*grasp });
    assert_eq!(without.collect::<Vec<_>>(), alone);
}

#[test]
fn far_too_little_and_far_too_much_are_evident_and_what_is_as_good_is_not() {
    for (share, wanted) in [
        (0.5, Some(Wrong::Low)),
        (0.75, Some(Wrong::Low)),
        (0.95, None),
        (1.0, None),
        (1.05, None),
        (5.0, Some(Wrong::High)),
    ] {
        let mut tally = Tally::default();
        let found = grasps(share, 40).iter().find_map(|grasp| tally.take(grasp, &CONFIG));
        assert_eq!(found, wanted, "{share}: {tally}");
        assert!(found.is_some() || tally.grasps >= CONFIG.needed(), "{share}: {tally}");
    }
}

/// Records a simulated grasp as gripd does.
fn record(file: &Path, seed: u64) {
    let data = default_text().as_bytes().to_vec();
    let (name, media_type) = (MODEL_NAME.to_owned(), "application/json".to_owned());
    let attached = vec![Attached { name, media_type, data }];
    let about = About { program: "test 1".to_owned(), attached, ..About::default() };
    let mut recorder = Recorder::create(file, RecordingOptions::default(), about).unwrap();
    let mut host_us = 0;
    let mut report = |update: Update<'_>| {
        let item = match update {
            Update::Began(beginning) => Item::Began { host_us, beginning },
            Update::Step { index, sample, taxels, .. } => {
                host_us = sample.t.0;
                Item::Sample { host_us, index, sample, taxels }
            }
            Update::Event(ref event) => Item::Event { host_us, event },
            Update::Gripper { .. } | Update::Link(_) => return,
        };
        recorder.take(&item, host_us);
    };
    let scene = grip_sim::scene::load("default").unwrap().reseeded(seed).unwrap();
    let (config, model) = (HostConfig::default(), default_estimator().unwrap());
    trial::grasp(&scene, &config, model, Micros(1_500_000), &mut report).unwrap();
    recorder.finish().unwrap();
}

fn shelf(folder: &Path) -> Result<Shelf, String> {
    let template = format!("{}/run-{{start}}.mcap", folder.display());
    Shelf::new(&RecordTemplate::new(&template).unwrap()).map_err(|error| error.to_string())
}

fn rehearsed(folder: &Path, share: f64) -> Rehearsal {
    let model = parse_estimator("m.json", &scaled(share).unwrap()).unwrap();
    rehearse(&shelf(folder), &model)
}

#[test]
fn recordings_show_what_another_model_would_have_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    for seed in 0..6 {
        record(&folder.path().join(format!("run-2026112{seed}T000000Z.mcap")), seed);
    }
    fs::write(folder.path().join("run-20261129T000000Z.mcap"), "no recording").unwrap();
    for (share, wanted) in
        [(0.5, Some(Wrong::Low)), (1.0, None), (1.05, None), (5.0, Some(Wrong::High))]
    {
        let Rehearsal { recordings, skipped, grasps } = rehearsed(folder.path(), share);
        assert_eq!((recordings, skipped.len()), (6, 1), "{skipped:?}");
        assert!(skipped[0].contains("run-20261129T000000Z.mcap"), "{skipped:?}");
        assert!((4..=6).contains(&grasps.len()), "{grasps:?}");
        let mut tally = Tally::default();
        let found = grasps.iter().find_map(|grasp| tally.take(grasp, &CONFIG));
        assert_eq!(found, wanted, "{share}: {tally}");
    }
}

#[test]
fn no_recording_is_stated_and_is_no_pass() {
    let folder = tempfile::tempdir().unwrap();
    let none =
        |reason: &str| Rehearsal { skipped: vec![reason.to_owned()], ..Rehearsal::default() };
    let shown = rehearsed(folder.path(), 1.0);
    assert_eq!(shown, none("no recording has ended here that could be replayed"));
    let model = default_estimator().unwrap();
    let off = Err("nothing is recorded here".to_owned());
    assert_eq!(rehearse(&off, &model), none("nothing is recorded here"));
}
