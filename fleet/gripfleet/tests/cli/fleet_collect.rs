//! `gripfleet recordings` and `collect` beside a router that ends in between, and a gripper that the test plays.

use crate::{
    fleet::{endpoint, router},
    run::gripctl as gripfleet,
};
use core::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use grip_fleet::{
    EventLog, Member, Uid,
    net::{Announced, Network, Question},
    recordings::{Recording, Shelf},
};
use grip_session::config::RecordTemplate;
use serde_json::Value;
use std::{
    fs::{self, File},
    path::{Path, PathBuf},
    thread,
};

const UID: &str = "cdcdcdcdcdcdcdcdcdcdcdcdcdcdcdcd";
/// Questions for bytes after which the router ends, in the middle of a file of five of them.
const BEFORE_THE_CUT: u32 = 3;

/// A gripper with recordings, and with one that no gripper has.
struct Played {
    network: Network,
    shelf: Shelf,
    end: AtomicBool,
    there: AtomicBool,
    /// Questions for bytes so far.
    asked: AtomicU32,
    /// It answers no more of them until this is set.
    on: AtomicBool,
}

impl Played {
    fn new(folder: &Path, endpoint: &str) -> Self {
        let file = folder.join("zenoh.json5");
        fs::write(&file, "{ connect: { retry: { period_init_ms: 100, period_max_ms: 100 } } }")
            .unwrap();
        let template = folder.join("there/run.mcap").display().to_string();
        Self {
            network: Network { router: Some(endpoint.to_owned()), file: Some(file) },
            shelf: Shelf::new(&RecordTemplate::new(&template).unwrap()).unwrap(),
            end: AtomicBool::new(false),
            there: AtomicBool::new(false),
            asked: AtomicU32::new(0),
            on: AtomicBool::new(false),
        }
    }

    fn run(&self) {
        let session = self.network.open().unwrap();
        let member = Member { site: "hall".parse().unwrap(), uid: Uid([0xCD; 16]) };
        let mut announced =
            Announced::new(&session, &member, &[grip_fleet::Part::Recordings]).unwrap();
        self.there.store(true, Ordering::SeqCst);
        let log = EventLog::new(1, 1 << 20);
        while !self.end.load(Ordering::SeqCst) {
            announced.answer(&|use_it| use_it(&log), &[[0; 0]; 0], "");
            if let Some(question) = announced.question() {
                self.answer(&question);
            }
            thread::yield_now();
        }
    }

    fn answer(&self, question: &Question) {
        if question.parameter("name").is_none() {
            let mut all = self.shelf.list().unwrap();
            let name = "../../../etc/passwd".to_owned();
            all.push(Recording {
                name,
                bytes: 5,
                begin_ns: None,
                modified_ns: u64::MAX,
                growing: false,
            });
            return question.reply(&serde_json::to_vec(&all).unwrap()).unwrap();
        }
        if self.asked.fetch_add(1, Ordering::SeqCst) >= BEFORE_THE_CUT {
            while !self.on.load(Ordering::SeqCst) && !self.end.load(Ordering::SeqCst) {
                thread::yield_now();
            }
        }
        // Of a router that has gone nothing is reported, and the answer is lost.
        match self.shelf.read(&|name| question.parameter(name)) {
            Ok(mut reading) => {
                while let Some(piece) = reading.next_piece().unwrap() {
                    drop(question.reply(&piece));
                }
            }
            Err(error) => drop(question.refuse(&error.to_string())),
        }
    }
}

/// Five megabytes that are finished, and a file that grows.
fn recordings(folder: &Path) -> (Vec<u8>, File) {
    let folder = folder.join("there");
    fs::create_dir(&folder).unwrap();
    let content: Vec<u8> =
        (0..1_310_720_u32).flat_map(|at| at.wrapping_mul(2_654_435_761).to_le_bytes()).collect();
    fs::write(folder.join("run.mcap"), &content).unwrap();
    let growing = folder.join("run-0001.mcap");
    fs::write(&growing, "begun").unwrap();
    let growing = File::options().append(true).open(growing).unwrap();
    growing.try_lock().unwrap();
    (content, growing)
}

/// Everything in a folder, without the folders.
fn files(folder: &Path) -> Vec<PathBuf> {
    let mut all = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() { all.extend(files(&path)) } else { all.push(path) }
    }
    all
}

#[test]
fn a_router_that_ends_costs_no_byte_and_bad_names_lead_nowhere() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let (content, _growing) = recordings(here);
    let endpoint = endpoint();
    let mut first = router(&endpoint);
    let played = Played::new(here, &endpoint);
    let place = ["--router", &endpoint, "--network", "zenoh.json5"];
    let run = |args: &[&str]| gripfleet(here, &[args, &place].concat());
    thread::scope(|scope| {
        scope.spawn(|| played.run());
        while !played.there.load(Ordering::SeqCst) {
            thread::yield_now();
        }
        let listed = run(&["recordings"]);
        assert!(
            listed.out.contains("run-0001.mcap  5 bytes") && listed.out.contains("being written")
        );

        let copying = scope.spawn(|| run(&["collect", "got", "--patience", "60", "--json"]));
        while played.asked.load(Ordering::SeqCst) <= BEFORE_THE_CUT && !copying.is_finished() {
            thread::yield_now();
        }
        first.kill().unwrap();
        first.wait().unwrap();
        let mut second = router(&endpoint);
        played.on.store(true, Ordering::SeqCst);
        let ran = copying.join().unwrap();
        // The bad name is what makes it a loss.
        assert_eq!(ran.code, 3, "{ran:?}");
        let lines = ran.json();
        let done: Vec<&Value> = lines.iter().map(|line| &line["done"]).collect();
        assert_eq!(
            done,
            ["failed", "growing", "copied", ""]
                .map(|text| if text.is_empty() { Value::Null } else { text.into() })
                .iter()
                .collect::<Vec<_>>(),
            "{ran:?}"
        );
        let reason = lines[0]["reason"].as_str().unwrap();
        assert!(reason.contains("is no name of a recording"), "{reason}");
        let target = here.join(format!("got/hall/{UID}/run.mcap"));
        assert_eq!(files(&here.join("got")), core::slice::from_ref(&target));
        assert!(fs::read(&target).unwrap() == content);

        let again = run(&["collect", "got", "--uid", UID]);
        assert!(again.out.contains("run.mcap  is here already"), "{again:?}");
        fs::write(&target, "my own").unwrap();
        let other = run(&["collect", "got"]);
        assert!(other.err.contains("another file than that of the gripper"), "{other:?}");
        assert_eq!(fs::read(&target).unwrap(), b"my own");
        let old = run(&["collect", "new", "--since", "0.000001"]);
        assert!(old.out.contains(" 0 recordings copied"), "{old:?}");
        played.end.store(true, Ordering::SeqCst);
        second.kill().unwrap();
        second.wait().unwrap();
    });
}

#[test]
fn wrong_arguments_are_reported() {
    let here = Path::new(".");
    let place = ["--router", "tcp/127.0.0.1:1"];
    for (args, words) in [
        (&["collect", "x", "--since", "-1"][..], "--since -1: expected a number of more than 0"),
        (&["collect", "x", "--patience", "nan"], "--patience NaN: expected a number of 0 or more"),
        (&["collect"], "<DIRECTORY>"),
    ] {
        gripfleet(here, &[args, &place].concat()).refused(2, &[words]);
    }
    let nobody = endpoint();
    gripfleet(here, &["recordings", "--router", &nobody]).refused(1, &["no router answers"]);
}
