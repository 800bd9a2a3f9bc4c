//! `gripctl estimate`: the built-in models side by side, on objects that no training saw.

use crate::run::{gripctl, number};

#[test]
fn the_built_in_models_stand_side_by_side() {
    let folder = tempfile::tempdir().unwrap();
    let ran = gripctl(&folder, "estimate --rows 1000 --json").done();
    let lines = ran.json();
    let names: Vec<(&str, &str)> = lines
        .iter()
        .map(|line| (line["model"].as_str().unwrap(), line["source"].as_str().unwrap()))
        .collect();
    let wanted =
        [("default", "stretch"), ("default", "trial"), ("paper", "stretch"), ("paper", "trial")];
    assert_eq!(names, wanted);
    for line in &lines {
        let (within, trusted) = (number(line, "within_10pct"), number(line, "trusted"));
        if line["model"] == "default" {
            assert!(within >= 0.97 && trusted > 900.0, "{line}");
        } else {
            assert!(within < 0.2 && trusted < 1.0, "{line}");
        }
    }
    let text = gripctl(&folder, "estimate default --rows 100").done().out;
    assert!(text.lines().count() == 3 && text.contains("within 10 %"), "{text}");
}

/// Its weakness is reported, and it runs all the same.
#[test]
fn the_model_of_the_study_runs_and_states_what_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let args = "grasp glass_bottle_empty --trials 1 --duration 1.5";
    let ran = gripctl(&folder, format!("{args} --model paper")).done();
    assert!(ran.err.contains("model paper") && ran.err.contains("none moves the fingers"));
    let ran = gripctl(&folder, args).done();
    assert!(!ran.err.contains("moves the fingers"), "{}", ran.err);
}
