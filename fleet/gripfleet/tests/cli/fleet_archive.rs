//! `gripfleet archive` killed again and again, beside a router and grippers that the test plays and that start again in between.

use crate::fleet::{endpoint, notice, router};
use core::{
    sync::atomic::{AtomicBool, AtomicU32, Ordering},
    time::Duration,
};
use grip_fleet::{
    EventLog, Member, Spool, Topic, Uid,
    net::{Announced, NetError, Network},
    wire,
};
use grip_link::message::{Kind, daemon::Health};
use grip_record::mcap::{Foreign, ForeignReader, no_unpack};
use rustix::process::{Pid, Signal, kill_process};
use serde_json::Value;
use std::{
    collections::BTreeMap,
    fs,
    path::Path,
    process::{self, Child},
    thread,
};

const STEP: Duration = Duration::from_millis(3);
/// Steps before the test gives up: more than a minute.
const MOST: usize = 30_000;
const KILLS: u64 = 8;
const ROOM: usize = 1 << 22;
const UIDS: [u8; 2] = [0xAB, 0xCD];

/// What the grippers are to do, and where they are.
#[derive(Default)]
struct Script {
    /// The run that they are in.
    run: AtomicU32,
    /// No more events.
    quiet: AtomicBool,
    end: AtomicBool,
}

fn member(uid: u8) -> Member {
    Member { site: "hall".parse().unwrap(), uid: Uid([uid; 16]) }
}

/// One gripper with many events, until the end; how many each run had.
fn play(endpoint: &str, spool: &Path, uid: u8, script: &Script) -> Vec<u64> {
    let (member, mut counts) = (member(uid), Vec::new());
    let health = wire(Kind::HEALTH, |out| Health::default().write(out).unwrap());
    while !script.end.load(Ordering::SeqCst) {
        let run = script.run.load(Ordering::SeqCst);
        let session = Network { router: Some(endpoint.to_owned()), file: None }.open().unwrap();
        let mut spool = Spool::open(spool, member.uid, run, ROOM).unwrap();
        let mut announced = loop {
            match Announced::new(&session, &member, &[]) {
                Ok(announced) => break announced,
                Err(NetError::Taken { .. }) => thread::yield_now(),
                Err(error) => panic!("{error}"),
            }
        };
        let ends = || script.end.load(Ordering::SeqCst) || script.run.load(Ordering::SeqCst) != run;
        for at in 0_usize.. {
            if ends() {
                break;
            }
            if !script.quiet.load(Ordering::SeqCst) {
                let wire = notice(&at.to_string());
                let id = spool.append(wire.clone());
                announced.publish(Topic::Events, id, &wire);
            }
            if at.is_multiple_of(20) {
                announced.publish(Topic::Health, spool.log().head(), &health);
            }
            let with_log = |use_it: &mut dyn FnMut(&EventLog)| use_it(spool.log());
            announced.answer(&with_log, &[&health], "");
            thread::park_timeout(STEP);
        }
        counts.push(spool.log().head().seq);
    }
    counts
}

fn archive(folder: &Path, endpoint: &str) -> Child {
    let mut command = process::Command::new(env!("CARGO_BIN_EXE_gripfleet"));
    command.args(["archive", "--router", endpoint]).arg(folder).spawn().unwrap()
}

/// Numbers of the events of each gripper in all files, in their order.
fn archived(folder: &Path) -> BTreeMap<String, Vec<String>> {
    let mut files: Vec<_> = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|ending| ending == "mcap"))
        .collect();
    // The first of a day has no number.
    files.sort_by_key(|file| file.file_stem().unwrap().to_owned());
    let mut found = BTreeMap::<String, Vec<String>>::new();
    for file in files {
        let mut reader = ForeignReader::open(&file, no_unpack).unwrap();
        while let Some(item) = reader.next_item().unwrap() {
            let Foreign::Message { data, .. } = item else { continue };
            let value: Value = serde_json::from_slice(data).unwrap();
            let text = |name: &str| value[name].as_str().unwrap().to_owned();
            if text("type") == "notice" {
                found.entry(text("uid")).or_default().push(text("id"));
            } else {
                assert_eq!(text("type"), "health", "{value}");
            }
        }
    }
    found
}

/// Whether the state of the archive names so many events of each run of each gripper.
fn is_complete(folder: &Path) -> bool {
    let Ok(state) = fs::read(folder.join("archive.json")) else { return false };
    let state: Value = serde_json::from_slice(&state).unwrap();
    // Written once more, and without an event: all that there were are in it.
    UIDS.iter().all(|uid| state["received"][member(*uid).to_string()].as_array().is_some())
}

#[test]
fn kills_cost_the_archive_no_event_and_double_none() {
    let folder = tempfile::tempdir().unwrap();
    let (endpoint, script) = (endpoint(), Script::default());
    let mut router = router(&endpoint);
    let (spool, here) = (folder.path().join("spool"), folder.path().join("archive"));
    thread::scope(|scope| {
        let played = UIDS.map(|uid| {
            scope.spawn({
                let (endpoint, spool, script) = (&endpoint, &spool, &script);
                move || play(endpoint, spool, uid, script)
            })
        });
        for kill in 0..KILLS {
            let mut child = archive(&here, &endpoint);
            thread::park_timeout(Duration::from_millis(400 + 317 * kill));
            child.kill().unwrap();
            child.wait().unwrap();
            if kill % 3 == 2 {
                script.run.fetch_add(1, Ordering::SeqCst);
            }
        }
        script.quiet.store(true, Ordering::SeqCst);
        let mut last = archive(&here, &endpoint);
        let mut before = Value::Null;
        // Complete when nothing was added for two seconds.
        let mut still = 0;
        for _ in 0..MOST {
            thread::park_timeout(STEP);
            let now: Value = fs::read(here.join("archive.json"))
                .map_or(Value::Null, |bytes| serde_json::from_slice(&bytes).unwrap());
            still = if now["received"] == before["received"] { still + 1 } else { 0 };
            before = now;
            if still > 700 && is_complete(&here) {
                break;
            }
        }
        script.end.store(true, Ordering::SeqCst);
        let counts = played.map(|played| played.join().unwrap());
        kill_process(Pid::from_child(&last), Signal::TERM).unwrap();
        assert_eq!(last.wait().unwrap().code(), Some(0));
        let found = archived(&here);
        for (uid, counts) in UIDS.iter().zip(counts) {
            let ids = |(run, count): (usize, &u64)| {
                (1..=*count).map(move |seq| format!("{run:08x}.{seq}")).collect::<Vec<_>>()
            };
            let wanted: Vec<String> = counts.iter().enumerate().flat_map(ids).collect();
            assert!(wanted.len() > 100, "{counts:?}");
            assert_eq!(found[&format!("{uid:02x}").repeat(16)], wanted);
        }
        router.kill().unwrap();
        router.wait().unwrap();
    });
}
