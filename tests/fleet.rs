//! A fleet. Two grippers of a hall are on one network, and somebody looks after both from one place.
//!
//! A router runs; two gripds announce themselves. gripctl lists both, shows the slips of both, each event once, and tells one of them to hold firmer:
//! only that one does. One computer fails: everybody who watches learns that its gripper is gone, and the other one holds on.
//!
//! It needs programs with the feature `fleet`: `scripts/fleet-check.sh` runs it.
#![expect(clippy::unwrap_used, reason = "test code")]

use serde_json::Value;
use std::{collections::HashSet, fs, net::TcpListener, path::Path};
use stories::{Ended, Program, folder, in_one_of_some_runs, until};

/// Where a router can listen: a port that was free a moment ago.
fn endpoint() -> String {
    let port = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
    format!("tcp/127.0.0.1:{port}")
}

/// A gripd of the hall with a gripper of its own that holds its object, and the gripper's name.
fn gripper(folder: &Path, endpoint: &str, seed: &str) -> (Program, String) {
    fs::create_dir_all(folder).unwrap();
    let settings = format!(
        "listen = \"off\"\nallow_commands = true\n[fleet]\nsite = \"hall\"\nrouter = \"{endpoint}\"\nspool = \"spool\"\ncommands = true\n"
    );
    fs::write(folder.join("gripd.toml"), settings).unwrap();
    let args = ["--port", "sim", "--seed", seed, "--json"];
    let gripd = in_one_of_some_runs(|| {
        let gripd = Program::gripd(folder, &args);
        gripd.until_printed("\"slip_end\"");
        gripd.until_told("this gripper is there as hall/");
        let told = gripd.told();
        if told.contains("the object is gone") { Err(told) } else { Ok(gripd) }
    });
    let told = gripd.told();
    let (_, name) = told.split_once("this gripper is there as ").unwrap();
    let is_of_it = |c: char| c == '/' || c.is_ascii_alphanumeric();
    let name: String = name.chars().take_while(|c| is_of_it(*c)).collect();
    (gripd, name)
}

/// What somebody sees who looks after the hall.
fn gripctl(folder: &Path, endpoint: &str, args: &[&str]) -> Ended {
    let args = [&["fleet"], args, &["--router", endpoint]].concat();
    let ended = Program::gripctl(folder, &args).ended();
    assert_eq!(ended.code, 0, "{ended:?}");
    ended
}

/// The gripper's name in a line of gripctl.
fn name(line: &Value) -> String {
    format!("hall/{}", line["uid"].as_str().unwrap())
}

/// Names of the grippers that are there.
fn listed(folder: &Path, endpoint: &str) -> HashSet<String> {
    gripctl(folder, endpoint, &["list", "--json"]).lines().iter().map(name).collect()
}

/// Whether a line of this gripper is like that.
fn has(watch: &Program, gripper: &str, is: impl Fn(&Value) -> bool) -> bool {
    watch.lines().iter().any(|line| name(line) == gripper && is(line))
}

/// Whether a notice says that the gripper was told to hold with 14 N.
fn is_the_command(line: &Value) -> bool {
    line["text"].as_str().is_some_and(|text| text.contains("14.00 N"))
}

#[test]
fn two_grippers_are_seen_and_told_from_one_place() {
    let folder = folder();
    let here = folder.path();
    let endpoint = endpoint();
    let router = Program::gripctl(here, &["fleet", "router", "--listen", &endpoint]);
    router.until_printed("a router listens at");
    let (first, first_name) = gripper(&here.join("first"), &endpoint, "1");
    let (second, second_name) = gripper(&here.join("second"), &endpoint, "2");
    let both = HashSet::from([first_name.clone(), second_name.clone()]);
    assert_eq!(both.len(), 2, "{first_name}");
    assert_eq!(listed(here, &endpoint), both);

    let events = ["fleet", "events", "--all", "--json", "--router", &endpoint];
    let watch = Program::gripctl(here, &events);
    let ended = |line: &Value| line["phase"] == "ended";
    assert!(until(|| both.iter().all(|one| has(&watch, one, ended))), "{}", watch.printed());
    gripctl(here, &endpoint, &["command", &first_name, "at-least", "14"]);
    assert!(until(|| has(&watch, &first_name, is_the_command)), "{}", watch.printed());

    first.kill();
    let gone = |line: &Value| line["type"] == "alive" && line["alive"] == false;
    assert!(until(|| has(&watch, &first_name, gone)), "{}", watch.printed());
    assert_eq!(listed(here, &endpoint), HashSet::from([second_name.clone()]));
    assert!(!has(&watch, &second_name, gone), "{}", watch.printed());
    assert!(!has(&watch, &second_name, is_the_command), "{}", watch.printed());
    let summary = second.interrupted().done().summary();
    assert!(summary["held"] == true, "{summary}");

    let told = watch.interrupted();
    let lines = told.lines();
    let ids: Vec<_> = lines.iter().filter_map(|line| Some((name(line), line.get("id")?))).collect();
    let different: HashSet<String> = ids.iter().map(|id| format!("{id:?}")).collect();
    assert_eq!(different.len(), ids.len(), "an event came twice: {}", told.out);
}
