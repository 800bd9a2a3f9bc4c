//! Recordings through `gripctl replay`: the truth about dirty ones; `tape` holds that the events of a run come again.

use crate::{
    run::{gripctl, noise, normal, number, put, read, real_data},
    score,
};
use core::fmt::Write as _;
use std::{fs, path::Path, process};

#[test]
fn an_alarm_that_keeps_the_level_of_a_machine_is_asked_about() {
    let folder = tempfile::tempdir().unwrap();
    let put = |name: &str, seconds: u32, quiet_s: u32| {
        let (mut noise, mut text) = (noise(1), String::from("t_s,vibration\n"));
        for i in 0..2000 * seconds {
            let level = if i < 2000 * quiet_s { 10.0 } else { 60.0 };
            writeln!(text, "{:.4},{:.3}", f64::from(i) / 2000.0, level * noise()).unwrap();
        }
        put(&folder, name, text);
    };
    put("started.csv", 5, 1);
    put("running.csv", 20, 0);
    let replay = |args: &str| {
        let args = &format!("replay started.csv --json {args}");
        let ran = gripctl(&folder, args).done();
        (ran.json().pop().unwrap(), ran.err)
    };
    let (summary, err) = replay("");
    let note = err.lines().find(|line| line.contains("is this the machine?")).unwrap();
    assert!(note.starts_with("started.csv: 3.") && note.ends_with("with it running"), "{note}");
    assert_eq!((&summary["slips"], &summary["steady_alarms"]), (&1.into(), &1.into()));
    // As it says: with a calibration beside the machine nothing slips.
    gripctl(&folder, "calibrate running.csv -o cal.toml").done();
    let (summary, err) = replay("--calibration cal.toml");
    assert!(!err.contains("machine?") && summary["slips"] == 0, "{summary} {err}");
    assert_eq!(summary["steady_alarms"], 0);
}

#[test]
fn a_recording_that_ends_before_its_floor_is_known_says_so() {
    let folder = tempfile::tempdir().unwrap();
    for (rows, learning) in [(100, true), (3200, false)] {
        let noise = (0..rows).map(|n| format!("{}\n", (n * 7919 % 101) as f32 * 1e-4));
        let text = format!("vibration\n{}", noise.collect::<String>());
        put(&folder, "short.csv", text);
        let ran = gripctl(&folder, "replay short.csv --rate 1600 --json").done();
        let summary = ran.json().pop().unwrap();
        assert_eq!(summary["learning"], learning, "{summary}");
        assert_eq!(
            ran.err.contains("ends before its noise floor is learned"),
            learning,
            "{}",
            ran.err
        );
    }
}

#[test]
fn a_folder_of_tables_is_replayed_one_after_the_other() {
    let folder = score::folder();
    put(&folder, "notes.csv", "what,when\nfound,noon\n");
    // What a pattern takes along: the labels, which are no recording, and what somebody put there.
    let ran = gripctl(&folder, "replay --json labels.csv notes.csv found.csv rest.csv");
    assert_eq!(
        (
            ran.code,
            ran.err.contains("notes.csv"),
            ran.err.contains("labels.csv: a list of its folder")
        ),
        (2, true, true),
        "the others are read: {ran:?}"
    );
    fs::remove_file(folder.path().join("notes.csv")).unwrap();
    let lines = ran.json();
    let summaries = lines.iter().filter(|line| line["type"] == "summary");
    let slips: Vec<_> = summaries.map(|line| (&line["file"], &line["slips"])).collect();
    assert_eq!(slips, [(&"found.csv".into(), &1.into()), (&"rest.csv".into(), &0.into())]);
    let text = gripctl(&folder, "replay found.csv rest.csv").done().out;
    let alone = ["found.csv", "rest.csv"]
        .map(|file| format!("{file}\n{}", gripctl(&folder, format!("replay {file}")).done().out));
    assert_eq!(text, alone.concat());
    gripctl(&folder, "replay labels.csv found.csv").done();
    let folders = "what may be a recording in it: all.csv, early.csv,";
    let ran = gripctl(&folder, "replay .");
    ran.refused(2, &[folders, "(files: 7)", "`gripctl replay ./*.csv`"]);
    let plot = "replay found.csv rest.csv --plot x.svg";
    gripctl(&folder, plot).refused(2, &["several files", "--plot"]);
}

/// An output that cannot be written is no fault of a file, and is reported once.
#[test]
fn an_output_that_is_full_ends_the_replay_of_several_tables() {
    let folder = score::folder();
    let full = fs::File::options().write(true).open("/dev/full").unwrap();
    let ran = process::Command::new(env!("CARGO_BIN_EXE_gripctl"))
        .current_dir(folder.path())
        .args(["replay", "--json", "found.csv", "rest.csv"])
        .stdout(full)
        .output()
        .unwrap();
    let err = String::from_utf8_lossy(&ran.stderr);
    assert_eq!((ran.status.code(), err.matches("No space left").count()), (Some(1), 1), "{err}");
}

#[test]
fn slips_are_drawn_without_a_window() {
    let folder = score::folder();
    let folder = folder.path();
    let plain = gripctl(folder, "replay found.csv --json").done().out;
    let slips = plain.matches("\"type\":\"slip\"").count();
    assert!(slips > 0, "{plain}");
    for file in ["slips.svg", "slips.png"] {
        let ran = gripctl(folder, format!("replay found.csv --json --plot {file}")).done();
        assert_eq!(ran.out, plain, "the events are the same");
    }
    let svg = read(folder, "slips.svg");
    for text in ["found: 1 slip", "time (s)", "evidence (1: a slip)", ">signal<"] {
        assert!(svg.contains(text), "no {text} in {svg}");
    }
    assert!(fs::read(folder.join("slips.png")).unwrap().starts_with(b"\x89PNG"));
    // A recording without slips, and one of everything.
    gripctl(folder, "replay rest.csv --plot rest.svg").done();
    assert!(read(folder, "rest.svg").contains("rest: 0 slips"));
    gripctl(folder, "import found.csv -o run.mcap").done();
    gripctl(folder, "replay run.mcap --plot run.svg").done();
    assert!(read(folder, "run.svg").contains("run: 1 slip"));
    gripctl(folder, "replay found.csv --plot x.pdf")
        .refused(2, &["x.pdf: expected a name", ".svg"]);
}

/// Bad readings and lost rows are no reason to stop: they are counted and reported.
#[test]
fn bad_readings_and_gaps_are_counted() {
    let folder = tempfile::tempdir().unwrap();
    let mut text = "t_s,stylus\n".to_owned();
    for i in 0..2000_u32 {
        let t = f64::from(i) * 1e-4 + if i > 1500 { 0.05 } else { 0.0 };
        let stylus = match i % 100 {
            7 => "NaN".to_owned(),
            27 => "1e30".to_owned(),
            47 => "-inf".to_owned(),
            67 => "4e-3".to_owned(),
            87 => String::new(),
            _ => format!("{:e}", 1e-7 * f64::from(i * 7919 % 101)),
        };
        text += &format!("{t:.6},{stylus}\n");
    }
    put(&folder, "dirty.csv", text);
    let ran = gripctl(&folder, "replay dirty.csv --json");
    assert_eq!(ran.code, 3, "{ran:?}");
    let summary = ran.json().pop().unwrap();
    assert_eq!((number(&summary, "unusable"), number(&summary, "lost")), (100.0, 1.0), "{summary}");
    assert_eq!(summary["samples"], 2000);
    for word in [
        "dirty.csv",
        "NaN readings: 20",
        "infinite readings: 20",
        "huge readings: 20",
        "empty cells of stylus or vibration: 20",
        "gaps: 1",
        "0.050",
    ] {
        assert!(ran.err.contains(word), "no {word:?} in {}", ran.err);
    }
    put(&folder, "nan.csv", "t_s,stylus\n0,NaN\n0.001,NaN\n0.002,NaN\n");
    let ran = gripctl(&folder, "replay nan.csv --json").done();
    assert_eq!(ran.json().pop().unwrap()["unusable"], 3);
}

/// Three seconds of noise with a wrong reading every 0.1 s: replaced, counted in both summaries, and no slip.
#[test]
fn isolated_readings_are_counted_and_are_no_slips() {
    let folder = tempfile::tempdir().unwrap();
    let mut text = "t_s,vibration\n".to_owned();
    let mut noise = normal(3);
    for i in 0..30_000_u32 {
        let wrong = if i % 1000 == 500 { 40.0 } else { 0.0 };
        text += &format!("{:.4},{:.4}\n", f64::from(i) * 1e-4, noise() + wrong);
    }
    put(&folder, "spiked.csv", text);
    let summary = gripctl(&folder, "replay spiked.csv --json").last();
    let figures = ["isolated", "unusable", "slips"].map(|name| number(&summary, name));
    assert_eq!(figures, [30.0, 0.0, 0.0], "{summary}");
    let ran = gripctl(&folder, "replay spiked.csv").done();
    assert!(ran.out.contains("0 unusable readings, 30 isolated, 0 slips"), "{}", ran.out);
}

/// Real recordings with a 400 Hz tone, serial glitches and drop-outs.
#[test]
#[ignore = "needs the recordings (CONTRIBUTING.md, Data)"]
fn dirty_recordings_of_a_hand_held_stylus() {
    let folder = real_data("stylus_accel_1k");
    let summary = |folder: &Path, name: &str, more: &str| {
        let args = &format!("replay {name} --json --map vibration=acceleration {more}");
        let ran = gripctl(folder, args);
        assert!([0, 3].contains(&ran.code), "{name}: {} {}", ran.code, ran.err);
        assert!(ran.err.contains("columns not used: speed_mm_s"), "{}", ran.err);
        let mut lines = ran.json();
        let summary = lines.pop().unwrap();
        assert!(number(&summary, "samples") > 1000.0, "{summary}");
        // JSON cannot hold NaN or infinity: they would stand there as null.
        for line in &lines {
            assert!(line["t_s"].is_f64(), "{line}");
            assert!(line["type"] != "slip" || line["statistic"].is_f64(), "{line}");
        }
        summary
    };
    let noisy = tempfile::tempdir().unwrap();
    for name in ["texture1.csv", "texture2.csv", "texture3.csv"] {
        let mut unusable = 0.0;
        for more in ["--no-skip", "--observe", ""] {
            unusable = number(&summary(&folder, name, more), "unusable");
        }
        // The third has a force of 36,870 N in one row.
        assert!(name != "texture3.csv" || unusable >= 1.0, "{name}: {unusable}");
        // More of the glitches its serial line made.
        let text = read(&folder, name);
        let glitch = |(row, line): (usize, &str)| match line.split(',').collect::<Vec<_>>()[..] {
            [t_s, _, force_n, speed] if row % 500 == 250 => {
                format!("{t_s},5e5,{force_n},{speed}\n")
            }
            _ => format!("{line}\n"),
        };
        let spoiled: String = text.lines().enumerate().map(glitch).collect();
        fs::write(noisy.path().join(name), spoiled).unwrap();
        let found = number(&summary(noisy.path(), name, ""), "unusable");
        assert_eq!(found, unusable + 20.0, "{name}: every glitch is counted");
    }
}

#[test]
fn one_of_more_axes_than_a_vector_has_is_chosen() {
    let folder = tempfile::tempdir().unwrap();
    let text = "t_s,vibration_1,vibration_2,vibration_3,vibration_4\n0,1,2,3,4\n0.001,1,2,3,4\n";
    put(&folder, "four.csv", text);
    let one = "replay four.csv --map vibration=vibration_2";
    let ran = gripctl(&folder, one).done();
    assert!(ran.err.contains("vibration_3"), "what is not used is said: {}", ran.err);
}
