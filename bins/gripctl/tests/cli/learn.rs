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
fn every_algorithm_trains_a_model_that_evaluates_as_it_stated() {
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
            let (reported, found) = (number(&result, name), number(&eval, "mse"));
            assert!(
                reported > 0.0 && (found / reported - 1.0).abs() < 1e-9,
                "{name}: {reported} and {found}"
            );
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

/// Limits from rows that were held out: in the file of a network and of an ensemble, in `eval` of rows with the same noise, and in C.
#[test]
fn an_interval_holds_on_rows_that_no_training_saw() {
    let folder = tempfile::tempdir().unwrap();
    let run = |args: &[&str]| gripctl(folder.path(), args);
    for (name, rows, seed) in [("rows.csv", "150", "1"), ("unseen.csv", "1000", "2")] {
        let noise = ["--speed-noise", "0.03", "--force-noise", "0.03"];
        let args = ["generate", "-o", name, "--rows", rows, "--seed", seed, "--source", "trial"];
        run(&[&args[..], &noise].concat()).done();
    }
    let few = ["--epochs", "60", "--interval", "0.9"];
    for (model, more) in [
        ("rprop.json", &["--algorithm", "rprop"][..]),
        ("br.json", &["--algorithm", "br"]),
        ("ensemble.json", &["--model", "ensemble", "--members", "3"]),
        ("gp.json", &["--model", "gp"]),
        ("poly.json", &["--model", "poly"]),
        ("svr.json", &["--model", "svr"]),
    ] {
        let result = train(folder.path(), model, &[more, &few].concat()).done().json().pop();
        let result = result.unwrap();
        let width = result["interval"]["widths"][0].as_f64().unwrap();
        assert!((1.0..3.0).contains(&width) && number(&result, "held_out_r2") > 0.5, "{result}");
        assert_eq!(
            (&result["interval"]["level"], &result["worse_than_mean"]),
            (&0.9.into(), &false.into())
        );
        let eval = run(&["eval", model, "unseen.csv", "--json"]).done().json().pop().unwrap();
        let coverage = number(&eval, "coverage");
        assert!((0.84..0.96).contains(&coverage) && eval["interval"] == 0.9, "{model}: {eval}");
        let text = run(&["eval", model, "unseen.csv"]).done().out;
        assert!(text.contains(&format!("90 % interval holds {:.1} %", 100.0 * coverage)), "{text}");
    }
    run(&["export", "rprop.json", "--format", "c", "--verify"]).done();
    let plain = ["--epochs", "5", "--interval"];
    for (more, why) in [
        (&[&plain[..], &["1.5"]].concat()[..], "must be between 0 and 1"),
        (&[&plain[..], &["0.999"]].concat(), "needs at least 999"),
        (&["--auto", "--card", "c.json"], "cannot be used with"),
    ] {
        train(folder.path(), "m.json", more).refused(2, &[why]);
    }
}

/// Rows far from zero, rows that show nothing, and a training that learned nothing.
#[test]
fn training_keeps_digits_and_states_what_speaks_against_it() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, n: u32, y: &dyn Fn(f64) -> f64| {
        let row = |i: u32| format!("{},4,{}\n", f64::from(i) / 100.0, y(f64::from(i) / 100.0));
        let rows: String = (0..n).map(row).collect();
        fs::write(folder.path().join(name), format!("a,b,y\n{rows}")).unwrap();
    };
    let run = |data: &str, more: &[&str]| {
        let args = ["train", data, "--inputs", "a,b", "--target", "y", "-o", "m.json", "--json"];
        gripctl(folder.path(), &[&args[..], more].concat())
    };
    write("far.csv", 200, &|x| 1e9 + x.sin());
    for precision in ["f32", "f64"] {
        let more = ["--algorithm", "scg", "--epochs", "200", "--precision", precision];
        let ran = run("far.csv", &more).done();
        let result = ran.json().pop().unwrap();
        assert!(
            number(&result, "train_mse") < 1e-3 && number(&result, "train_r2") > 0.99,
            "{result}"
        );
        assert!(result["worse_than_mean"].is_null(), "rows that it has learned do not judge");
        for words in ["input \"b\" is 4 in every row", "will see a constant", "no model for gripd"]
        {
            assert!(ran.err.contains(words), "{}", ran.err);
        }
        let eval = gripctl(folder.path(), &["eval", "m.json", "far.csv"]).done();
        assert!(eval.out.contains("R2 1.0") && eval.err.is_empty(), "{eval:?}");
    }
    write("other.csv", 200, &|x| 1e9 - x.sin());
    let eval = gripctl(folder.path(), &["eval", "m.json", "other.csv"]).done();
    assert!(eval.err.contains("no better than answering their mean"), "{}", eval.err);
    write("same.csv", 3, &|_| 5.0);
    let args = ["train", "same.csv", "--inputs", "a", "--target", "y", "-o", "m.json"];
    let same = gripctl(folder.path(), &args).done();
    assert!(same.err.contains("target \"y\" is 5 in every row"), "{}", same.err);
    assert!(same.err.contains("3 rows for 31 weights"), "{}", same.err);
    assert!(
        same.out.contains("the target does not vary") && !same.out.contains("100.0 %"),
        "{same:?}"
    );
    fs::remove_file(folder.path().join("m.json")).unwrap();
    run("far.csv", &["--algorithm", "gd", "--rate", "1e5"]).refused(1, &["diverged at once"]);
    assert!(!folder.path().join("m.json").exists());
}

/// Ensembles and support vector regressions: the result line, the file, `eval` of it, and a place in the pipeline for the former alone.
#[test]
fn learners_beyond_one_network_evaluate_as_they_stated() {
    let folder = folder_with_rows();
    for (model, more) in [
        ("ensemble", &["--members", "3", "--epochs", "60", "--algorithm", "scg"][..]),
        ("ensemble", &["--members", "3", "--epochs", "60", "--algorithm", "scg", "--bagging"]),
        ("svr", &["--svr-c", "10"]),
        ("svr", &["--svr-c", "100", "--svr-gamma", "0.3"]),
    ] {
        let more = [&["--model", model, "--test", "test.csv"], more].concat();
        let result = train(folder.path(), "b.json", &more).done().json().pop().unwrap();
        assert_eq!((&result["type"], &result["model"]), (&"result".into(), &model.into()));
        for (data, name) in [("rows.csv", "train_mse"), ("test.csv", "test_mse")] {
            let eval = gripctl(folder.path(), &["eval", "b.json", data, "--json"]).done();
            let (reported, found) = (number(&result, name), number(&eval.json()[0], "mse"));
            assert!(
                reported > 0.0 && (found / reported - 1.0).abs() < 1e-6,
                "{name}: {reported} and {found}"
            );
        }
        assert!(number(&result, "test_within_10pct") > 0.5, "{result}");
        let first = fs::read(folder.path().join("b.json")).unwrap();
        train(folder.path(), "b.json", &more).done();
        assert!(first == fs::read(folder.path().join("b.json")).unwrap(), "{model}: same seed");
        let grasp = gripctl(folder.path(), &["grasp", "--trials", "1", "--model", "b.json"]);
        if model == "ensemble" {
            grasp.done();
        } else {
            grasp.refused(2, &["b.json", "svr-model", "only one network"]);
        }
    }
}

#[test]
fn other_activations_train_models_that_serve() {
    let folder = folder_with_rows();
    for activation in ["logistic", "relu"] {
        let more = ["--activation", activation, "--algorithm", "scg", "--epochs", "80"];
        let result = train(folder.path(), "a.json", &more).done().json().pop().unwrap();
        let eval = gripctl(folder.path(), &["eval", "a.json", "rows.csv", "--json"]).done();
        let (reported, found) = (number(&result, "train_mse"), number(&eval.json()[0], "mse"));
        assert!((found / reported - 1.0).abs() < 1e-9, "{activation}: {reported} and {found}");
        let text = fs::read_to_string(folder.path().join("a.json")).unwrap();
        assert!(text.contains(&format!("\"{activation}\"")), "{text}");
    }
}

#[test]
fn a_search_reports_its_best_networks_and_writes_the_first() {
    let folder = folder_with_rows();
    let search = |seed: &str, more: &[&str]| {
        let args = ["search", "rows.csv", "-o", "s.json", "--json", "--generations", "2"];
        let small = ["--population", "6", "--epochs", "30", "--repeats", "1", "--seed", seed];
        gripctl(folder.path(), &[&args[..], &COLUMNS, &small, more].concat())
    };
    let ran = search("3", &["--test", "test.csv", "--group", "object"]).done();
    let mut lines = ran.json();
    let result = lines.pop().unwrap();
    assert!(!lines.is_empty() && lines.len() <= 10, "{}", ran.out);
    let costs: Vec<f64> = lines.iter().map(|line| number(line, "cost")).collect();
    assert!(costs.windows(2).all(|pair| pair[0] <= pair[1]), "{costs:?}");
    assert_eq!((&lines[0]["type"], &lines[0]["rank"]), (&"candidate".into(), &1.into()));
    assert_eq!((&result["type"], &result["hidden"]), (&"result".into(), &lines[0]["hidden"]));
    assert_eq!(result["rows"], serde_json::json!([150, 50]));
    let eval = gripctl(folder.path(), &["eval", "s.json", "test.csv", "--json"]).done().json();
    let (reported, found) = (number(&result, "test_mse"), number(&eval[0], "mse"));
    assert!((found / reported - 1.0).abs() < 1e-9, "{reported} and {found}");
    let again = search("3", &["--test", "test.csv", "--group", "object"]).done();
    assert_eq!(lines, again.json()[..lines.len()]);
    assert_ne!(lines, search("4", &[]).done().json()[..lines.len().min(3)]);
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

/// The same rows as CSV and as arrays: the same model, the same split by a column, the same evaluation.
#[test]
fn rows_of_numpy_train_like_those_of_csv() {
    let folder = tempfile::tempdir().unwrap();
    for file in ["rows.csv", "rows.npz"] {
        let args = ["generate", "-o", file, "--rows", "200", "--source", "trial"];
        gripctl(folder.path(), &args).done();
    }
    let train = |data: &str, model: &str| {
        let split = ["--holdout", "0.2", "--split-by", "object", "--epochs", "20", "--json"];
        let columns =
            ["--inputs", "slip_speed_m_s,trial_force_n:ln", "--target", "adequate_force_n"];
        let args = [&["train", data, "-o", model][..], &columns, &split].concat();
        let mut result = gripctl(folder.path(), &args).done().json().pop().unwrap();
        result.as_object_mut().unwrap().remove("cpu_s");
        let file: serde_json::Value =
            serde_json::from_slice(&fs::read(folder.path().join(model)).unwrap()).unwrap();
        let eval = gripctl(folder.path(), &["eval", model, data, "--json"]).done().json();
        (result, file["layers"].clone(), eval)
    };
    assert_eq!(train("rows.csv", "a.json"), train("rows.npz", "b.json"));
    let search =
        ["search", "rows.npz", "--inputs", "trial_force_n", "--target", "adequate_force_n"];
    let few = ["--generations", "1", "--population", "4", "--epochs", "5", "--group", "object"];
    gripctl(folder.path(), &[&search[..], &few, &["-o", "s.json"]].concat()).done();
    let missing =
        ["train", "rows.npz", "--inputs", "colour", "--target", "adequate_force_n", "-o", "c.json"];
    gripctl(folder.path(), &missing)
        .refused(2, &["rows.npz", "no array \"colour\"", "object, mass_kg"]);
    fs::write(
        folder.path().join("cut.npz"),
        &fs::read(folder.path().join("rows.npz")).unwrap()[..900],
    )
    .unwrap();
    gripctl(folder.path(), &["eval", "a.json", "cut.npz"]).refused(2, &["cut.npz: is no .npz"]);
}

#[test]
fn settings_of_a_rule_change_its_training_and_go_with_it_alone() {
    let folder = folder_with_rows();
    let mse = |more: &[&str]| {
        let args = [&["--epochs", "40"][..], more].concat();
        number(&train(folder.path(), "h.json", &args).done().json()[0], "train_scaled_mse")
    };
    let (slow, fast) =
        (["--algorithm", "gd", "--rate", "0.001"], ["--algorithm", "gd", "--rate", "0.05"]);
    assert!(mse(&fast) < mse(&slow));
    let steps = ["--algorithm", "rprop", "--rprop-steps", "0.01,1.1,0.6,10", "--rprop", "rprop-"];
    assert!(mse(&steps) != mse(&steps[..2]));
    assert!(
        mse(&["--algorithm", "gdm", "--momentum-share", "0.5"]) != mse(&["--algorithm", "gdm"])
    );
    let several = ["--algorithm", "gd", "--repeats", "5"];
    let typical = [&several[..], &["--choice", "nearest-average"]].concat();
    assert!(mse(&typical) > mse(&several), "the best run is better than the typical one");
    for (more, message) in [
        (
            &["--algorithm", "scg", "--rate", "0.1"][..],
            "--rate goes with --algorithm gd, gdm, gdx only",
        ),
        (&["--algorithm", "gd", "--mu", "0.1"], "--mu goes with --algorithm lm only"),
        (&["--rprop-steps", "1,2"], "expected four numbers"),
        (&["--choice", "worst"], "--choice worst: expected best or nearest-average"),
    ] {
        train(folder.path(), "h.json", more).refused(2, &[message]);
    }
}

/// 24 columns, more than gripd takes; the class hangs on two of them.
fn folder_with_classes() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let names: Vec<String> = (0..24).map(|at| format!("x{at}")).collect();
    let mut csv = format!("{},side,object\n", names.join(","));
    for row in 0..240_u32 {
        let (sin, cos) = (f64::from(row) * 2.399).sin_cos();
        let side = if sin > 0.5 {
            "up"
        } else if cos > 0.0 {
            "right"
        } else {
            "left"
        };
        let noise = (2..24).map(|at| ((row * 31 + at * 17) % 101).to_string());
        let cells: Vec<String> =
            [sin.to_string(), cos.to_string()].into_iter().chain(noise).collect();
        csv += &format!("{},{side},o{}\n", cells.join(","), row % 4);
    }
    fs::write(folder.path().join("sides.csv"), csv).unwrap();
    folder
}

#[test]
fn classes_of_24_columns_are_learned_tested_exported_and_searched_for() {
    let folder = folder_with_classes();
    let inputs = (0..24).map(|at| format!("x{at}")).collect::<Vec<_>>().join(",");
    let columns = ["--inputs", &inputs, "--target", "side", "--classify"];
    let train = ["train", "sides.csv", "-o", "s.json", "--json", "--algorithm", "scg"];
    let more = ["--epochs", "60", "--folds", "3", "--split-by", "object", "--holdout", "0.25"];
    let lines = gripctl(folder.path(), &[&train[..], &columns, &more].concat()).done().json();
    let (folds, result) = (&lines[lines.len() - 2], &lines[lines.len() - 1]);
    assert!(number(folds, "test_accuracy") > 0.8, "{folds}");
    assert!(number(result, "test_accuracy") > 0.8 && number(result, "train_mse") < 0.1, "{result}");
    assert!(number(result, "train_cross_entropy") < 0.4, "{result}");
    let eval = gripctl(folder.path(), &["eval", "s.json", "sides.csv", "--json"]).done().json();
    assert!(number(&eval[0], "accuracy") > 0.9 && number(&eval[0], "mse") < 0.1, "{eval:?}");
    assert!(number(&eval[0], "cross_entropy") > 0.0);
    let card = fs::read_to_string(folder.path().join("s.card.json")).unwrap();
    assert!(card.contains("\"accuracy\"") && card.contains("\"cross_entropy\""), "{card}");
    let text = gripctl(folder.path(), &["eval", "s.json", "sides.csv"]).done().out;
    assert!(text.contains("of the classes right"), "{text}");
    for format in [&["c", "--verify"][..], &["onnx"]] {
        gripctl(folder.path(), &[&["export", "s.json", "--format"], format].concat()).done();
    }
    gripctl(folder.path(), &["grasp", "--trials", "1", "--model", "s.json"])
        .refused(2, &["s.json", "3 classes apart", "at most 16 inputs"]);
    let search = ["search", "sides.csv", "-o", "f.json", "--json", "--generations", "1"];
    let few = ["--population", "6", "--epochs", "20", "--repeats", "1", "--group", "object"];
    let lines = gripctl(folder.path(), &[&search[..], &columns, &few].concat()).done().json();
    assert!(number(lines.last().unwrap(), "train_accuracy") > 0.5, "{lines:?}");
    let args =
        [&["train", "sides.csv", "-o", "l.json", "--algorithm", "lm"][..], &columns].concat();
    gripctl(folder.path(), &args).refused(2, &["lm minimises squares only"]);
    let args = [&["train", "sides.csv", "-o", "e.json", "--model", "svr"][..], &columns].concat();
    gripctl(folder.path(), &args).refused(2, &["--classify goes with --model mlp only"]);
    let two = ["train", "sides.csv", "-o", "t.json", "--inputs", "x0", "--target", "side,object"];
    gripctl(folder.path(), &[&two[..], &["--classify"]].concat())
        .refused(2, &["--classify: expected one column"]);
}
