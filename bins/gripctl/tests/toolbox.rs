//! The commands as a user runs them: fields of the contract, the same output every time.
#![expect(clippy::unwrap_used, reason = "test code")]

use assert_cmd::Command;
use serde_json::Value;
use std::{
    fs,
    path::{Path, PathBuf},
};

struct Ran {
    code: i32,
    out: String,
    err: String,
}

fn gripctl(folder: &Path, arguments: &[&str]) -> Ran {
    let output = Command::cargo_bin("gripctl")
        .unwrap()
        .args(arguments)
        .current_dir(folder)
        .output()
        .unwrap();
    let err = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(!err.contains("panicked"), "{err}");
    Ran { code: output.status.code().unwrap(), out: String::from_utf8(output.stdout).unwrap(), err }
}

fn done(folder: &Path, arguments: &[&str]) -> Vec<Value> {
    let ran = gripctl(folder, arguments);
    assert_eq!(ran.code, 0, "{arguments:?}: {}", ran.err);
    ran.out.lines().filter_map(|line| serde_json::from_str(line).ok()).collect()
}

fn number(value: &Value, name: &str) -> f64 {
    value[name].as_f64().unwrap_or_else(|| panic!("{name} in {value}"))
}

#[test]
fn grasps_are_held_and_the_same_every_time() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = ["grasp", "--trials", "8", "--duration", "2", "--json", "--each"];
    let lines = done(folder.path(), &arguments);
    assert_eq!(lines.len(), 10, "8 grasps, the scene and all");
    let all = &lines[9];
    assert_eq!((all["scene"].as_str().unwrap(), number(all, "trials")), ("all", 8.0));
    assert_eq!((number(all, "dropped"), number(all, "crushed")), (0.0, 0.0), "{all}");
    assert!(
        number(&all["slip_mm"], "p50") > 0.0 && number(&all["force_ratio"], "p95") < 1.6,
        "{all}"
    );
    assert!(number(all, "peak_n") <= 60.0);
    assert_eq!(lines, done(folder.path(), &arguments));
}

#[test]
fn every_trainer_learns_and_its_model_is_read_back() {
    let folder = tempfile::tempdir().unwrap();
    done(folder.path(), &["generate", "-o", "train.csv", "--rows", "300", "--seed", "1"]);
    done(folder.path(), &["generate", "-o", "test.csv", "--rows", "100", "--seed", "2"]);
    for algorithm in ["gd", "gdm", "rprop", "scg", "lm"] {
        let train = |output: &str| {
            let arguments = [
                "train",
                "train.csv",
                "--inputs",
                "slip_acceleration_m_s2,trial_force_n:ln",
                "--target",
                "adequate_force_n:ln",
                "--algorithm",
                algorithm,
                "--epochs",
                "60",
                "--seed",
                "3",
                "--test",
                "test.csv",
                "-o",
                output,
                "--json",
            ];
            done(folder.path(), &arguments).pop().unwrap()
        };
        let result = train("a.json");
        assert_eq!(result["type"], "result");
        assert_eq!(result["algorithm"], algorithm);
        assert!(number(&result, "train_mse") > 0.0 && number(&result, "cpu_s") >= 0.0);
        assert!((1.0..=60.0).contains(&number(&result, "epochs")) && result["stop"].is_string());
        train("b.json");
        let read = |name: &str| fs::read(folder.path().join(name)).unwrap();
        assert_eq!(read("a.json"), read("b.json"), "{algorithm}: the same seed, the same model");
        let eval = done(folder.path(), &["eval", "a.json", "test.csv", "--json"]).pop().unwrap();
        assert_eq!(number(&eval, "rows"), 100.0);
        assert!((number(&eval, "mse") / number(&result, "test_mse") - 1.0).abs() < 1e-9);
        assert!((0.0..=1.0).contains(&number(&eval, "within_10pct")));
    }
}

/// Noise of some counts, with a tone of 200 counts from `slip_from_s` on, rectified.
fn vibration(slip_from_s: f64, seed: u32) -> String {
    let mut state = seed;
    let mut text = String::from("t_s,vibration\n");
    for i in 0..1320_u32 {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let noise = f64::from(state >> 8) / f64::from(1 << 24) * 10.0 - 5.0;
        let t = f64::from(i) / 2200.0;
        let tone = if t >= slip_from_s { 200.0 * (942.0 * t).sin() } else { 0.0 };
        text.push_str(&format!("{t:.6},{}\n", (noise + tone).abs().round()));
    }
    text
}

#[test]
fn a_labelled_folder_is_scored() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    write(
        "labels.csv",
        "recording,kind,material,onset_s\na,onset,felt,0.3\ns,steady,felt,\nr,rest,felt,\n",
    );
    write("a.csv", &vibration(0.3, 1));
    write("s.csv", &vibration(0.0, 2));
    write("r.csv", &vibration(9.0, 3));
    let lines = done(folder.path(), &["score", ".", "--json"]);
    let [a, s, r, total] = lines.as_slice() else { panic!("{lines:?}") };
    assert_eq!(
        (a["recording"].as_str(), a["kind"].as_str(), a["material"].as_str()),
        (Some("a"), Some("onset"), Some("felt"))
    );
    assert!((0.0..15.0).contains(&number(a, "latency_ms")) && number(a, "alarm_s") >= 0.3, "{a}");
    assert!(s["missed"] == false && r["alarm_s"].is_null() && a["early"] == false);
    assert_eq!((total["type"].as_str(), number(total, "onsets")), (Some("total"), 1.0));
    assert_eq!((number(total, "missed"), number(total, "early")), (0.0, 0.0));
    assert_eq!((number(total, "steady"), number(total, "steady_missed")), (1.0, 0.0));
    assert!(number(total, "rest_s") > 0.5 && number(total, "rest_alarms") == 0.0, "{total}");
    assert!(total["latency_ms"]["p50"].is_f64() && total["latency_ms"]["p95"].is_f64());
}

/// The folder of real recordings, beside the checkout or named by `GRIP_DATA`.
fn data() -> Option<PathBuf> {
    let folder = std::env::var_os("GRIP_DATA").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data"),
        PathBuf::from,
    );
    if folder.is_dir() {
        return Some(folder);
    }
    eprintln!(
        "skipped: no real recordings at {} (name their folder with GRIP_DATA)",
        folder.display()
    );
    None
}

#[test]
fn real_fingertip_recordings_are_within_the_stated_bounds() {
    let Some(data) = data() else { return };
    let folder = data.join("biotac_slide").display().to_string();
    let lines = done(&data, &["score", &folder, "--guard-ms", "60", "--json"]);
    let total = lines.last().unwrap();
    assert_eq!((number(total, "onsets"), number(total, "steady")), (58.0, 56.0));
    assert_eq!((number(total, "missed"), number(total, "steady_missed")), (0.0, 0.0), "{total}");
    assert!(
        number(total, "early") <= 2.0 && number(&total["latency_ms"], "p50") <= 20.0,
        "{total}"
    );
}

#[test]
fn dirty_real_recordings_are_survived_and_their_faults_told() {
    let Some(data) = data() else { return };
    for name in ["texture1", "texture2", "texture3"] {
        let file = data.join(format!("stylus_accel_1k/{name}.csv")).display().to_string();
        let ran = gripctl(
            &data,
            &["replay", &file, "--map", "vibration=acceleration", "--observe", "--json"],
        );
        assert!(matches!(ran.code, 0 | 3), "{name}: {}", ran.err);
        let lines: Vec<Value> =
            ran.out.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
        let (summary, events) = lines.split_last().unwrap();
        assert!(number(summary, "samples") > 1000.0, "{summary}");
        for event in events.iter().filter(|event| event["type"] == "slip") {
            assert!(number(event, "statistic").is_finite(), "{event}");
        }
    }
}

#[test]
fn what_is_wrong_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    write("text.csv", "t_s,stylus\n0,1e-6\n0.001,abc\n");
    write("back.csv", "t_s,stylus\n0,0\n0.002,0\n0.001,0\n");
    write("wide.csv", "t_s,stylus\n0,0\n0.001,0,7\n");
    write("none.csv", "time,height\n0,0\n");
    write("empty.csv", "");
    write("spikes.csv", "t_s,stylus\n0,1e-6\n0.001,1e30\n0.002,NaN\n0.003,2e-6\n");
    write("labels.csv", "recording,kind,material,onset_s\na,sliding,x,\n");
    let says = |arguments: &[&str], code: i32, words: &[&str]| {
        let ran = gripctl(folder.path(), arguments);
        assert_eq!(ran.code, code, "{arguments:?}: {}", ran.err);
        for word in words {
            assert!(ran.err.contains(word), "{arguments:?} says {:?}, expected {word:?}", ran.err);
        }
    };
    says(&["replay", "nowhere.csv"], 1, &["nowhere.csv"]);
    says(&["replay", "text.csv"], 1, &["text.csv", "line 3", "stylus", "abc"]);
    says(&["replay", "back.csv"], 1, &["back.csv", "line 4", "0.001"]);
    says(&["replay", "wide.csv"], 1, &["wide.csv", "line 3"]);
    says(&["replay", "none.csv"], 1, &["none.csv", "stylus", "height"]);
    says(&["replay", "empty.csv"], 1, &["empty.csv"]);
    says(&["replay", "text.csv", "--map", "stylus"], 2, &["--map", "OURS=NAME"]);
    says(&["score", "."], 1, &["labels.csv", "line 2", "sliding"]);
    says(&["score", ".", "--guard-ms", "nan"], 2, &["--guard-ms"]);
    says(&["grasp", "nowhere"], 2, &["nowhere", "default"]);
    says(&["grasp", "--duration", "-1"], 2, &["--duration"]);
    says(
        &["train", "text.csv", "--inputs", "t_s", "--target", "q", "-o", "m.json"],
        1,
        &["text.csv", "q", "stylus"],
    );
    says(&["eval", "text.csv", "text.csv"], 2, &["text.csv"]);
    // Unusable readings are counted, not refused.
    let summary = done(folder.path(), &["replay", "spikes.csv", "--json"]).pop().unwrap();
    assert_eq!(number(&summary, "unusable"), 2.0, "{summary}");
}
