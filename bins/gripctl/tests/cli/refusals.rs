//! What a person may get wrong: each is refused with one message that says what, where and what to do.

use crate::run::gripctl;
use rustix::fs::{CWD, FileType, Mode, mknodat};
use std::{
    fs::{self, File},
    os::unix::fs::symlink,
};

const MODEL: &str = include_str!("../../../../crates/grip-session/models/default.json");

#[test]
fn recordings() {
    let folder = tempfile::tempdir().unwrap();
    let refuse = |bytes: &[u8], words: &[&str]| {
        fs::write(folder.path().join("r.csv"), bytes).unwrap();
        let words: Vec<&str> = words.iter().copied().chain(["r.csv"]).collect();
        gripctl(folder.path(), &["replay", "r.csv"]).refused(2, &words);
    };
    refuse(b"", &["is empty", "the first line must name the columns"]);
    refuse(b"t_s,stylus\n", &["no rows"]);
    refuse(b"t_s,stylus\n0,1\n0.1,2,\n", &["line 3", "3 fields", "remove the extra commas"]);
    refuse(b"t_s,stylus\n0,1\n0.1\n", &["line 3", "1 fields", "add the missing"]);
    refuse(b"t_s,stylus\n0,1\n0.1,abc\n", &["line 3, column stylus", "\"abc\" is not a number"]);
    refuse(b"t_s,stylus\n0,1\n0,2\n1,5,5\n", &["line 4"]);
    refuse(b"t_s,stylus\nnan,1\n", &["line 2, column t_s", "\"nan\""]);
    refuse(b"t_s,stylus\n-1,1\n", &["line 2, column t_s", "\"-1\"", "start at 0"]);
    refuse(
        b"t_s,stylus\n0,1\n0.2,1\n0.1,2\n",
        &["line 4, column t_s", "backwards", "sort the rows"],
    );
    refuse(b"t_s,stylus\n5,1\n5,2\n5,3\n", &["the rate cannot be told", "--rate HZ"]);
    refuse(b"t_s,stylus,stylus\n0,1,1\n", &["columns 2 and 3", "\"stylus\""]);
    refuse(
        b"t_s,height\n0,1\n",
        &[
            "no column stylus, vibration, travel_m or pressure_0",
            "--map vibration=NAME",
            "t_s, height",
        ],
    );
    refuse(b"stylus\n1\n2\n", &["no column t_s and no rate", "--rate HZ"]);
    refuse(b"t_s,stylus,vibration\n0,1,1\n", &["stylus and vibration", "--map"]);
    refuse(b"t_s,stylus\n0,1\n1,1\n2,1\n", &["sample_rate_hz = 1 is outside 20 to 50000"]);
    let rubbish: Vec<u8> =
        (0..40_000_u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 13).to_le_bytes()[0]).collect();
    refuse(&rubbish, &["no column stylus"]);
    let shown = gripctl(folder.path(), &["replay", "r.csv"]).err;
    assert!(
        shown.len() < 8000 && !shown.trim_end().contains(|c: char| c.is_control() && c != '\n'),
        "{shown}"
    );
    gripctl(folder.path(), &["replay", "."]).refused(2, &["directory"]);
    gripctl(folder.path(), &["replay", "gone.csv"]).refused(2, &["gone.csv", "No such file"]);
}

/// A file that is no recording is refused alike by all that read one: a FIFO and a device without waiting, a folder, nothing.
#[test]
fn files_that_are_no_recordings() {
    let folder = tempfile::tempdir().unwrap();
    for ending in ["csv", "npz", "mcap", "npy", "wav", "db3", "json", "toml"] {
        let path = |name: &str| folder.path().join(format!("{name}.{ending}"));
        mknodat(CWD, path("fifo"), FileType::Fifo, Mode::RWXU, 0).unwrap();
        fs::create_dir(path("folder")).unwrap();
        fs::write(path("empty"), "").unwrap();
        fs::write(path("rubbish"), [0x9C; 5000]).unwrap();
        symlink("/dev/zero", path("endless")).unwrap();
        for name in ["fifo", "folder", "empty", "rubbish", "endless", "gone"] {
            let file = format!("{name}.{ending}");
            let refuse = |args: &[&str]| gripctl(folder.path(), args).refused(2, &[&file]);
            match ending {
                "json" => {
                    refuse(&["estimate", &file]);
                    refuse(&["export", &file, "--format", "c"]);
                    continue;
                }
                "toml" => {
                    refuse(&["grasp", &file]);
                    refuse(&["replay", "r.csv", "--calibration", &file]);
                    // Settings that say nothing are the shipped ones.
                    if name != "empty" {
                        refuse(&["replay", "r.csv", "--config", &file]);
                    }
                    continue;
                }
                _ => {}
            }
            refuse(&["replay", &file]);
            refuse(&["import", &file]);
            if ending == "csv" || ending == "npz" {
                refuse(&["calibrate", &file, "-o", "c.toml"]);
                refuse(&["label", &file, "--rest"]);
                refuse(&["train", &file, "--inputs", "a", "--target", "b", "-o", "m.json"]);
            }
            if ending == "csv" {
                refuse(&["profile", &file, "--speed", "1"]);
            }
            if ending == "mcap" {
                refuse(&["recover", &file, "-o", "whole.mcap"]);
                refuse(&["csv", &file, "-o", "out.csv"]);
            }
            if name != "folder" && ending != "db3" && ending != "wav" && ending != "npy" {
                refuse(&["collect", &file, "-o", "rows.csv"]);
            }
        }
    }
    for name in ["fifo.csv", "folder.csv", "empty.csv", "endless.csv"] {
        fs::remove_file(folder.path().join("labels.csv")).unwrap_or_default();
        symlink(folder.path().join(name), folder.path().join("labels.csv")).unwrap();
        gripctl(folder.path(), &["score", "."]).refused(2, &["labels.csv"]);
    }
}

/// What never ends, waits for a writer or does not fit into memory is refused before it is read.
#[test]
fn files_that_cannot_be_held() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    for name in ["fifo.csv", "fifo.mcap"] {
        mknodat(CWD, path(name), FileType::Fifo, Mode::RWXU, 0).unwrap();
    }
    for name in ["large.csv", "large.npz"] {
        File::create(path(name)).unwrap().set_len(1 << 40).unwrap();
    }
    for name in ["fifo.csv", "fifo.mcap", "/dev/zero"] {
        gripctl(folder.path(), &["replay", name]).refused(2, &[name, "not a regular file"]);
    }
    gripctl(folder.path(), &["replay", "large.npz"]).refused(2, &["1099511627776 bytes"]);
    // A CSV may have any length, but no line may.
    for command in [&["replay", "large.csv"][..], &["calibrate", "large.csv", "-o", "c.toml"]] {
        gripctl(folder.path(), command)
            .refused(2, &["large.csv", "a line has more than 1048576 bytes"]);
    }
    for name in ["fifo.csv", "large.csv", "large.npz"] {
        let words = if name.starts_with("fifo") { "not a regular file" } else { name };
        gripctl(folder.path(), &["import", name, "-o", "x.csv"]).refused(2, &[name, words]);
    }
    let train = ["train", "/dev/zero", "--inputs", "a", "--target", "b", "-o", "m.json"];
    gripctl(folder.path(), &train).refused(2, &["/dev/zero", "not a regular file"]);
}

#[test]
fn arguments() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("r.csv"), "a,b\n1,2\n2,3\n").unwrap();
    fs::create_dir(folder.path().join("empty")).unwrap();
    fs::write(folder.path().join("file"), "mine").unwrap();
    let refuse = |args: &[&str], words: &[&str]| {
        gripctl(folder.path(), args).refused(2, words);
    };
    refuse(&["replay", "r.csv", "--map", "nonsense"], &["--map nonsense", "OURS=NAME"]);
    refuse(&["replay", "r.csv", "--map", "foo=a"], &["--map foo=a", "t_s, stylus, vibration"]);
    refuse(&["replay", "r.csv", "--map", "stylus=c"], &["--map stylus=c", "a, b"]);
    let twice = ["replay", "r.csv", "--map", "stylus=a", "--map", "vibration=a"];
    refuse(&twice, &["\"a\" twice"]);
    for rate in ["0", "-1", "nan", "inf"] {
        refuse(
            &["replay", "r.csv", "--map", "stylus=a", "--rate", rate],
            &["--rate", "0.001 and 1000000"],
        );
    }
    refuse(&["replay"], &["<FILE>"]);
    for duration in ["0", "-1", "nan", "1e99"] {
        refuse(&["sim", "--pty", "p", "--duration", duration], &["--duration", "more than 0"]);
        refuse(&["grasp", "--duration", duration], &["--duration", "more than 0"]);
    }
    refuse(&["sim"], &["--pty"]);
    refuse(&["sim", "--pty", "p", "--scene", "nope"], &["\"nope\"", "built in are default"]);
    refuse(&["grasp", "nope"], &["\"nope\"", "built in are default"]);
    refuse(&["grasp", "--trials", "0"], &["--trials"]);
    refuse(&["grasp", "--scenes", "empty"], &["--scenes empty", ".toml"]);
    refuse(&["grasp", "--scenes", "gone"], &["--scenes gone", "No such file"]);
    refuse(&["fly"], &["fly", "--help"]);
    let occupied = gripctl(folder.path(), &["sim", "--pty", "file"]);
    occupied.refused(1, &["file exists and is not a symbolic link"]);
    assert_eq!(fs::read_to_string(folder.path().join("file")).unwrap(), "mine");
    gripctl(folder.path(), &["sim", "--pty", "gone/p"]).refused(1, &["gone/p", "No such file"]);
}

#[test]
fn configurations_models_and_scenes() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("r.csv"), "t_s,stylus\n0,0\n0.001,0\n0.002,0\n").unwrap();
    let refuse = |name: &str, text: &str, args: &[&str], words: &[&str]| {
        fs::write(folder.path().join(name), text).unwrap();
        let words: Vec<&str> = words.iter().copied().chain([name]).collect();
        gripctl(folder.path(), args).refused(2, &words);
    };
    let config = |text: &str, words: &[&str]| {
        refuse("c.toml", text, &["replay", "r.csv", "--config", "c.toml"], words);
        refuse("c.toml", text, &["grasp", "--trials", "1", "--config", "c.toml"], words);
    };
    config("[grip]\nforce = 3\n", &["c.toml:2:1: unknown field `force`", "expected one of"]);
    config(
        "[grip]\nf_max_n = 5.0\ntrial_force_n = 7.0\n",
        &["c.toml:3:1: grip.trial_force_n = 7 is outside 0.01 to 5"],
    );
    let model = |text: &str, words: &[&str]| {
        refuse("m.json", text, &["replay", "r.csv", "--model", "m.json"], words);
        refuse("m.json", text, &["eval", "m.json", "r.csv"], words);
    };
    model(&MODEL.replace("\"version\": 1", "\"version\": 2"), &["version 2", "gripctl train"]);
    model(&MODEL.replacen("0.", "null", 1), &["line ", "column "]);
    model("[1, 2", &["line 1, column"]);
    let scene = |text: &str, words: &[&str]| {
        refuse("s.toml", text, &["grasp", "s.toml", "--trials", "1"], words);
        refuse("s.toml", text, &["sim", "--pty", "p", "--scene", "s.toml"], words);
    };
    scene("name = \"x\"\nmas_kg = 1\n", &["line 2, column 1", "`mas_kg`"]);
    scene("name = \"x\"\n\nmass_kg = 0\n", &["s.toml:3:1: mass_kg = 0 is outside 0.005 to 20"]);
    scene("name = \"x\"\n[drive]\nlag_ms = -1\n", &["s.toml:3:1: drive.lag_ms = -1"]);
    gripctl(folder.path(), &["grasp", "gone.toml"]).refused(2, &["gone.toml", "No such file"]);
}
