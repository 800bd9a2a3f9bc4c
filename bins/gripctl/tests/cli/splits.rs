//! `gripctl train` with rows kept away from the training: by share, by group, by folds.

use crate::run::{Ran, gripctl, number, put, read};
use tempfile::TempDir;

/// Four stretches of each of 30 objects.
fn rows() -> String {
    let mut csv = String::from("object,x,y\n");
    for row in 0..120 {
        let x = f64::from(row % 40) / 40.0;
        csv.push_str(&format!("o{},{x},{}\n", row / 4, x * x + 1.0));
    }
    csv
}

fn train(folder: &TempDir, more: &str) -> Ran {
    let args = "train d.csv --inputs x --target y --json --epochs 60 --hidden 4 -o m.json";
    gripctl(folder, format!("{args} {more}"))
}

fn folder() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    put(&folder, "d.csv", rows());
    folder
}

#[test]
fn a_share_is_held_out_and_reported() {
    let folder = folder();
    let more = "--holdout 0.2 --validation 0.25 --split-by object --split-seed 3";
    let result = train(&folder, more).last();
    assert_eq!(
        [&result["train_rows"], &result["validation_rows"], &result["test_rows"]],
        [72, 24, 24],
        "{result}"
    );
    assert!(number(&result, "test_mse") >= 0.0);
    let model = read(&folder, "m.json");
    let model: serde_json::Value = serde_json::from_str(&model).unwrap();
    let split = &model["training"]["split"];
    assert_eq!((&split["by"], &split["seed"]), (&"object".into(), &3.into()), "{split}");
    assert_eq!((&split["holdout"], &split["validation"]), (&0.2.into(), &0.25.into()), "{split}");
    gripctl(&folder, "eval m.json d.csv --json").done();
    let again = train(&folder, more).last();
    assert_eq!(again["test_mse"], result["test_mse"]);
    let other = "--holdout 0.2 --split-by object --split-seed 4";
    let other = train(&folder, other).last();
    assert_ne!(other["test_mse"], result["test_mse"]);
}

#[test]
fn folds_test_every_row_once_and_the_model_still_comes() {
    let folder = folder();
    let lines = train(&folder, "--folds 4 --split-by object").done().json();
    assert_eq!(lines.len(), 6, "{lines:?}");
    for (at, fold) in lines[..4].iter().enumerate() {
        assert_eq!((&fold["type"], &fold["fold"]), (&"fold".into(), &(at + 1).into()));
        assert_eq!(number(fold, "train_rows") + number(fold, "test_rows"), 120.0, "{fold}");
    }
    assert_eq!((&lines[4]["type"], &lines[4]["rows"]), (&"folds".into(), &120.into()));
    assert_eq!((&lines[5]["type"], &lines[5]["train_rows"]), (&"result".into(), &120.into()));
    let mean =
        lines[..4].iter().map(|f| number(f, "test_mse") * number(f, "test_rows")).sum::<f64>();
    assert!((mean / 120.0 - number(&lines[4], "test_mse")).abs() < 1e-12, "{lines:?}");
    let out = gripctl(&folder, "train d.csv --inputs x --target y -o m.json --folds 3").done().out;
    assert!(out.contains("fold 3 of 3") && out.contains("120 rows each tested once"), "{out}");
}
