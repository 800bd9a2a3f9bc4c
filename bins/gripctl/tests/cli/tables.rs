//! `gripctl train --auto` and the models beyond one network on the tables of docs/examples.

use crate::run::{gripctl, number};
use std::fs;
use std::path::Path;

const FORCE: &str = "force-sensors.csv --inputs raw,temperature_c --target force_n";
const DRILLING: &str =
    "drilling.csv --inputs feed_mm_rev,speed_rpm,thrust_n,wear_mm --target roughness_um";

/// The file of a table.
fn file(table: &str) -> &str {
    table.split(' ').next().unwrap()
}

fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let examples = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/examples");
    for name in [FORCE, DRILLING].map(file) {
        fs::copy(examples.join(name), folder.path().join(name)).unwrap();
    }
    folder
}

/// On folds of another seed than those it was chosen by, the choice is not worse than the best of mean, line and cubic by more than 3 %.
#[test]
fn the_choice_holds_on_other_folds() {
    let folder = folder();
    for table in [FORCE, DRILLING] {
        let auto = |seed: &str| {
            let more = &format!("--auto -o m.json --json --epochs 200 --seed {seed}");
            gripctl(&folder, format!("train {table} {more}")).done().json()
        };
        let (first, second) = (auto("1"), auto("100"));
        let place = first.iter().position(|line| line["chosen"] == true).unwrap();
        let error = |line: &serde_json::Value| line["held_out"]["mse"].as_f64().unwrap();
        let simple = second
            .iter()
            .filter(|line| ["mean", "line", "cubic"].iter().any(|name| line["learner"] == *name));
        let best = simple.map(error).fold(f64::INFINITY, f64::min);
        assert!(error(&second[place]) <= 1.03 * best, "{table}: {second:#?}");
        let result = second.last().unwrap();
        let eval = gripctl(&folder, format!("eval m.json {} --json", file(table))).done().json();
        let (reported, found) = (number(result, "train_mse"), number(&eval[0], "mse"));
        assert!((found / reported - 1.0).abs() < 1e-6, "{reported} {found}");
    }
}

#[test]
fn every_plain_model_evaluates_as_it_stated_and_is_not_exported() {
    let folder = folder();
    for model in ["mean", "linear", "poly", "gp"] {
        let more = &format!("--model {model} -o m.json --json --force");
        let args = &format!("train {DRILLING} {more}");
        let result = gripctl(&folder, args).last();
        assert_eq!(result["model"], model);
        let eval = gripctl(&folder, format!("eval m.json {} --json", file(DRILLING))).done().json();
        let (reported, found) = (number(&result, "train_mse"), number(&eval[0], "mse"));
        assert!((found / reported - 1.0).abs() < 1e-6, "{model}: {reported} {found}");
        let kind = if model == "gp" { "gp-model" } else { "poly-model" };
        gripctl(&folder, "export m.json --format c").refused(2, &[kind, "run in real time"]);
    }
}
