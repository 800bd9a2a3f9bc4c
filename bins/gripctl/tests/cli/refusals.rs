//! What a person may get wrong: each is refused with one message that states what, where and what to do. Most of it stands in
//! refusals.toml.

use crate::run::{content, gripctl, put};
use rustix::fs::{CWD, FileType, Mode, mknodat};
use serde::Deserialize;
use std::{
    collections::BTreeMap,
    fs::{self, File},
    os::unix::fs::symlink,
    process::Command,
};

const MODEL: &str = include_str!("../../../../crates/grip-session/models/default.json");

/// The pages of refusals.toml, where the fields are explained.
#[derive(Deserialize)]
struct Book {
    page: Vec<Page>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Page {
    about: String,
    #[serde(default)]
    files: BTreeMap<String, String>,
    #[serde(default)]
    folders: Vec<String>,
    #[serde(default)]
    before: Vec<String>,
    model: Option<String>,
    put: Option<String>,
    run: Vec<String>,
    #[serde(default)]
    say: Vec<String>,
    cases: Vec<Case>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Case {
    #[serde(default)]
    args: String,
    text: Option<String>,
    #[serde(default)]
    say: Vec<String>,
    #[serde(default = "wrong")]
    code: i32,
}

const fn wrong() -> i32 {
    2
}

#[test]
fn what_is_wrong_is_stated_in_a_sentence_and_leaves_nothing_behind() {
    let book: Book = toml::from_str(include_str!("refusals.toml")).unwrap();
    for page in book.page {
        let folder = tempfile::tempdir().unwrap();
        let here = folder.path();
        page.folders.iter().for_each(|name| fs::create_dir(here.join(name)).unwrap());
        let model = page.model.map(|name| (name, MODEL.to_owned()));
        for (name, text) in page.files.into_iter().chain(model) {
            put(here, name, text);
        }
        for line in &page.before {
            gripctl(here, line).done();
        }
        for case in &page.cases {
            if let (Some(name), Some(text)) = (&page.put, &case.text) {
                put(here, name, text);
            }
            let before = content(here);
            for run in &page.run {
                let line = format!("{run} {}", case.args);
                println!("{}: {line} {:?}", page.about, case.text);
                let words: Vec<&str> =
                    page.say.iter().chain(&case.say).map(String::as_str).collect();
                gripctl(here, line).refused(case.code, &words);
                assert_eq!(content(here), before);
            }
        }
    }
}

#[test]
fn rubbish_is_shown_in_short_and_without_control_characters() {
    let folder = tempfile::tempdir().unwrap();
    let rubbish: Vec<u8> =
        (0..40_000_u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 13).to_le_bytes()[0]).collect();
    put(&folder, "r.csv", rubbish);
    let ran = gripctl(&folder, "replay r.csv");
    let shown = ran.refused(2, &["r.csv", "is no text"]).err;
    assert!(
        shown.len() < 8000 && !shown.trim_end().contains(|c: char| c.is_control() && c != '\n'),
        "{shown}"
    );
    // Letters, of which half are none.
    let letters: String =
        (0..40_000_u32).map(|i| if i % 2 == 0 { '\u{fffd}' } else { 'a' }).collect();
    put(&folder, "l.csv", letters);
    let shown = gripctl(&folder, "replay l.csv").refused(2, &["nothing was taken"]).err;
    assert!(shown.len() < 8000, "{shown}");
}

#[test]
fn a_program_that_stands_beside_gripctl_is_named() {
    let folder = tempfile::tempdir_in(env!("CARGO_TARGET_TMPDIR")).unwrap();
    let [gripctl, gripfleet] = ["gripctl", "gripfleet"].map(|name| folder.path().join(name));
    fs::hard_link(env!("CARGO_BIN_EXE_gripctl"), &gripctl).unwrap();
    fs::write(&gripfleet, "").unwrap();
    let ran = Command::new(gripctl).arg("fleet").output().unwrap();
    let stated = format!("gripctl: `gripfleet COMMAND` does it: {}\n", gripfleet.display());
    assert_eq!(String::from_utf8(ran.stderr).unwrap(), stated);
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
            let refuse = |args: &str| gripctl(&folder, args).refused(2, &[&file]);
            match ending {
                "json" => {
                    refuse(&format!("estimate {file}"));
                    refuse(&format!("export {file} --format c"));
                    continue;
                }
                "toml" => {
                    refuse(&format!("grasp {file}"));
                    refuse(&format!("replay r.csv --calibration {file}"));
                    // Settings that show nothing are the shipped ones.
                    if name != "empty" {
                        refuse(&format!("replay r.csv --config {file}"));
                    }
                    continue;
                }
                _ => {}
            }
            refuse(&format!("replay {file}"));
            refuse(&format!("import {file}"));
            if ending == "csv" || ending == "npz" {
                refuse(&format!("calibrate {file} -o c.toml"));
                refuse(&format!("label {file} --rest"));
                refuse(&format!("train {file} --inputs a --target b -o m.json"));
            }
            if ending == "csv" {
                refuse(&format!("profile {file} --speed 1"));
            }
            if ending == "mcap" {
                refuse(&format!("recover {file} -o whole.mcap"));
                refuse(&format!("csv {file} -o out.csv"));
            }
            if name != "folder" && ending != "db3" && ending != "wav" && ending != "npy" {
                refuse(&format!("collect {file} -o rows.csv"));
            }
        }
    }
    for name in ["fifo.csv", "folder.csv", "empty.csv", "endless.csv"] {
        fs::remove_file(folder.path().join("labels.csv")).unwrap_or_default();
        symlink(folder.path().join(name), folder.path().join("labels.csv")).unwrap();
        gripctl(&folder, "score .").refused(2, &["labels.csv"]);
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
        gripctl(&folder, format!("replay {name}")).refused(2, &[name, "not a regular file"]);
    }
    gripctl(&folder, "replay large.npz").refused(2, &["large.npz", "no archive"]);
    // A CSV may have any length, but no line may.
    for command in ["replay large.csv", "calibrate large.csv -o c.toml"] {
        gripctl(&folder, command).refused(2, &["large.csv", "a line has more than 1048576 bytes"]);
    }
    for name in ["fifo.csv", "large.csv", "large.npz"] {
        let words = if name.starts_with("fifo") { "not a regular file" } else { name };
        gripctl(&folder, format!("import {name} -o x.csv")).refused(2, &[name, words]);
    }
    let train = "train /dev/zero --inputs a --target b -o m.json";
    gripctl(&folder, train).refused(2, &["/dev/zero", "not a regular file"]);
}

#[test]
fn models_of_another_version_or_with_a_weight_that_is_none() {
    let folder = tempfile::tempdir().unwrap();
    put(&folder, "r.csv", "t_s,stylus\n0,0\n0.001,0\n0.002,0\n");
    for (text, words) in [
        (MODEL.replace("\"version\": 1", "\"version\": 2"), ["version 2", "gripctl train"]),
        (MODEL.replacen("0.", "null", 1), ["line ", "column "]),
    ] {
        put(&folder, "m.json", text);
        let words = [words[0], words[1], "m.json"];
        gripctl(&folder, "replay r.csv --model m.json").refused(2, &words);
        gripctl(&folder, "eval m.json r.csv").refused(2, &words);
    }
}
