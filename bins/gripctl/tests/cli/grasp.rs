//! `gripctl grasp`: many simulated objects, the same every time.

use crate::run::{gripctl, number, put, read};
use std::fs;
use std::path::Path;

#[test]
fn ten_objects_are_held_the_same_way_every_time() {
    let folder = tempfile::tempdir().unwrap();
    let args = "grasp --trials 10 --json";
    let ran = gripctl(&folder, args).done();
    assert_eq!(ran.out, gripctl(&folder, args).done().out);
    let lines = ran.json();
    let scenes: Vec<&str> = lines.iter().map(|line| line["scene"].as_str().unwrap()).collect();
    assert_eq!(scenes, ["default", "all"]);
    for line in &lines {
        assert_eq!(
            (&line["trials"], &line["dropped"], &line["crushed"]),
            (&10.into(), &0.into(), &0.into()),
            "{line}"
        );
        for name in ["slip_mm", "force_ratio"] {
            let (p50, p95) = (number(&line[name], "p50"), number(&line[name], "p95"));
            assert!(0.0 < p50 && p50 <= p95, "{line}");
        }
        assert!(
            number(&line["force_ratio"], "p50") >= 1.0 && number(line, "peak_n") <= 60.0,
            "{line}"
        );
    }
}

/// Noise close to the force that counts as touch: open fingers touched nothing, and did not close, while that was a touch.
#[test]
fn a_noisy_force_sensor_grips() {
    let folder = tempfile::tempdir().unwrap();
    put(&folder, "noisy.toml", "name = \"noisy\"\n[noise]\nforce_mn = 40\n");
    let args = "grasp noisy.toml --trials 6 --seed 3000 --json";
    let line = gripctl(&folder, args).done().json().remove(0);
    assert_eq!((&line["dropped"], &line["crushed"]), (&0.into(), &0.into()), "{line}");
}

#[test]
fn every_grasp_can_be_reported() {
    let folder = tempfile::tempdir().unwrap();
    let args = "grasp light_rough --trials 2 --seed 7 --duration 1.5 --each --json";
    let ran = gripctl(&folder, args).done();
    let lines = ran.json();
    let seeds: Vec<f64> = lines
        .iter()
        .filter(|line| line["type"] == "grasp")
        .map(|line| number(line, "seed"))
        .collect();
    assert_eq!((lines.len(), seeds), (4, vec![7.0, 8.0]));
    assert!(lines.iter().take(2).all(|line| line["held"] == true), "{}", ran.out);
    let text = gripctl(&folder, "grasp light_rough --trials 1 --duration 1.5");
    assert!(text.done().out.contains("1 grasps: 0 dropped"));
}

#[test]
fn ways_of_grasping_stand_beside_each_other() {
    let folder = tempfile::tempdir().unwrap();
    let common = "grasp raw_egg foam --trials 2 --duration 1.5";
    let with = |more: &str| gripctl(&folder, format!("{common} {more}"));
    let lines = with("--compare --json").done().json();
    assert_eq!(lines.len(), 3 * 9);
    let all: Vec<(&str, &str)> = lines
        .iter()
        .filter(|line| line["scene"] == "all")
        .map(|line| (line["law"].as_str().unwrap(), line["sensors"].as_str().unwrap()))
        .collect();
    assert_eq!(all[..2], [("gripd", "stylus"), ("gripd", "travel")]);
    assert_eq!(all[8..], [("oracle", "travel")]);
    let fixed =
        lines.iter().find(|line| line["scene"] == "foam" && line["law"] == "fixed").unwrap();
    assert_eq!((&fixed["crushed"], &fixed["roomy_crushed"]), (&2.into(), &2.into()), "{fixed}");
    // 20 N on foam of a few newtons.
    assert!(number(&fixed["peak_ratio"], "p50") > 10.0, "{fixed}");

    let text = with("--baseline oracle,gripd --stress=none,noise").done().out;
    for part in ["raw_egg: 2 grasps each", "final/needed", "all: 4 grasps each"] {
        assert!(text.contains(part), "{part} in {text}");
    }
    for way in [["oracle", "noise"], ["gripd", "none"]] {
        let rows = text.lines().filter(|line| way.iter().all(|word| line.contains(word)));
        assert_eq!(rows.count(), 3, "{way:?} in {text}");
    }
    let troubles = with("--stress --json").done().json();
    assert_eq!(troubles.len(), 3 * 9);
}

#[test]
fn grippers_by_sensors_by_laws_stand_in_a_table() {
    let folder = tempfile::tempdir().unwrap();
    put(&folder, "weak.toml", "[drive]\nforce_max_n = 0.5\n");
    let common = "grasp --trials 2 --duration 1.0 --gripper";
    let with = |more: &str| gripctl(&folder, format!("{common} {more}"));
    let cells = "direct,weak.toml --sensing usb_16ms --matrix";
    let rows = with(&format!("{cells} --json")).done().json();
    assert_eq!(rows.len(), 2 * 5);
    let oracle = |row: &&serde_json::Value| row["law"] == "oracle";
    let oracles: Vec<_> = rows.iter().filter(oracle).collect();
    assert_eq!(
        (&oracles[0]["gripper"], &oracles[0]["kept_by_oracle"]),
        (&"direct".into(), &2.into())
    );
    // Half a newton lifts nothing: no law can be asked to.
    assert_eq!((&oracles[1]["lost"], &oracles[1]["kept_by_oracle"]), (&2.into(), &0.into()));
    let text = with(cells).done().out;
    assert!(text.contains("weak.toml") && text.contains("of 2 cells"), "{text}");

    let single = with("weak.toml --json").done().json();
    assert_eq!(single[0]["dropped"], 2, "{single:?}");
}

/// What gripd measures in slips is what `gripctl train` learns from, and the model that comes of it holds the objects.
#[test]
fn slips_become_rows_that_a_model_is_trained_on() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    fs::write(at.join("at_once.toml"), "name = \"at_once\"\nlift_ramp_s = 0\n").unwrap();
    let read = |model: &str, seed: &str| {
        let grasp = "grasp at_once.toml --trials 8 --json --rows rows.csv";
        let totals = gripctl(at, format!("{grasp} --model {model} --seed {seed}")).done().json();
        assert_eq!((&totals[0]["trials"], &totals[0]["dropped"]), (&8.into(), &0.into()));
        fs::read_to_string(at.join("rows.csv")).unwrap()
    };
    let rows = read("default", "100");
    let mut lines = rows.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let names = lines.next().unwrap();
    let place = |name: &str| names.iter().position(|column| *column == name).unwrap();
    let (needed, adequate) = (place("needed_force_n"), place("adequate_force_n"));
    assert!(lines.clone().count() > 50);
    for cells in lines {
        let value = |place: usize| cells[place].parse::<f64>().unwrap();
        assert_eq!((cells[0], cells.len()), ("at_once", names.len()));
        assert!((value(adequate) / value(needed) - 1.2).abs() < 1e-6);
    }
    let inputs = "slip_acceleration_m_s2,trial_force_n:ln";
    let target = "--target adequate_force_n:ln --algorithm scg --epochs 200";
    let train = &format!("train rows.csv --inputs {inputs} --output model.json");
    gripctl(at, format!("{train} {target}")).done();
    assert_ne!(read("model.json", "200"), "");
}

#[test]
fn the_result_is_drawn() {
    let folder = tempfile::tempdir().unwrap();
    let run = |more: &str| {
        let common = "grasp raw_egg --trials 2 --duration 1.2 --plot a.svg";
        gripctl(&folder, format!("{common} {more}")).done();
        read(&folder, "a.svg")
    };
    let single = run("");
    assert!(single.contains("2 of 2 objects held") && single.contains("at the end"), "{single}");
    let several = run("--baseline all");
    assert!(several.contains("Objects lost") && several.contains(">fft<"), "{several}");
}

#[test]
fn sensor_faults_stand_in_a_table_with_its_totals() {
    let folder = tempfile::tempdir().unwrap();
    let common = "grasp --faults --trials 1 --fault-sensor travel --fault nan,gain+30 --phase first --friction coulomb,viscous60";
    let with = |more: &str| gripctl(&folder, format!("{common} {more}")).done();
    let lines = with("--json --each").json();
    let of = |kind: &str| lines.iter().filter(|line| line["type"] == kind).collect::<Vec<_>>();
    assert_eq!((of("fault_trial").len(), of("fault").len()), (4, 4));
    // Two by sensor and fault, one by sensor, two by fault, one by phase, two by friction, and all.
    let totals = of("fault_total");
    assert_eq!(totals.len(), 9);
    let all = totals.last().unwrap();
    assert_eq!((&all["sensor"], &all["trials"]), (&"all".into(), &4.into()), "{all}");
    assert_eq!((&all["oracle_lost"], &all["dropped_sound"]), (&0.into(), &0.into()), "{all}");
    let text = with("").out;
    for part in ["every cell", "by sensor and fault", "viscous60", "gain+30", "peak/needed"] {
        assert!(text.contains(part), "{part} in {text}");
    }
}

#[test]
fn stalls_stand_in_a_table() {
    let folder = tempfile::tempdir().unwrap();
    let lines = gripctl(&folder, "grasp --stalls --trials 1 --json").done().json();
    let cells = lines.iter().filter(|line| line["type"] == "stall").count();
    assert_eq!((cells, lines.len()), (60, 80));
    assert!(lines.iter().all(|line| line["oracle_dropped"] == 0));
}

/// The same objects ten times under one name, and then another one; a table of both, with memory and without.
#[test]
fn what_is_remembered_of_an_object_spares_it_slips() {
    let folder = tempfile::tempdir().unwrap();
    let scene = include_str!("../../../../docs/examples/scenes/in_50_ms.toml");
    put(&folder, "scene.toml", scene);
    let args = "grasp scene.toml --memory --sensors travel --seed 3000";
    let more = "--trials 2 --duration 2 --json";
    let ran = gripctl(&folder, format!("{args} {more}")).done();
    let lines = ran.json();
    assert_eq!(lines.len(), 24, "{}", ran.out);
    let slip_mm = |memory: bool| {
        let tenth = lines.iter().find(|line| line["grasp"] == 10 && line["memory"] == memory);
        number(&tenth.unwrap()["slip_mm"], "p50")
    };
    assert!(slip_mm(true) < 0.5 * slip_mm(false), "{}", ran.out);
    for line in lines.iter().filter(|line| line["grasp"].as_u64() <= Some(10)) {
        let lost = (&line["dropped"], &line["crushed"], &line["noticed"]);
        assert_eq!(lost, (&0.into(), &0.into(), &0.into()), "{line}");
    }
}

/// A blow is not what an object needs, and pads that sink are no slip: neither is learned.
#[test]
fn objects_that_are_hit_or_shaken_are_not_crushed_for_what_is_remembered() {
    let args = "grasp bump shaken --memory --sensors travel --seed 5001";
    let ran = gripctl(Path::new("."), format!("{args} --trials 2 --json")).done();
    let lines = ran.json();
    assert_eq!(lines.len(), 48, "{}", ran.out);
    for line in lines.iter().filter(|line| line["grasp"].as_u64() <= Some(10)) {
        assert_eq!((&line["dropped"], &line["crushed"]), (&0.into(), &0.into()), "{line}");
    }
}

#[test]
fn objects_that_are_remembered_stand_in_a_table() {
    let folder = tempfile::tempdir().unwrap();
    let text = "[bottle]\nneeded_n = { value = 5.0, deviation = 0.1, grasps = 4 }\n";
    put(&folder, "objects.toml", text);
    let lines = gripctl(&folder, "objects objects.toml --json").done().json();
    assert_eq!((lines.len(), &lines[0]["name"]), (1, &"bottle".into()));
    let expected_n = number(&lines[0], "expected_n");
    assert!((expected_n - 6.3).abs() < 1e-5, "1.2 times 5 N and 5 %: {expected_n}");
    let table = gripctl(&folder, "objects objects.toml").done().out;
    assert!(table.contains("bottle") && table.contains("5.00 +-5 %"), "{table}");
}
