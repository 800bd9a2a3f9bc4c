//! `gripfleet archive`, killed before and after it has put events on disk, and stopped, beside a router and a gripper that the test plays.

use crate::fleet::{Ends, endpoint, play, router};
use core::{sync::atomic::AtomicBool, time::Duration};
use grip_record::mcap::{Foreign, ForeignReader, no_unpack};
use rustix::process::{Pid, Signal, kill_process};
use serde_json::Value;
use std::{
    fs,
    path::Path,
    process::{self, Child},
    thread,
};

fn archive(folder: &Path, endpoint: &str) -> Child {
    let mut command = process::Command::new(env!("CARGO_BIN_EXE_gripfleet"));
    command.args(["archive", "--router", endpoint]).arg(folder).spawn().unwrap()
}

/// Waits until the last event is on disk.
fn until_kept(folder: &Path) {
    for _ in 0..3000 {
        let state = fs::read_to_string(folder.join("archive.json")).unwrap_or_default();
        if state.contains("00000001.3") {
            return;
        }
        thread::park_timeout(Duration::from_millis(20));
    }
    panic!("nothing was archived");
}

/// Numbers of the events in all files.
fn archived(folder: &Path) -> Vec<String> {
    let files = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut found = Vec::new();
    for file in files.filter(|file| file.extension().is_some_and(|ending| ending == "mcap")) {
        let mut reader = ForeignReader::open(&file, no_unpack).unwrap();
        while let Some(item) = reader.next_item().unwrap() {
            let Foreign::Message { data, .. } = item else { continue };
            let value: Value = serde_json::from_slice(data).unwrap();
            if value["type"] == "notice" {
                found.push(value["id"].as_str().unwrap().to_owned());
            }
        }
    }
    found
}

#[test]
fn kills_cost_the_archive_no_event_and_double_none() {
    let folder = tempfile::tempdir().unwrap();
    let (endpoint, here) = (endpoint(), folder.path().join("archive"));
    let router = router(&endpoint);
    let (end, there) = (AtomicBool::new(false), AtomicBool::new(false));
    thread::scope(|scope| {
        let ends = Ends(&end, router);
        scope.spawn(|| play(&endpoint, &end, &there));
        for kill in 0..3 {
            let mut child = archive(&here, &endpoint);
            if kill == 0 {
                thread::park_timeout(Duration::from_millis(400));
            } else {
                until_kept(&here);
            }
            child.kill().unwrap();
            child.wait().unwrap();
        }
        let mut last = archive(&here, &endpoint);
        until_kept(&here);
        thread::park_timeout(Duration::from_secs(2));
        kill_process(Pid::from_child(&last), Signal::TERM).unwrap();
        let code = last.wait().unwrap().code();
        drop(ends);
        assert_eq!(code, Some(0));
    });
    assert_eq!(archived(&here), ["00000001.1", "00000001.2", "00000001.3"]);
}
