//! `gripfleet archive`, killed before and after it has put events on disk, and stopped, beside a router and a gripper that the test plays.

use crate::{
    fleet::{gripper, router, running},
    rig::endpoint,
};
use core::time::Duration;
use grip_record::mcap::{Foreign, ForeignReader, no_unpack};
use serde_json::Value;
use std::{fs, path::Path, thread};
use stories::{Signal, until};

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
    let endpoint = endpoint();
    let _router = router(&endpoint);
    let _gripper = gripper(&endpoint);
    let here = folder.path().join("archive");
    let archive = || running(folder.path(), &["archive", "archive", "--router", &endpoint]);
    // Until the last event is on disk.
    let is_kept = || {
        let state = fs::read_to_string(here.join("archive.json")).unwrap_or_default();
        state.contains("00000001.3")
    };
    let early = archive();
    thread::park_timeout(Duration::from_millis(400));
    early.kill();
    for _ in 0..2 {
        let late = archive();
        assert!(until(is_kept));
        late.kill();
    }
    let last = archive();
    assert!(until(is_kept));
    thread::park_timeout(Duration::from_secs(2));
    last.signal(Signal::TERM);
    assert_eq!(last.ended().code, 0);
    assert_eq!(archived(&here), ["00000001.1", "00000001.2", "00000001.3"]);
}
