//! `gripctl generate`, `train` and `eval`: rows, networks and model files that are the same for the same seed.

use crate::run::{Ran, gripctl, number};
use std::{fs, path::Path};

const COLUMNS: [&str; 4] =
    ["--inputs", "slip_acceleration_m_s2,trial_force_n:ln", "--target", "adequate_force_n:ln"];

fn train(folder: &Path, model: &str, more: &[&str]) -> Ran {
    let args = [&["train", "rows.csv", "--json", "--hidden", "6", "-o", model], &COLUMNS[..], more];
    gripctl(folder, &args.concat())
}

fn folder_with_rows() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, seed) in [("rows.csv", "1"), ("test.csv", "2"), ("again.csv", "1")] {
        let args = ["generate", "-o", name, "--rows", "200", "--seed", seed];
        let out = gripctl(folder.path(), &args).done().out;
        assert!(out.contains("200 rows written"), "{out}");
    }
    let read = |name: &str| fs::read_to_string(folder.path().join(name)).unwrap();
    assert!(read("rows.csv") == read("again.csv") && read("rows.csv") != read("test.csv"));
    assert_eq!(read("rows.csv").lines().count(), 201);
    folder
}

#[test]
fn every_algorithm_trains_a_model_that_evaluates_as_it_said() {
    let folder = folder_with_rows();
    let mut errors = Vec::new();
    for algorithm in ["gd", "gdm", "rprop", "scg", "lm"] {
        let more =
            ["--algorithm", algorithm, "--epochs", "30", "--test", "test.csv", "--seed", "4"];
        let ran = train(folder.path(), "m.json", &more).done();
        let result = ran.json().pop().unwrap();
        assert_eq!((&result["type"], &result["algorithm"]), (&"result".into(), &algorithm.into()));
        assert!((1.0..=30.0).contains(&number(&result, "epochs")), "{result}");
        assert!(result["stop"].is_string() && number(&result, "cpu_s") > 0.0, "{result}");
        for (data, name) in [("rows.csv", "train_mse"), ("test.csv", "test_mse")] {
            let ran = gripctl(folder.path(), &["eval", "m.json", data, "--json"]).done();
            let eval = ran.json().pop().unwrap();
            assert_eq!(eval["rows"], 200);
            assert!((0.0..=1.0).contains(&number(&eval, "within_10pct")), "{eval}");
            let (told, found) = (number(&result, name), number(&eval, "mse"));
            assert!(told > 0.0 && (found / told - 1.0).abs() < 1e-9, "{name}: {told} and {found}");
        }
        errors.push(number(&result, "train_scaled_mse"));
        let first = fs::read(folder.path().join("m.json")).unwrap();
        train(folder.path(), "m.json", &more).done();
        assert!(first == fs::read(folder.path().join("m.json")).unwrap(), "{algorithm}: same seed");
        train(folder.path(), "m.json", &[&more[..6], &["--seed", "5"]].concat()).done();
        assert!(
            first != fs::read(folder.path().join("m.json")).unwrap(),
            "{algorithm}: other seed"
        );
    }
    // Thirty epochs are little for plain descent and plenty for Levenberg and Marquardt.
    assert!(errors[4] < 1e-3 && errors[4] < errors[0], "{errors:?}");
}

#[test]
fn a_trained_model_serves_the_pipeline() {
    let folder = folder_with_rows();
    let more = ["--algorithm", "lm", "--epochs", "60", "--repeats", "3"];
    let ran = train(folder.path(), "force.json", &more).done();
    let result = ran.json().pop().unwrap();
    assert_eq!(result["repeats_scaled_mse"].as_array().unwrap().len(), 3, "{result}");
    let args = ["grasp", "--trials", "2", "--duration", "1.5", "--json", "--model", "force.json"];
    let total = gripctl(folder.path(), &args).done().json().pop().unwrap();
    assert_eq!((&total["trials"], &total["dropped"]), (&2.into(), &0.into()), "{total}");
}

#[test]
fn broken_rows_and_options_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let train = |rows: &str, more: &[&str], code: i32, words: &[&str]| {
        fs::write(folder.path().join("d.csv"), rows).unwrap();
        let args = [&["train", "d.csv", "-o", "m.json"], more].concat();
        gripctl(folder.path(), &args).refused(code, words);
        assert!(!folder.path().join("m.json").exists(), "a model of {words:?}");
    };
    let columns = ["--inputs", "x", "--target", "y"];
    let rows = |rows: &str, words: &[&str]| train(rows, &columns, 1, words);
    rows("", &["d.csv", "no header row"]);
    rows("x,y\n", &["d.csv", "no rows"]);
    rows("x,z\n1,2\n", &["d.csv", "no column \"y\"", "x, z"]);
    rows("x,y\n1,2\n2,abc\n", &["d.csv, line 3, column \"y\"", "\"abc\" is not a finite number"]);
    rows("x,y\n1,NaN\n", &["d.csv, line 2, column \"y\"", "\"NaN\""]);
    rows("x,y\n1,1e39\n", &["d.csv, line 2, column \"y\"", "\"1e39\""]);
    rows("x,y\n1,2,\n", &["d.csv, line 2", "3 fields where the header has 2"]);
    let good = "x,y\n1,2\n2,3\n3,5\n";
    let options = |more: &[&str], words: &[&str]| train(good, more, 2, words);
    options(&["--inputs", "x", "--target", "x"], &["\"x\" is used twice"]);
    options(&["--inputs", "x:log", "--target", "y"], &["x:log", "identity, ln"]);
    options(&["--inputs", "x"], &["--target"]);
    let with = |more: &[&str], words: &[&str]| options(&[&columns[..], more].concat(), words);
    with(&["--algorithm", "adam"], &["--algorithm adam", "gd, gdm, rprop, scg, lm"]);
    with(&["--hidden", "0"], &["0 neurons", "1 to 64"]);
    with(&["--hidden", "1000"], &["1000 neurons", "1 to 64"]);
    with(&["--repeats", "0"], &["0 repeats"]);
    with(&["--goal", "nan"], &["goal", "NaN"]);
    with(&["--goal", "-1"], &["goal", "-1"]);
    train(good, &[&columns[..], &["--test", "gone.csv"]].concat(), 1, &["cannot read gone.csv"]);
    gripctl(folder.path(), &["eval", "gone.json", "d.csv"])
        .refused(2, &["gone.json", "No such file"]);
    for args in [
        &["--rows", "0"][..],
        &["--source", "guess"],
        &["--speed-noise", "nan"],
        &["--force-noise", "-1"],
    ] {
        let name = args[0].trim_start_matches('-').replace('-', "_");
        let ran = gripctl(folder.path(), &[&["generate", "-o", "g.csv"], args].concat());
        assert!(ran.err.replace('-', "_").contains(&name), "{}", ran.err);
        ran.refused(2, &[args[1]].map(|value| if value == "nan" { "NaN" } else { value }));
    }
    gripctl(folder.path(), &["generate", "-o", "gone/g.csv"])
        .refused(1, &["cannot write gone/g.csv"]);
}
