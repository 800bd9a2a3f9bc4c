//! `gripctl generate`, `train` and `eval`: rows, networks and model files that are the same for the same seed.

use crate::run::{Ran, gripctl, number, put, read};
use std::fs;
use tempfile::TempDir;

const COLUMNS: &str =
    "--inputs slip_acceleration_m_s2,trial_force_n:ln --target adequate_force_n:ln";

fn train(folder: &TempDir, model: &str, more: &str) -> Ran {
    gripctl(folder, format!("train rows.csv --json --hidden 6 -o {model} {COLUMNS} {more}"))
}

fn folder_with_rows() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, seed) in [("rows.csv", "1"), ("test.csv", "2"), ("again.csv", "1")] {
        let args = &format!("generate -o {name} --rows 200 --seed {seed}");
        let out = gripctl(&folder, args).done().out;
        assert!(out.contains("200 rows written"), "{out}");
    }
    let read = |name: &str| read(&folder, name);
    assert!(read("rows.csv") == read("again.csv") && read("rows.csv") != read("test.csv"));
    assert_eq!(read("rows.csv").lines().count(), 201);
    folder
}

#[test]
fn every_algorithm_trains_a_model_that_evaluates_as_it_stated() {
    let folder = folder_with_rows();
    let mut errors = Vec::new();
    for algorithm in ["gd", "gdm", "rprop", "scg", "lm"] {
        let common = format!("--algorithm {algorithm} --epochs 30 --test test.csv --seed");
        let more = &format!("{common} 4");
        let ran = train(&folder, "m.json", more).done();
        let result = ran.json().pop().unwrap();
        assert_eq!((&result["type"], &result["algorithm"]), (&"result".into(), &algorithm.into()));
        assert!((1.0..=30.0).contains(&number(&result, "epochs")), "{result}");
        assert!(result["stop"].is_string() && number(&result, "cpu_s") > 0.0, "{result}");
        for (data, name) in [("rows.csv", "train_mse"), ("test.csv", "test_mse")] {
            let ran = gripctl(&folder, format!("eval m.json {data} --json")).done();
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
        train(&folder, "m.json", more).done();
        assert!(first == fs::read(folder.path().join("m.json")).unwrap(), "{algorithm}: same seed");
        train(&folder, "m.json", &format!("{common} 5")).done();
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
    let run = |args: &str| gripctl(&folder, args);
    for (name, rows, seed) in [("rows.csv", "150", "1"), ("unseen.csv", "1000", "2")] {
        let noise = "--speed-noise 0.03 --force-noise 0.03";
        let args = &format!("generate -o {name} --rows {rows} --seed {seed} --source trial");
        run(&format!("{args} {noise}")).done();
    }
    let few = "--epochs 60 --interval 0.9";
    for (model, more) in [
        ("rprop.json", "--algorithm rprop"),
        ("br.json", "--algorithm br"),
        ("ensemble.json", "--model ensemble --members 3"),
        ("gp.json", "--model gp"),
        ("poly.json", "--model poly"),
        ("svr.json", "--model svr"),
    ] {
        let result = train(&folder, model, &format!("{more} {few}")).last();
        let width = result["interval"]["widths"][0].as_f64().unwrap();
        assert!((1.0..3.0).contains(&width) && number(&result, "held_out_r2") > 0.5, "{result}");
        assert_eq!(
            (&result["interval"]["level"], &result["worse_than_mean"]),
            (&0.9.into(), &false.into())
        );
        let eval = run(&format!("eval {model} unseen.csv --json")).last();
        let coverage = number(&eval, "coverage");
        assert!((0.84..0.96).contains(&coverage) && eval["interval"] == 0.9, "{model}: {eval}");
        let text = run(&format!("eval {model} unseen.csv")).done().out;
        assert!(text.contains(&format!("90 % interval holds {:.1} %", 100.0 * coverage)), "{text}");
    }
    run("export rprop.json --format c --verify").done();
}

/// Rows far from zero, rows that show nothing, and a training that learned nothing.
#[test]
fn training_keeps_digits_and_states_what_speaks_against_it() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, n: u32, y: &dyn Fn(f64) -> f64| {
        let row = |i: u32| format!("{},4,{}\n", f64::from(i) / 100.0, y(f64::from(i) / 100.0));
        let rows: String = (0..n).map(row).collect();
        put(&folder, name, format!("a,b,y\n{rows}"));
    };
    let run = |data: &str, more: &str| {
        let args = &format!("train {data} --inputs a,b --target y -o m.json --json");
        gripctl(&folder, format!("{args} {more}"))
    };
    write("far.csv", 200, &|x| 1e9 + x.sin());
    for precision in ["f32", "f64"] {
        let more = &format!("--algorithm scg --epochs 200 --precision {precision}");
        let ran = run("far.csv", more).done();
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
        let eval = gripctl(&folder, "eval m.json far.csv").done();
        assert!(eval.out.contains("R2 1.0") && eval.err.is_empty(), "{eval:?}");
    }
    write("other.csv", 200, &|x| 1e9 - x.sin());
    let eval = gripctl(&folder, "eval m.json other.csv").done();
    assert!(eval.err.contains("no better than answering their mean"), "{}", eval.err);
    write("same.csv", 3, &|_| 5.0);
    let args = "train same.csv --inputs a --target y -o m.json";
    let same = gripctl(&folder, args).done();
    assert!(same.err.contains("target \"y\" is 5 in every row"), "{}", same.err);
    assert!(same.err.contains("3 rows for 31 weights"), "{}", same.err);
    assert!(
        same.out.contains("the target does not vary") && !same.out.contains("100.0 %"),
        "{same:?}"
    );
    fs::remove_file(folder.path().join("m.json")).unwrap();
    run("far.csv", "--algorithm gd --rate 1e5").refused(1, &["diverged at once"]);
    assert!(!folder.path().join("m.json").exists());
}

/// Ensembles and support vector regressions: the result line, the file, `eval` of it, and a place in the pipeline for the former alone.
#[test]
fn learners_beyond_one_network_evaluate_as_they_stated() {
    let folder = folder_with_rows();
    for (model, more) in [
        ("ensemble", "--members 3 --epochs 60 --algorithm scg"),
        ("ensemble", "--members 3 --epochs 60 --algorithm scg --bagging"),
        ("svr", "--svr-c 10"),
        ("svr", "--svr-c 100 --svr-gamma 0.3"),
    ] {
        let more = &format!("--model {model} --test test.csv {more}");
        let result = train(&folder, "b.json", more).last();
        assert_eq!((&result["type"], &result["model"]), (&"result".into(), &model.into()));
        for (data, name) in [("rows.csv", "train_mse"), ("test.csv", "test_mse")] {
            let eval = gripctl(&folder, format!("eval b.json {data} --json")).done();
            let (reported, found) = (number(&result, name), number(&eval.json()[0], "mse"));
            assert!(
                reported > 0.0 && (found / reported - 1.0).abs() < 1e-6,
                "{name}: {reported} and {found}"
            );
        }
        assert!(number(&result, "test_within_10pct") > 0.5, "{result}");
        let first = fs::read(folder.path().join("b.json")).unwrap();
        train(&folder, "b.json", more).done();
        assert!(first == fs::read(folder.path().join("b.json")).unwrap(), "{model}: same seed");
        let grasp = gripctl(&folder, "grasp --trials 1 --model b.json");
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
        let more = &format!("--activation {activation} --algorithm scg --epochs 80");
        let result = train(&folder, "a.json", more).last();
        let eval = gripctl(&folder, "eval a.json rows.csv --json").done();
        let (reported, found) = (number(&result, "train_mse"), number(&eval.json()[0], "mse"));
        assert!((found / reported - 1.0).abs() < 1e-9, "{activation}: {reported} and {found}");
        let text = read(&folder, "a.json");
        assert!(text.contains(&format!("\"{activation}\"")), "{text}");
    }
}

#[test]
fn a_search_reports_its_best_networks_and_writes_the_first() {
    let folder = folder_with_rows();
    let search = |seed: &str, more: &str| {
        let args = "search rows.csv -o s.json --json --generations 2";
        let small = &format!("--population 6 --epochs 30 --repeats 1 --seed {seed}");
        gripctl(&folder, format!("{args} {COLUMNS} {small} {more}"))
    };
    let ran = search("3", "--test test.csv --group object").done();
    let mut lines = ran.json();
    let result = lines.pop().unwrap();
    assert!(!lines.is_empty() && lines.len() <= 10, "{}", ran.out);
    let costs: Vec<f64> = lines.iter().map(|line| number(line, "cost")).collect();
    assert!(costs.windows(2).all(|pair| pair[0] <= pair[1]), "{costs:?}");
    assert_eq!((&lines[0]["type"], &lines[0]["rank"]), (&"candidate".into(), &1.into()));
    assert_eq!((&result["type"], &result["hidden"]), (&"result".into(), &lines[0]["hidden"]));
    assert_eq!(result["rows"], serde_json::json!([150, 50]));
    let eval = gripctl(&folder, "eval s.json test.csv --json").done().json();
    let (reported, found) = (number(&result, "test_mse"), number(&eval[0], "mse"));
    assert!((found / reported - 1.0).abs() < 1e-9, "{reported} and {found}");
    let again = search("3", "--test test.csv --group object").done();
    assert_eq!(lines, again.json()[..lines.len()]);
    assert_ne!(lines, search("4", "").done().json()[..lines.len().min(3)]);
}

#[test]
fn a_trained_model_serves_the_pipeline() {
    let folder = folder_with_rows();
    let more = "--algorithm lm --epochs 60 --repeats 3";
    let ran = train(&folder, "force.json", more).done();
    let result = ran.json().pop().unwrap();
    assert_eq!(result["repeats_scaled_mse"].as_array().unwrap().len(), 3, "{result}");
    let args = "grasp --trials 2 --duration 1.5 --json --model force.json";
    let total = gripctl(&folder, args).last();
    assert_eq!((&total["trials"], &total["dropped"]), (&2.into(), &0.into()), "{total}");
}

/// The same rows as CSV and as arrays: the same model, the same split by a column, the same evaluation.
#[test]
fn rows_of_numpy_train_like_those_of_csv() {
    let folder = tempfile::tempdir().unwrap();
    for file in ["rows.csv", "rows.npz"] {
        let args = &format!("generate -o {file} --rows 200 --source trial");
        gripctl(&folder, args).done();
    }
    let train = |data: &str, model: &str| {
        let split = "--holdout 0.2 --split-by object --epochs 20 --json";
        let columns = "--inputs slip_speed_m_s,trial_force_n:ln --target adequate_force_n";
        let args = format!("train {data} -o {model} {columns} {split}");
        let mut result = gripctl(&folder, args).last();
        result.as_object_mut().unwrap().remove("cpu_s");
        let file: serde_json::Value =
            serde_json::from_slice(&fs::read(folder.path().join(model)).unwrap()).unwrap();
        let eval = gripctl(&folder, format!("eval {model} {data} --json")).done().json();
        (result, file["layers"].clone(), eval)
    };
    assert_eq!(train("rows.csv", "a.json"), train("rows.npz", "b.json"));
    let search = "search rows.npz --inputs trial_force_n --target adequate_force_n";
    let few = "--generations 1 --population 4 --epochs 5 --group object";
    gripctl(&folder, format!("{search} {few} -o s.json")).done();
    let missing = "train rows.npz --inputs colour --target adequate_force_n -o c.json";
    gripctl(&folder, missing).refused(2, &["rows.npz", "no array \"colour\"", "object, mass_kg"]);
    put(&folder, "cut.npz", &fs::read(folder.path().join("rows.npz")).unwrap()[..900]);
    gripctl(&folder, "eval a.json cut.npz").refused(2, &["cut.npz: is no .npz"]);
}

#[test]
fn settings_of_a_rule_change_its_training_and_go_with_it_alone() {
    let folder = folder_with_rows();
    let mse = |more: &str| {
        number(&train(&folder, "h.json", &format!("--epochs 40 {more}")).last(), "train_scaled_mse")
    };
    let (slow, fast) = ("--algorithm gd --rate 0.001", "--algorithm gd --rate 0.05");
    assert!(mse(fast) < mse(slow));
    let steps = "--algorithm rprop --rprop-steps 0.01,1.1,0.6,10 --rprop rprop-";
    assert!(mse(steps) != mse("--algorithm rprop"));
    assert!(mse("--algorithm gdm --momentum-share 0.5") != mse("--algorithm gdm"));
    let several = "--algorithm gd --repeats 5";
    let typical = &format!("{several} --choice nearest-average");
    assert!(mse(typical) > mse(several), "the best run is better than the typical one");
}

/// 24 columns, more than gripd takes; the class hangs on two of them.
fn folder_with_classes() -> TempDir {
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
    put(&folder, "sides.csv", csv);
    folder
}

#[test]
fn classes_of_24_columns_are_learned_tested_exported_and_searched_for() {
    let folder = folder_with_classes();
    let inputs = (0..24).map(|at| format!("x{at}")).collect::<Vec<_>>().join(",");
    let columns = &format!("--inputs {inputs} --target side --classify");
    let train = "train sides.csv -o s.json --json --algorithm scg";
    let more = "--epochs 60 --folds 3 --split-by object --holdout 0.25";
    let lines = gripctl(&folder, format!("{train} {columns} {more}")).done().json();
    let (folds, result) = (&lines[lines.len() - 2], &lines[lines.len() - 1]);
    assert!(number(folds, "test_accuracy") > 0.8, "{folds}");
    assert!(number(result, "test_accuracy") > 0.8 && number(result, "train_mse") < 0.1, "{result}");
    assert!(number(result, "train_cross_entropy") < 0.4, "{result}");
    let eval = gripctl(&folder, "eval s.json sides.csv --json").done().json();
    assert!(number(&eval[0], "accuracy") > 0.9 && number(&eval[0], "mse") < 0.1, "{eval:?}");
    assert!(number(&eval[0], "cross_entropy") > 0.0);
    let card = read(&folder, "s.card.json");
    assert!(card.contains("\"accuracy\"") && card.contains("\"cross_entropy\""), "{card}");
    let text = gripctl(&folder, "eval s.json sides.csv").done().out;
    assert!(text.contains("of the classes right"), "{text}");
    for format in ["c --verify", "onnx"] {
        gripctl(&folder, format!("export s.json --format {format}")).done();
    }
    gripctl(&folder, "grasp --trials 1 --model s.json")
        .refused(2, &["s.json", "3 classes apart", "at most 16 inputs"]);
    let search = "search sides.csv -o f.json --json --generations 1";
    let few = "--population 6 --epochs 20 --repeats 1 --group object";
    let lines = gripctl(&folder, format!("{search} {columns} {few}")).done().json();
    assert!(number(lines.last().unwrap(), "train_accuracy") > 0.5, "{lines:?}");
}
