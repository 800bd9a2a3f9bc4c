//! SIGHUP on a gripd that holds an object: what cannot be used changes nothing, what can be is in force, and nobody lets go.

use crate::running::{Running, UPDATES, receive};
use grip_link::message::daemon::{GripState, ToClient};
use rustix::process::Signal;
use serde_json::Value;
use std::fs;

/// What is held, with which force.
fn holding(running: &Running, nonce: u16) -> (GripState, f32) {
    let mut client = running.client(nonce, UPDATES);
    let mut held = None;
    receive(&mut client, |message| {
        if let ToClient::State(state) = message {
            held = state.command_n.map(|force| (state.grip, force));
        }
        held.is_some()
    });
    held.unwrap()
}

#[test]
fn a_broken_file_changes_nothing_and_a_good_one_lets_nothing_fall() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("gripd.toml");
    let running = Running::holding(folder.path(), &[]);
    let before = holding(&running, 1);
    for (text, words) in [
        ("grip = 3\n", "the settings in force stay: gripd.toml:1:8: invalid type"),
        ("[grip]\nf_max_n = -1.0\n", "gripd.toml:2:1: grip.f_max_n = -1 is outside"),
        ("model = \"gone.json\"\n", "the settings in force stay: "),
    ] {
        fs::write(&file, text).unwrap();
        running.signal(Signal::HUP);
        running.wait_for(words);
    }
    assert!(!running.reported().contains("are in force:"), "{}", running.reported());
    fs::write(&file, "listen = \"off\"\n[detector.shear]\nlow_hz = 30.0\n").unwrap();
    running.signal(Signal::HUP);
    running.wait_for("are in force: detector.shear.low_hz: 20.0 -> 30.0");
    let after = holding(&running, 2);
    assert_eq!(after.0, before.0);
    // The force that the object needs, and what it has been settling down to since the slip.
    assert!(after.1 > 7.85 && after.1 < before.1 + 0.5, "{before:?} {after:?}");
    let ran = running.stop();
    let summary: Value = serde_json::from_str(ran.out.lines().last().unwrap()).unwrap();
    assert_eq!(summary["held"], true, "{summary}");
    assert_eq!(summary["slips"], 1, "the object was held all the time: {}", ran.out);
}
