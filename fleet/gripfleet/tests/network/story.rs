//! A fleet. Two grippers of a hall are on one network, and somebody looks after both from one place.
//!
//! A router runs; two gripfleets announce their gripds. A third one lists both, shows the slips of both, each event once, and asks one of them to hold firmer:
//! only that one does. One computer fails: everybody who watches learns that its gripper is gone, and the other one holds on.

use crate::pair::{Pair, endpoint, gripfleet as start};
use serde_json::Value;
use std::{collections::HashSet, fs, path::Path};
use stories::{Ended, Program, folder, in_one_of_some_runs, until};

/// A gripd of the hall with a gripper of its own, its gripfleet, and the gripper's name.
fn gripper(folder: &Path, endpoint: &str, seed: &str) -> (Pair, String) {
    fs::create_dir(folder).unwrap();
    let settings = format!(
        "listen = \"unix:gripd.sock\"\nallow_commands = true\n[fleet]\nsite = \"hall\"\nrouter = \"{endpoint}\"\nspool = \"spool\"\ncommands = true\n"
    );
    fs::write(folder.join("gripd.toml"), settings).unwrap();
    // First, and it waits: what a gripd has sent before its gripfleet is there is published by nobody.
    let fleet = start(folder, &[]);
    let gripd = Program::gripd(folder, &["--port", "sim", "--seed", seed, "--json"]);
    let pair = Pair { gripd, fleet };
    let name = pair.name();
    (pair, name)
}

/// What somebody sees who looks after the hall.
fn gripfleet(folder: &Path, endpoint: &str, args: &[&str]) -> Ended {
    let args = [args, &["--router", endpoint]].concat();
    let ended = start(folder, &args).ended();
    assert_eq!(ended.code, 0, "{ended:?}");
    ended
}

/// The gripper's name in a line of gripfleet.
fn name(line: &Value) -> String {
    format!("hall/{}", line["uid"].as_str().unwrap())
}

/// Names of the grippers that are there.
fn listed(folder: &Path, endpoint: &str) -> HashSet<String> {
    gripfleet(folder, endpoint, &["list", "--json"]).lines().iter().map(name).collect()
}

/// Whether a line of this gripper is like that.
fn has(watch: &Program, gripper: &str, is: impl Fn(&Value) -> bool) -> bool {
    watch.lines().iter().any(|line| name(line) == gripper && is(line))
}

/// Whether a notice states that the gripper was commanded to hold with 14 N.
fn is_the_command(line: &Value) -> bool {
    line["text"].as_str().is_some_and(|text| text.contains("14.00 N"))
}

/// A morning in the hall; an error where an object fell.
fn looked_after() -> Result<(), String> {
    let folder = folder();
    let (here, endpoint) = (folder.path(), endpoint());
    let router = start(here, &["router", "--listen", &endpoint]);
    router.until_printed("a router listens at");
    let (first, first_name) = gripper(&here.join("first"), &endpoint, "1");
    let (second, second_name) = gripper(&here.join("second"), &endpoint, "2");
    let both = HashSet::from([first_name.clone(), second_name.clone()]);
    assert_eq!(both.len(), 2, "{first_name}");
    assert_eq!(listed(here, &endpoint), both);

    let events = ["events", "--all", "--json", "--router", &endpoint];
    let watch = start(here, &events);
    let ended = |line: &Value| line["phase"] == "ended";
    // Such a gripper waits for help and carries nothing out.
    let fell = || {
        [&first, &second].iter().any(|pair| pair.gripd.reported().contains("the object is gone"))
    };
    let slipped = || both.iter().all(|one| has(&watch, one, ended));
    assert!(until(|| slipped() || fell()), "{}", watch.printed());
    gripfleet(here, &endpoint, &["command", &first_name, "at-least", "14"]);
    let obeyed = || has(&watch, &first_name, is_the_command);
    assert!(until(|| obeyed() || fell()), "{}", watch.printed());
    if fell() {
        return Err(first.gripd.reported() + &second.gripd.reported());
    }

    first.gripd.kill();
    let gone = |line: &Value| line["type"] == "alive" && line["alive"] == false;
    assert!(until(|| has(&watch, &first_name, gone)), "{}", watch.printed());
    assert_eq!(listed(here, &endpoint), HashSet::from([second_name.clone()]));
    let reported = watch.interrupted();
    let of_the_second = |line: &&Value| name(line) == second_name;
    let lines = reported.lines();
    assert!(!lines.iter().filter(of_the_second).any(|line| gone(line) || is_the_command(line)));
    let ids: Vec<String> = lines.iter().filter_map(id).collect();
    let different: HashSet<&String> = ids.iter().collect();
    assert_eq!(different.len(), ids.len(), "an event came twice: {}", reported.out);
    let summary = second.gripd.interrupted().done().summary();
    if summary["held"] == true { Ok(()) } else { Err(summary.to_string()) }
}

/// The number of the event in a line, with the gripper's name.
fn id(line: &Value) -> Option<String> {
    Some(format!("{} {}", name(line), line["id"].as_str()?))
}

#[test]
fn two_grippers_are_seen_and_reported_from_one_place() {
    in_one_of_some_runs(looked_after);
}
