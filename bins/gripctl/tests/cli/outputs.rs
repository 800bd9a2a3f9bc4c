//! No command destroys anything: every output flag of every command, onto every file that it reads and onto files of somebody else.

use crate::run::{content, gripctl, put};
use core::cell::Cell;
use std::{collections::BTreeSet, fs, os::unix::fs::symlink, path::Path};

const MODEL: &str = include_str!("../../../../crates/grip-session/models/default.json");

/// An output flag: the command with all the files that it reads, and the ending of a file that it would write.
struct Writer {
    command: &'static str,
    flag: &'static str,
    ending: &'static str,
    inputs: &'static [&'static str],
}

const fn writer(
    command: &'static str,
    flag: &'static str,
    ending: &'static str,
    inputs: &'static [&'static str],
) -> Writer {
    Writer { command, flag, ending, inputs }
}

const TRAIN: &str = "train in.csv --inputs a --target b --test q.csv";

const WRITERS: [Writer; 21] = [
    writer("demo scene.toml", "--output", "csv", &["scene.toml"]),
    writer(
        "replay in.csv --model m.json --config g.toml --calibration c.toml",
        "--plot",
        "svg",
        &["in.csv", "m.json", "g.toml", "c.toml"],
    ),
    writer("replay run.mcap b.mcap", "--plot", "png", &["run.mcap", "b.mcap"]),
    writer("import in.csv", "--output", "csv", &["in.csv"]),
    writer("import in.csv", "--output", "mcap", &["in.csv"]),
    writer("recover run.mcap", "--output", "mcap", &["run.mcap"]),
    writer("csv run.mcap b.mcap", "--output", "csv", &["run.mcap", "b.mcap"]),
    writer("csv run.mcap", "--output", "npz", &["run.mcap"]),
    writer("calibrate in.csv --config g.toml", "--output", "toml", &["in.csv", "g.toml"]),
    writer("score set --config g.toml", "--curve", "json", &["set/a.csv", "g.toml"]),
    writer("profile in.csv --speed 1 --reference q.csv", "--parts", "csv", &["in.csv", "q.csv"]),
    writer("profile in.csv --speed 1 --reference q.csv", "--plot", "svg", &["in.csv", "q.csv"]),
    writer(
        "grasp scene.toml --config g.toml --model m.json",
        "--plot",
        "svg",
        &["scene.toml", "g.toml", "m.json"],
    ),
    writer(
        "grasp scene.toml --config g.toml --model m.json",
        "--rows",
        "csv",
        &["scene.toml", "g.toml", "m.json"],
    ),
    writer("generate", "--output", "csv", &[]),
    writer("collect set run.mcap", "--output", "csv", &["set/a.csv", "run.mcap"]),
    writer(TRAIN, "--output", "json", &["in.csv", "q.csv"]),
    writer("train in.csv --inputs a --target b --output new.json", "--card", "json", &["in.csv"]),
    writer(
        "search in.csv --inputs a --target b --test q.csv",
        "--output",
        "json",
        &["in.csv", "q.csv"],
    ),
    writer("export m.json --format onnx", "--output", "onnx", &["m.json"]),
    writer("export m.json --format c --output new.c", "--card", "json", &["m.json"]),
];

/// Flags whose file or folder is only read, or is no file at all.
const READ: &str = "--config --model --calibration --test --reference --sensor --folder --scenes";

/// Written otherwise: `study` into a folder, `sim` a link.
const OTHERWISE: [(&str, &str); 2] = [("study", "--out"), ("sim", "--pty")];

/// What the refusal of an output states.
const REFUSED: [&str; 4] =
    ["which is read", "in a folder that is read", "is there already", "two outputs have this name"];

#[test]
fn no_output_flag_destroys_an_input_or_what_somebody_else_made() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    fs::create_dir(here.join("set")).unwrap();
    for name in
        ["in.csv", "q.csv", "run.mcap", "b.mcap", "g.toml", "c.toml", "scene.toml", "set/a.csv"]
    {
        put(here, name, format!("content of {name}"));
    }
    put(here, "m.json", MODEL);
    let tried = Cell::new(0);
    let refused = |writer: &Writer, output: &str, more: &str, of: &[&str]| {
        let before = content(here);
        let line = format!("{} {} {output} {more}", writer.command, writer.flag);
        let ran = gripctl(here, &line);
        let shown = format!("{line}: {ran:?}");
        assert!(matches!(ran.code, 1 | 2), "{shown}");
        assert!(of.iter().any(|text| ran.err.contains(text)), "{shown}");
        assert!(content(here) == before, "changed something: {shown}");
        tried.set(tried.get() + 1);
    };
    for writer in &WRITERS {
        // The trial force of a profile has this name.
        let force = if writer.command.starts_with("profile") { "" } else { "--force" };
        for (at, input) in writer.inputs.iter().enumerate() {
            let [soft, hard] = ["soft", "hard"].map(|name| format!("{name}{at}.{}", writer.ending));
            let links = [&soft, &hard].map(|name| here.join(name));
            symlink(here.join(input), &links[0]).unwrap();
            fs::hard_link(here.join(input), &links[1]).unwrap();
            for output in [&soft, &hard] {
                refused(writer, output, force, &REFUSED[..2]);
            }
            for output in [(*input).to_owned(), format!("./{input}")] {
                let ending = ["expected a name that ends", "no name for an export"];
                refused(writer, &output, force, &[&REFUSED[..2], &ending].concat());
                refused(writer, &output, "", &[&REFUSED[..], &ending].concat());
            }
            links.iter().for_each(|link| fs::remove_file(link).unwrap());
        }
        let other = format!("other.{}", writer.ending);
        put(here, &other, "of somebody else");
        refused(writer, &other, "", &REFUSED[2..3]);
        fs::remove_file(here.join(&other)).unwrap();
    }
    assert!(tried.get() > 150, "only {tried:?}");
    // A study fills a folder, a pseudo-terminal is a link.
    fs::create_dir_all(here.join("set/rows")).unwrap();
    put(here, "set/rows/mine.npz", "mine");
    let study = writer("study --quick", "--out", "", &[]);
    refused(&study, "set", "", &REFUSED[2..3]);
    refused(&writer("sim", "--pty", "", &[]), "run.mcap", "", &["run.mcap"]);
}

/// A new command, or a new flag that names a file, is listed above, or this fails.
#[test]
fn every_flag_that_names_a_file_is_known_to_be_read_or_written() {
    let folder = tempfile::tempdir().unwrap();
    let help = gripctl(&folder, "--help").done().out;
    let commands = help.lines().skip_while(|line| *line != "Commands:").skip(1);
    let commands: Vec<&str> = commands
        .take_while(|line| !line.is_empty())
        .filter_map(|line| {
            line.strip_prefix("  ")?.split(' ').next().filter(|name| !name.is_empty())
        })
        .filter(|name| *name != "help")
        .collect();
    assert!(commands.len() > 20, "{commands:?}");
    let mut found = BTreeSet::new();
    for command in commands {
        let help = gripctl(&folder, format!("{command} --help")).done().out;
        let options = help.lines().map(str::trim_start).filter(|line| line.starts_with('-'));
        for option in options {
            let Some((_, option)) = option.split_once("--") else { continue };
            let Some((name, value)) = option.split_once(" <") else { continue };
            let flag = format!("--{name}");
            let names_file = [
                "FILE>",
                "OUTPUT>",
                "PATH>",
                "DIR>",
                "PTY>",
                "PLOT>",
                "CARD>",
                "OUT>",
                "RECORDING>",
            ]
            .iter()
            .any(|file| value.starts_with(file));
            if names_file && !READ.split(' ').any(|read| read == flag) {
                found.insert((command.to_owned(), flag));
            }
        }
    }
    let listed = WRITERS.iter().map(|writer| {
        let command = writer.command.split(' ').next().unwrap_or_default();
        (command.to_owned(), writer.flag.to_owned())
    });
    let otherwise =
        OTHERWISE.iter().map(|(command, flag)| ((*command).to_owned(), (*flag).to_owned()));
    let listed: BTreeSet<_> = listed.chain(otherwise).collect();
    assert_eq!(found, listed);
}

/// Files in which a program opens a file for writing by itself: names that it chooses, in folders of its own, and the device of a port.
const OWN: [&str; 9] = [
    "grip-record/src/outputs.rs",
    "gripctl/src/commands/export_verify.rs",
    "grip-daemon/src/dump/mod.rs",
    "grip-daemon/src/recorder/name.rs",
    "grip-fleet/src/archive/mod.rs",
    "grip-fleet/src/recordings/fetch.rs",
    "grip-fleet/src/spool.rs",
    "grip-fleet/src/store.rs",
    "grip-port/src/linux/open.rs",
];

/// `disallowed-methods` of clippy knows no tests, which write files everywhere.
#[test]
fn outputs_are_opened_in_one_place() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let mut found = BTreeSet::new();
    let rooms = ["bins", "crates", "fleet"].iter();
    let packages = rooms.flat_map(|room| fs::read_dir(root.join(room)).unwrap());
    let sources = packages.map(|package| package.unwrap().path().join("src"));
    for source in sources.filter(|source| source.is_dir()) {
        for (file, text) in content(&source) {
            let text = String::from_utf8_lossy(&text);
            let code = text.split("#[cfg(test)]").next().unwrap_or_default();
            let opens = ["File::create", "File::options()", "OpenOptions::new()", "fs::write("];
            if file.ends_with(".rs")
                && !file.ends_with("tests.rs")
                && opens.iter().any(|open| code.contains(open))
            {
                let own = OWN.iter().find(|own| file.ends_with(*own));
                found.insert(own.map_or(file, |own| (*own).to_owned()));
            }
        }
    }
    assert_eq!(found, OWN.map(str::to_owned).into());
}
