//! Whole runs recorded as MCAP: the replay states byte by byte what was printed, whatever happened in between.

use crate::running::{UPDATES, client, holding, receive};
use grip_link::message::daemon::{Command, NoticeKind, Operation, ToClient};
use grip_session::tape::{Played, Tape, TapeOptions, TapeSummary};
use rustix::process::Signal;
use serde_json::Value;
use std::{fs, path::Path};
use stories::Ended;

/// Lines of the replay, and what it has seen.
fn replayed(file: &Path) -> (Vec<String>, TapeSummary) {
    let (mut tape, mut lines) = (Tape::new(TapeOptions::default()), Vec::new());
    tape.play(file, &mut |played| {
        if let Played::Line(line) = played {
            lines.push(serde_json::to_string(line).unwrap());
        }
    })
    .unwrap();
    (lines, tape.summary())
}

/// The recording gives what was printed, if the machine let the recorder and the printer have everything.
pub(crate) fn replays(folder: &Path, ran: &Ended) -> TapeSummary {
    let mut printed: Vec<&str> = ran.out.lines().collect();
    let summary: Value = serde_json::from_str(printed.pop().unwrap()).unwrap();
    let whole = summary["unrecorded_samples"] == 0 && summary["untold_notes"] == 0;
    let lossy = summary["lost"] != 0 || !whole;
    assert_eq!(ran.code, if lossy { 3 } else { 0 }, "{summary}");
    let (lines, played) = replayed(&folder.join("run.mcap"));
    if whole {
        assert_eq!(lines, printed);
        assert_eq!(summary["samples"], played.samples, "{summary}");
    }
    played
}

#[test]
fn a_reload_in_between_is_replayed() {
    let folder = tempfile::tempdir().unwrap();
    let running = holding(folder.path(), &["--record", "run.mcap"]);
    fs::write(folder.path().join("gripd.toml"), "[detector.shear]\nlow_hz = 30.0\n").unwrap();
    running.signal(Signal::HUP);
    running.until_reported("the new settings are in force: detector.shear.low_hz: 20.0 -> 30.0");
    fs::write(folder.path().join("gripd.toml"), "[grip]\ntrial_force_n = 2.5\n").unwrap();
    running.signal(Signal::HUP);
    running.until_reported("grip.trial_force_n: 1.2 -> 2.5");
    // What is wrong is named and changes nothing.
    for (wrong, place) in [("[grip\n", ":1:6"), ("[grip]\nbackoff_n_s = -1.0\n", ":2:1")] {
        fs::write(folder.path().join("gripd.toml"), wrong).unwrap();
        running.signal(Signal::HUP);
        running.until_reported(&format!("the settings in force stay: gripd.toml{place}"));
    }
    let ran = running.interrupted();
    assert_eq!(replays(folder.path(), &ran).pipelines, 3);
}

/// Asks, and receives that it was carried out.
fn ask(client: &mut grip_daemon::client::Client, command: &Command) {
    client.command(command).unwrap();
    receive(client, |message| {
        assert!(!matches!(message, ToClient::Nack(_)), "{message:?}");
        matches!(message, ToClient::Notice(notice) if notice.kind == NoticeKind::Client)
    });
}

#[test]
fn what_clients_ask_for_is_replayed() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("gripd.toml"), "allow_commands = true\n").unwrap();
    let running = holding(folder.path(), &["--record", "run.mcap"]);
    let mut client = client(folder.path(), 7, UPDATES);
    let mut token = 0;
    receive(&mut client, |message| {
        if let ToClient::Welcome(welcome) = message {
            token = welcome.token;
        }
        token != 0
    });
    let at_least = Command { force_mn: 14_000, ..Command::new(Operation::AtLeast) };
    ask(&mut client, &at_least);
    receive(
        &mut client,
        |message| matches!(message, ToClient::State(state) if state.command_n >= Some(14.0)),
    );
    ask(&mut client, &Command { token, ..Command::new(Operation::Release) });
    receive(
        &mut client,
        |message| matches!(message, ToClient::State(state) if state.applied_n.is_some_and(|force| force < 0.5)),
    );
    ask(&mut client, &Command::new(Operation::Grasp));
    let ran = running.interrupted();
    assert_eq!(replays(folder.path(), &ran).pipelines, 1);
}
