//! Progress of long work: on a terminal only, and never among the results.

use crate::{
    run::{Ran, gripctl},
    score,
};
use grip_sim::Pty;
use std::{
    fs::OpenOptions,
    path::Path,
    process::{Command, Stdio},
};

/// Runs gripctl to its end with a terminal as its standard error. The results are shorter than what a pipe holds.
fn on_terminal(folder: &Path, args: &[&str]) -> Ran {
    let terminal = Pty::open(None).unwrap();
    let host = OpenOptions::new().write(true).open(terminal.port()).unwrap();
    let mut program = Command::new(env!("CARGO_BIN_EXE_gripctl"))
        .current_dir(folder)
        .args(args)
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
fn is_shown_on_a_terminal_only(folder: &Path, args: &[&str], of: &str) {
    let shown = on_terminal(folder, args).done();
    assert!(shown.err.contains(of) && shown.err.contains(" left"), "{shown:?}");
    let plain = gripctl(folder, args).done();
    assert_eq!(shown.out, plain.out);
    assert!(!plain.err.contains(" left") && !plain.err.contains(['\r', '\u{1b}']), "{plain:?}");
}

#[test]
fn score_counts_recordings_and_detectors() {
    let folder = score::folder();
    let args = ["score", ".", "--detectors", "default,energy", "--json"];
    is_shown_on_a_terminal_only(folder.path(), &args, "/10 scores");
}

#[test]
fn grasp_counts_grasps() {
    let folder = tempfile::tempdir().unwrap();
    let args = ["grasp", "--trials", "4", "--duration", "1.5", "--json"];
    is_shown_on_a_terminal_only(folder.path(), &args, "/4 grasps");
}

#[test]
fn import_counts_samples() {
    let folder = score::folder();
    let args = ["import", "rest.csv", "-o", "made.mcap", "--json"];
    is_shown_on_a_terminal_only(folder.path(), &args, "/1320 samples");
}
