//! A recording that replays. gripd records a grasp; later somebody wants to know what happened, and whether it is true.
//!
//! gripctl replays the recording and finds every event byte by byte. As a table it has the same samples and the same slips. The recording of a gripd
//! that was killed in the middle has no end: gripctl saves what is there, and that replays as well.

use std::{fs, path::Path};
use stories::{Ended, Program, folder, in_one_of_some_runs, until};

/// In the line of a slip.
const SLIP: &str = "\"type\":\"slip\"";

fn gripctl(folder: &Path, args: &[&str]) -> Ended {
    Program::gripctl(folder, args).ended().done()
}

/// Records a grasp in `run.mcap`, until one recording has everything, with a slip from its beginning to its end.
fn recorded(folder: &Path) -> Ended {
    let args = ["--port", "sim", "--duration", "2.5", "--json", "--listen", "off"];
    in_one_of_some_runs(|| {
        fs::remove_file(folder.join("run.mcap")).unwrap_or_default();
        let args = [&args[..], &["--record", "run.mcap"]].concat();
        let ended = Program::gripd(folder, &args).ended().done();
        let summary = ended.summary();
        let whole = ["lost", "unrecorded_samples", "untold_notes"].map(|name| summary[name] == 0);
        if whole == [true; 3] && ended.out.contains("slip_end") {
            Ok(ended)
        } else {
            Err(format!("{summary}"))
        }
    })
}

#[test]
fn every_event_is_replayed_byte_by_byte() {
    let folder = folder();
    let ended = recorded(folder.path());
    let mut printed: Vec<&str> = ended.out.lines().collect();
    printed.pop();

    let check = gripctl(folder.path(), &["replay", "run.mcap", "--check"]);
    let reported = format!("{} events, byte by byte the recorded ones", printed.len());
    assert!(check.code == 0 && check.out.contains(&reported), "{check:?}");
    let replay = gripctl(folder.path(), &["replay", "run.mcap", "--json"]);
    let replayed: Vec<&str> = replay.out.lines().take(printed.len()).collect();
    assert_eq!(replayed, printed);
    assert_eq!(replay.summary()["samples"], ended.summary()["samples"]);

    gripctl(folder.path(), &["csv", "run.mcap", "-o", "run.csv"]);
    let table = gripctl(folder.path(), &["replay", "run.csv", "--json"]);
    assert_eq!(table.summary()["samples"], ended.summary()["samples"]);
    let slips = |lines: &[&str]| -> Vec<String> {
        let slips = lines.iter().filter(|line| line.contains("\"type\":\"slip"));
        slips.map(|line| (*line).to_owned()).collect()
    };
    assert_eq!(slips(&table.out.lines().collect::<Vec<_>>()), slips(&printed));
}

#[test]
fn the_recording_of_a_killed_gripd_is_saved() {
    let folder = folder();
    let args = ["--port", "sim", "--json", "--listen", "off", "--record", "run.mcap"];
    let gripd = Program::gripd(folder.path(), &args);
    // What is on the disk already can be replayed while it grows; one day the slip is there.
    let look = || Program::gripctl(folder.path(), &["replay", "run.mcap", "--json"]).ended();
    assert!(until(|| look().out.contains(SLIP)), "{}", gripd.reported());
    gripd.kill();

    // Either nothing but the index is missing, or the last half record as well, which counts as loss.
    let saved = gripctl(folder.path(), &["recover", "run.mcap"]);
    assert!(saved.out.contains("run.mcap: saved"), "{saved:?}");
    let again = gripctl(folder.path(), &["recover", "run.mcap"]);
    assert!(again.code == 0 && again.out.contains("run.mcap is whole"), "{again:?}");
    let replay = gripctl(folder.path(), &["replay", "run.mcap", "--json"]);
    assert!(replay.out.contains(SLIP), "{replay:?}");
}
