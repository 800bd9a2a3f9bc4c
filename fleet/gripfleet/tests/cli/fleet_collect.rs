//! `gripfleet recordings` and `collect` beside a router that ends in between, and a gripper that the test plays.

use crate::{
    fleet::router,
    rig::{Played, endpoint, member, patient},
    run::{content, run as gripfleet},
};
use core::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use grip_fleet::{
    EventLog, Part,
    net::Question,
    recordings::{Recording, Shelf},
};
use grip_session::config::RecordTemplate;
use serde_json::Value;
use std::{
    fs::{self, File},
    path::Path,
    sync::Arc,
    thread,
};

const UID: &str = "cdcdcdcdcdcdcdcdcdcdcdcdcdcdcdcd";
/// Questions for bytes after which the router ends, in the middle of a file of five of them.
const BEFORE_THE_CUT: u32 = 3;

/// Questions for bytes that the gripper was asked so far, and whether it answers more than those before the cut.
#[derive(Default)]
struct Cut {
    asked: AtomicU32,
    over: AtomicBool,
}

impl Cut {
    fn waits(&self) -> bool {
        self.asked.load(Ordering::SeqCst) > BEFORE_THE_CUT && !self.over.load(Ordering::SeqCst)
    }
}

/// Reports its recordings, and one that no gripper has.
fn answer(shelf: &Shelf, question: &Question) {
    if question.parameter("name").is_none() {
        let mut all = shelf.list().unwrap();
        let (name, bytes, modified_ns) = ("../../../etc/passwd".to_owned(), 5, u64::MAX);
        all.push(Recording { name, bytes, begin_ns: None, modified_ns, growing: false });
        return question.reply(&serde_json::to_vec(&all).unwrap()).unwrap();
    }
    // Of a router that has gone nothing is reported, and the answer is lost.
    match shelf.read(&|name| question.parameter(name)) {
        Ok(mut reading) => {
            while let Some(piece) = reading.next_piece().unwrap() {
                drop(question.reply(&piece));
            }
        }
        Err(error) => drop(question.refuse(&error.to_string())),
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

#[test]
fn a_router_that_ends_costs_no_byte_and_bad_names_lead_nowhere() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let (bytes, _growing) = recordings(here);
    let endpoint = endpoint();
    let first = router(&endpoint);
    let session = patient(here, &endpoint).open().unwrap();
    let template = here.join("there/run.mcap").display().to_string();
    let shelf = Shelf::new(&RecordTemplate::new(&template).unwrap()).unwrap();
    let (cut, log) = (Arc::<Cut>::default(), EventLog::new(1, 1 << 20));
    let (known, mut held) = (Arc::clone(&cut), None);
    let _played = Played::new(session, &member(0xCD), &[Part::Recordings], move |announced| {
        announced.answer(&|use_it| use_it(&log), &[[0; 0]; 0], "");
        if held.is_none() {
            held = announced.question();
            let is_for_bytes = held.as_ref().is_some_and(|it| it.parameter("name").is_some());
            known.asked.fetch_add(u32::from(is_for_bytes), Ordering::SeqCst);
        }
        if let Some(question) = held.take_if(|_| !known.waits()) {
            answer(&shelf, &question);
        }
    });
    let place = ["--router", &endpoint, "--network", "zenoh.json5"];
    let run = |args: &[&str]| gripfleet(here, &[args, &place].concat());
    let listed = run(&["recordings"]);
    assert!(
        listed.out.contains("run-0001.mcap  5 bytes") && listed.out.contains("being written"),
        "{listed:?}"
    );
    let (ran, _second) = thread::scope(|scope| {
        let copying = scope.spawn(|| run(&["collect", "got", "--patience", "60", "--json"]));
        while !cut.waits() && !copying.is_finished() {
            thread::yield_now();
        }
        first.kill();
        let second = router(&endpoint);
        cut.over.store(true, Ordering::SeqCst);
        (copying.join().unwrap(), second)
    });
    // The bad name is what makes it a loss.
    assert_eq!(ran.code, 3, "{ran:?}");
    let lines = ran.json();
    let done: Vec<&Value> = lines.iter().map(|line| &line["done"]).collect();
    let states = ["failed", "growing", "copied"].map(Value::from);
    assert_eq!(done, [&states[0], &states[1], &states[2], &Value::Null], "{ran:?}");
    let reason = lines[0]["reason"].as_str().unwrap();
    assert!(reason.contains("is no name of a recording"), "{reason}");
    let target = here.join(format!("got/hall/{UID}/run.mcap"));
    let got = content(&here.join("got"));
    assert!(got == [(target.display().to_string(), bytes)].into(), "{:?}", got.keys());

    let again = run(&["collect", "got", "--uid", UID]);
    assert!(again.out.contains("run.mcap  is here already"), "{again:?}");
    fs::write(&target, "my own").unwrap();
    let other = run(&["collect", "got"]);
    assert!(other.err.contains("another file than that of the gripper"), "{other:?}");
    assert_eq!(fs::read(&target).unwrap(), b"my own");
    let old = run(&["collect", "new", "--since", "0.000001"]);
    assert!(old.out.contains(" 0 recordings copied"), "{old:?}");
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
