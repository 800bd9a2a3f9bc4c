//! `gripctl grasp`: many simulated objects, the same every time.

use crate::run::{gripctl, number};

#[test]
fn ten_objects_are_held_the_same_way_every_time() {
    let folder = tempfile::tempdir().unwrap();
    let args = ["grasp", "--trials", "10", "--json"];
    let ran = gripctl(folder.path(), &args).done();
    assert_eq!(ran.out, gripctl(folder.path(), &args).done().out);
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

#[test]
fn every_grasp_can_be_told() {
    let folder = tempfile::tempdir().unwrap();
    let args = [
        "grasp",
        "light_rough",
        "--trials",
        "2",
        "--seed",
        "7",
        "--duration",
        "1.5",
        "--each",
        "--json",
    ];
    let ran = gripctl(folder.path(), &args).done();
    let lines = ran.json();
    let seeds: Vec<f64> = lines
        .iter()
        .filter(|line| line["type"] == "grasp")
        .map(|line| number(line, "seed"))
        .collect();
    assert_eq!((lines.len(), seeds), (4, vec![7.0, 8.0]));
    assert!(lines.iter().take(2).all(|line| line["held"] == true), "{}", ran.out);
    let text =
        gripctl(folder.path(), &["grasp", "light_rough", "--trials", "1", "--duration", "1.5"]);
    assert!(text.done().out.contains("1 grasps: 0 dropped"));
}
