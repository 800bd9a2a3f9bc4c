//! Progress of long work: on a terminal only, and never among the results.

use crate::{
    run::{Ran, gripctl, put},
    score,
};
use grip_sim::Pty;
use std::{
    fs::{self, OpenOptions},
    path::Path,
    process::{Command, Stdio},
};

/// Runs gripctl to its end with a terminal as its standard error. The results are shorter than what a pipe holds.
fn on_terminal(folder: &Path, args: &str) -> Ran {
    let terminal = Pty::open(None).unwrap();
    let host = OpenOptions::new().write(true).open(terminal.port()).unwrap();
    let mut program = Command::new(env!("CARGO_BIN_EXE_gripctl"))
        .current_dir(folder)
        .args(args.split(' '))
        .env("TERM", "xterm")
        .stdout(Stdio::piped())
        .stderr(host)
        .spawn()
        .unwrap();
    let (mut shown, mut buffer) = (Vec::new(), [0; 4096]);
    loop {
        let ended = program.try_wait().unwrap().is_some();
        terminal.wait(20_000, false).unwrap();
        let count = terminal.read(&mut buffer).unwrap();
        shown.extend_from_slice(&buffer[..count]);
        if ended && count == 0 {
            break;
        }
    }
    let ended = program.wait_with_output().unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    Ran { code: ended.status.code().unwrap(), out: text(ended.stdout), err: text(shown) }
}

/// A bar with the time left on a terminal, nothing of it elsewhere, and the same results.
#[track_caller]
fn is_shown_on_a_terminal_only(folder: &Path, args: &str, of: &str) {
    let shown = on_terminal(folder, args).done();
    assert!(shown.err.contains(of) && shown.err.contains(" left"), "{shown:?}");
    let plain = gripctl(folder, args).done();
    assert_eq!(shown.out, plain.out);
    assert!(!plain.err.contains(" left") && !plain.err.contains(['\r', '\u{1b}']), "{plain:?}");
}

#[test]
fn what_is_counted_is_shown() {
    let folder = score::folder();
    for (args, of) in [
        ("score . --detectors default,stylus --json", "/10 scores"),
        ("grasp --trials 4 --duration 1.5 --json", "/4 grasps"),
        ("import rest.csv -o made.mcap --force --json", "/1320 samples"),
        ("replay found.csv", "/1320 samples"),
    ] {
        is_shown_on_a_terminal_only(folder.path(), args, of);
    }
}

#[test]
fn collect_counts_recordings() {
    let folder = score::folder();
    // Vibrations have no rows to train on, which it reports after the last recording.
    put(&folder, "phases.csv", "recording,begin_s,end_s,cause\n");
    let args = "collect . -o rows.csv";
    let shown = on_terminal(folder.path(), args);
    assert!(
        shown.err.contains("nothing to train on") && shown.err.contains(" in 5 recordings"),
        "{shown:?}"
    );
    assert!(shown.err.contains("/5 recordings") && shown.err.contains(" left"), "{shown:?}");
    let plain = gripctl(&folder, args);
    assert!(!plain.err.contains(" left") && plain.code == shown.code, "{plain:?}");
}

#[test]
fn a_single_training_counts_epochs() {
    let folder = tempfile::tempdir().unwrap();
    let rows: String = (0..50).map(|i| format!("{i},{},{}\n", i % 7, 2 * i + i % 7)).collect();
    put(&folder, "d.csv", format!("a,b,y\n{rows}"));
    let args = "train d.csv --inputs a,b --target y --epochs 30 -o";
    let shown = on_terminal(folder.path(), &format!("{args} m.json")).done();
    assert!(shown.err.contains("/30 epochs") && shown.err.contains(" left"), "{shown:?}");
    let plain = gripctl(&folder, format!("{args} n.json")).done();
    assert!(!plain.err.contains(" left"), "{plain:?}");
    let model = |name: &str| fs::read(folder.path().join(name)).unwrap();
    assert_eq!(model("m.json"), model("n.json"), "the bar changes no bit");
}
