//! gripfleet without a gripd: what it cannot do anything with, a sentence and exit code 2; and what it waits for.
#![expect(clippy::unwrap_used, reason = "test code")]

use std::{
    fs,
    io::{BufRead as _, BufReader},
    path::Path,
    process::{Command, Stdio},
};

/// gripfleet in `folder`, unaware of the settings of whoever runs the tests.
fn gripfleet(folder: &Path, args: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_gripfleet"));
    command.current_dir(folder).env_clear().env("HOME", folder).args(args);
    command
}

/// Its exit code, and what it said.
fn ended(folder: &Path, args: &[&str]) -> (Option<i32>, String) {
    let output = gripfleet(folder, args).output().unwrap();
    assert!(output.stdout.is_empty(), "{output:?}");
    (output.status.code(), String::from_utf8(output.stderr).unwrap())
}

#[test]
fn a_configuration_that_cannot_be_used_is_refused_with_a_sentence() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |text: &str, args: &[&str], words: &str| {
        fs::write(folder.path().join("gripd.toml"), text).unwrap();
        let (code, reported) = ended(folder.path(), args);
        assert!(
            code == Some(2) && reported.contains(words),
            "{code:?}, no {words:?} in {reported}"
        );
    };
    refused("", &[], "fleet.site is not set");
    let fleet = "[fleet]\nsite = \"hall\"\n";
    let router = |router: &str| format!("{fleet}router = \"{router}\"\n");
    refused(fleet, &[], ":2:1: fleet.site is set, but neither");
    refused(&router("somewhere"), &[], ":3:1: router = somewhere: ");
    let none = format!("{fleet}network = \"none.json5\"\n");
    refused(&none, &[], "none.json5: no Zenoh configuration: ");
    let off = format!("listen = \"off\"\n{}", router("tcp/127.0.0.1:1"));
    refused(&off, &[], ":1:1: gripfleet connects to gripd, but listen is \"off\"");
    refused(&off, &["--config", "none.toml"], "none.toml");
}

#[test]
fn a_valid_configuration_is_named_so_and_a_gripd_that_is_not_there_is_waited_for() {
    let folder = tempfile::tempdir().unwrap();
    let text =
        "listen = \"unix:gripd.sock\"\n[fleet]\nsite = \"hall\"\nrouter = \"tcp/127.0.0.1:1\"\n";
    fs::write(folder.path().join("gripd.toml"), text).unwrap();
    let (code, reported) = ended(folder.path(), &["--check-config"]);
    assert!(
        code == Some(0) && reported.contains("this gripper is published at hall"),
        "{reported}"
    );
    let mut waiting = gripfleet(folder.path(), &[]).stderr(Stdio::piped()).spawn().unwrap();
    let mut lines = BufReader::new(waiting.stderr.take().unwrap()).lines();
    let line = lines.next().unwrap().unwrap();
    assert!(line.contains("no gripd answers at unix:gripd.sock"), "{line}");
    waiting.kill().unwrap();
    waiting.wait().unwrap();
}
