//! Whole runs over a real pseudo-terminal: what is printed and recorded, and that a replay states the same.

use crate::running::{command, gripd};
use grip_record::{CsvOptions, Recording, read_csv};
use grip_session::{HostConfig, model, replay, report::EventLog};
use serde_json::Value;
use slip_core::PipelineConfig;
use std::{
    fs,
    io::Read as _,
    os::unix::fs::symlink,
    path::{Path, PathBuf},
    process::{Command, Stdio},
};
use stories::Ended;

/// The event lines that a replay of `recording` prints.
fn replayed(recording: &Recording, config: &HostConfig, no_skip: bool) -> Vec<String> {
    let config = replay::pipeline_config(recording, config, false);
    let config = PipelineConfig { no_skip, ..config };
    let estimator = model::default_estimator().unwrap();
    let steps = replay::Replay::new(recording, config, Some(estimator)).unwrap();
    let mut log = EventLog::default();
    steps
        .flat_map(|step| log.events(&step).into_iter().flatten())
        .map(|line| serde_json::to_string(&line).unwrap())
        .collect()
}

/// The recording gives the very lines that were printed, however often and however thoroughly it is replayed. Where the
/// machine was too busy to record every sample there is nothing to compare.
pub(crate) fn replays_identically(file: &Path, ran: &Ended, config: &HostConfig) {
    // A table has no clock of a device: a gripper that lives by no clock of its own is fast or slow.
    let printed = ran.out.lines().filter(|line| !line.contains("\"channel\":\"clock\""));
    let mut printed: Vec<&str> = printed.collect();
    let summary: Value = serde_json::from_str(printed.pop().unwrap()).unwrap();
    let recording = read_csv(file, &CsvOptions::default()).unwrap();
    if summary["unrecorded_samples"] != 0 || summary["untold_notes"] != 0 {
        assert_eq!(ran.code, 3, "{summary}");
        return;
    }
    // A machine that stops the program for a second makes it arm the gripper again: that pipeline has a file of its own, which
    // shows nothing of how it began. Recordings of everything do; see `recording.rs`.
    let further: Vec<PathBuf> = (1..)
        .map(|part| file.with_file_name(format!("run-{part:04}.csv")))
        .take_while(|part| part.exists())
        .collect();
    if !further.is_empty() {
        let samples =
            |part: &PathBuf| read_csv(part, &CsvOptions::default()).unwrap().samples.len();
        let more: usize = further.iter().map(samples).sum();
        assert_eq!(summary["samples"], recording.samples.len() + more, "{summary}");
        return;
    }
    assert_eq!(summary["samples"], recording.samples.len());
    for no_skip in [false, false, true] {
        assert_eq!(replayed(&recording, config, no_skip), printed, "no_skip: {no_skip}");
    }
}

fn number(value: &Value, name: &str) -> f64 {
    value[name].as_f64().unwrap_or_else(|| panic!("no number {name} in {value}"))
}

/// A machine that stops the program for longer than the object takes to fall drops it: it may try again.
fn until_held(folder: &Path, args: &[&str]) -> Ended {
    for _ in 0..3 {
        let ran = gripd(folder, args).done();
        if ran.lines().last().unwrap()["held"] == true {
            return ran;
        }
        eprintln!("not held: {}", ran.out);
    }
    panic!("the object was not held in three runs");
}

/// The fields of the contract in the last line.
fn check_summary(summary: &Value, code: i32) {
    assert_eq!(summary["type"], "summary");
    assert!(number(summary, "samples") > 1000.0, "{summary}");
    assert!(number(summary, "slips") >= 1.0 && number(summary, "commands") > 10.0, "{summary}");
    assert!(summary["lost"].is_u64() && number(summary, "slip_mm") > 0.0, "{summary}");
    let (needed, last) = (number(summary, "force_needed_n"), number(summary, "force_final_n"));
    assert!(last > needed && last < 60.0, "{last} N of {needed} N");
    for name in ["p50", "p99", "max"] {
        assert!(number(&summary["latency_us"], name) > 0.0, "{summary}");
    }
    let lossy =
        ["lost", "unrecorded_samples", "untold_notes"].iter().any(|name| summary[name] != 0);
    assert_eq!(code == 3, lossy, "{summary}");
}

/// The fields of the contract in the lines of events; there is a slip among them.
fn check_events(lines: &[Value]) {
    let known = ["slip", "slip_end", "health", "grip"];
    assert!(lines.iter().all(|line| known.contains(&line["type"].as_str().unwrap())));
    let slips: Vec<&Value> = lines.iter().filter(|line| line["type"] == "slip").collect();
    assert!(!slips.is_empty(), "{lines:?}");
    for slip in slips {
        assert!(number(slip, "t_s") > 0.0 && number(slip, "statistic") >= 1.0, "{slip}");
        assert!(["incipient", "gross"].contains(&slip["phase"].as_str().unwrap()), "{slip}");
        for name in ["esc_w", "estimate_n"] {
            let value = slip.get(name);
            assert!(value.is_some_and(|value| value.is_null() || value.is_f64()), "{slip}");
        }
        assert!((0.0..=60.0).contains(&number(slip, "command_n")), "{slip}");
    }
}

#[test]
fn the_object_is_held_and_every_line_is_as_agreed() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("run.csv");
    let args = ["--port", "sim", "--duration", "4", "--json", "--record", "run.csv"];
    let ran = until_held(folder.path(), &args);
    let mut lines = ran.lines();
    check_summary(&lines.pop().unwrap(), ran.code);
    check_events(&lines);
    replays_identically(&file, &ran, &HostConfig::default());
}

#[test]
fn a_person_reads_the_same_in_sentences() {
    let folder = tempfile::tempdir().unwrap();
    let said = |ran: &Ended| {
        let words = ["slip (", "slip ended after", "latency from frame to command", "object HELD"];
        ran.err.contains("gripper found") && words.iter().all(|words| ran.out.contains(words))
    };
    let args = ["--port", "sim", "--duration", "3"];
    assert!((0..3).any(|_| said(&gripd(folder.path(), &args).done())));
}

/// A gripper that feels only with its stylus, at a low limit of force: the recording still states that a controller ran.
#[test]
fn a_gripper_without_other_sensors_replays_identically() {
    let folder = tempfile::tempdir().unwrap();
    let scene = "name = \"bare\"\nseed = 3\nmass_kg = 0.3\nfriction = 0.4\n[channels]\nforce = false\ntravel = false\n";
    fs::write(folder.path().join("bare.toml"), scene).unwrap();
    let args = ["--port", "sim:bare.toml", "--duration", "2.5", "--json", "--record", "run.csv"];
    // A machine that stands still for most of the run loses the slip.
    let slips = |ran: &Ended| {
        ran.lines().iter().any(|line| line["type"] == "slip" && line["command_n"].is_f64())
    };
    let mut ran = gripd(folder.path(), &args).done();
    for _ in 1..5 {
        if !slips(&ran) && ran.code == 3 {
            ran = gripd(folder.path(), &args).done();
        }
    }
    assert!(slips(&ran), "{}", ran.out);
    replays_identically(&folder.path().join("run.csv"), &ran, &HostConfig::default());
}

#[test]
fn a_recording_that_cannot_be_written_is_reported_and_the_grip_goes_on() {
    let folder = tempfile::tempdir().unwrap();
    symlink("/dev/full", folder.path().join("full.csv")).unwrap();
    let args = ["--port", "sim", "--duration", "1.5", "--record", "full.csv"];
    let ran = gripd(folder.path(), &args);
    assert_eq!(ran.code, 3, "{ran:?}");
    assert!(ran.err.contains("full.csv"), "{}", ran.err);
    assert!(ran.err.contains("the object is held without"), "{}", ran.err);
    assert!(ran.out.contains("latency from frame to command"), "{}", ran.out);
    let ran = gripd(folder.path(), &["--port", "sim", "--record", "gone/x.csv"]);
    ran.refused(1, &["cannot write the recording gone/x.csv", "No such file"]);
}

/// SIGXFSZ would end the program; the write fails instead, in the middle of the recording.
#[test]
fn a_limit_on_the_size_of_files_ends_the_recording_and_not_the_grip() {
    let folder = tempfile::tempdir().unwrap();
    let args = ["--port", "sim", "--duration", "1.5", "--record", "run.mcap"];
    let gripd = command(folder.path(), &args);
    let limited = "ulimit -f 100; exec \"$0\" \"$@\"";
    let ran = Command::new("sh")
        .args(["-c", limited])
        .arg(gripd.get_program())
        .args(gripd.get_args())
        .current_dir(folder.path())
        .output()
        .unwrap();
    let err = String::from_utf8_lossy(&ran.stderr);
    assert_eq!(ran.status.code(), Some(3), "{ran:?}");
    assert_eq!(err.matches("the object is held without").count(), 1, "{err}");
    let out = String::from_utf8_lossy(&ran.stdout);
    assert!(out.contains("latency from frame to command"), "{out}");
    let written = fs::metadata(folder.path().join("run.mcap")).unwrap().len();
    assert!((10_000..=102_400).contains(&written), "{written} bytes");
}

#[test]
fn nobody_reads_the_output_and_the_recording_is_complete_all_the_same() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("run.csv"), "older\n".repeat(200_000)).unwrap();
    let args = ["--port", "sim", "--duration", "2", "--json", "--record", "run.csv"];
    let mut child = command(folder.path(), &args)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let mut err = String::new();
    child.stderr.take().unwrap().read_to_string(&mut err).unwrap();
    let code = child.wait().unwrap().code();
    assert!([Some(0), Some(3)].contains(&code) && !err.contains("panicked"), "{code:?} {err}");
    assert_eq!(fs::metadata(folder.path().join("run.csv")).unwrap().len(), 1_200_000);
    let recording = read_csv(&folder.path().join("run-0001.csv"), &CsvOptions::default()).unwrap();
    let seconds = recording.samples.last().unwrap().t.as_seconds();
    assert!(recording.samples.len() > 1000 && seconds < 60.0, "{seconds} s");
}

/// With --dry-run nothing is pressed; without a gripper an older recording stays.
#[test]
fn a_dry_run_commands_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let args = ["--port", "sim", "--duration", "1.2", "--dry-run", "--json", "--no-skip"];
    let ran = gripd(folder.path(), &args).done();
    let summary = ran.lines().pop().unwrap();
    assert_eq!(summary["commands"], 0, "{summary}");
    assert_eq!(number(&summary, "force_final_n"), 0.0, "{summary}");
    assert_eq!(summary["held"], false, "{summary}");
    fs::write(folder.path().join("old.csv"), "t_s,stylus\n0,0\n").unwrap();
    let args = ["--port", "./nowhere", "--record", "old.csv"];
    gripd(folder.path(), &args).refused(1, &["./nowhere", "no such port"]);
    let kept = fs::read_to_string(folder.path().join("old.csv")).unwrap();
    assert_eq!(kept, "t_s,stylus\n0,0\n");
}
