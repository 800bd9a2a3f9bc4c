//! `gripfleet fleet` beside a router in the test, and one gripper that the test plays.

use crate::run::{Ran, gripctl as gripfleet};
use core::sync::atomic::{AtomicBool, AtomicU8, Ordering};
use grip_fleet::{
    About, EventLog, Member, Part, Spool, Topic, Uid,
    deploy::{Models, Order, digest, examine},
    net::{Announced, Network, Question},
    rollout::{Compared, Finished, Grasp, Rehearsal},
    wire,
};
use grip_link::message::{
    FaultCode, Kind,
    daemon::{Command, Gripper, Notice, NoticeKind, Operation},
};
use grip_session::{model::default_text, signature::ModelKeys};
use serde_json::Value;
use std::{
    io::{BufRead as _, BufReader},
    net::TcpListener,
    path::Path,
    process::{self, Child, Stdio},
    thread,
};

pub(crate) fn endpoint() -> String {
    let port = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
    format!("tcp/127.0.0.1:{port}")
}

/// An event with a text.
pub(crate) fn notice(text: &str) -> Vec<u8> {
    let (kind, text) = (NoticeKind::Link, text.as_bytes());
    let notice = Notice { kind, code: 0, value: 0, count: 0, host_us: 1_000_000, text };
    wire(Kind::NOTICE, |out| notice.write(out).unwrap())
}

/// A gripper with three events that answers until it is asked to end.
pub(crate) fn play(endpoint: &str, end: &AtomicBool, there: &AtomicBool) {
    let session = Network { router: Some(endpoint.to_owned()), file: None }.open().unwrap();
    let member = Member { site: "hall".parse().unwrap(), uid: Uid([0xAB; 16]) };
    let mut spool = Spool::in_memory(1, 1 << 20);
    for text in ["one", "two", "three"] {
        spool.append(notice(text));
    }
    let gripper = Gripper { uid: member.uid.0, rate_hz: 1000, ..Gripper::NONE };
    let gripper = wire(Kind::GRIPPER, |out| gripper.write(out).unwrap());
    let mut announced = Announced::new(&session, &member, &[Part::About, Part::Command]).unwrap();
    there.store(true, Ordering::SeqCst);
    while !end.load(Ordering::SeqCst) {
        announced.publish(Topic::State, spool.log().head(), &gripper);
        let with_log = |use_it: &mut dyn FnMut(&EventLog)| use_it(spool.log());
        announced.answer(&with_log, &[&gripper], "");
        while let Some(question) = announced.question() {
            answer(&question);
        }
        thread::yield_now();
    }
}

/// It takes commands, but lets go only with its token and holds with 2.5 N only.
fn answer(question: &Question) {
    if question.part() == Part::About {
        let about = About {
            program: "gripd 1".to_owned(),
            firmware: Some("1.2.3".to_owned()),
            model: None,
        };
        return question.reply(about.to_json().unwrap().as_bytes()).unwrap();
    }
    if question.payload_len() == 0 {
        return question.reply(b"7").unwrap();
    }
    let command = Command::parse(&question.payload()).unwrap();
    match (command.operation, command.force_mn, command.token) {
        (Operation::AtLeast, 2500, 0) | (Operation::Release, 0, 7) => question.reply(b"taken"),
        _ => question.refuse("too many commands wait"),
    }
    .unwrap();
}

/// `gripfleet router`, as soon as it listens.
pub(crate) fn router(endpoint: &str) -> Child {
    let mut command = process::Command::new(env!("CARGO_BIN_EXE_gripfleet"));
    command.args(["router", "--listen", endpoint]).stdout(Stdio::piped());
    let mut child = command.spawn().unwrap();
    let mut line = String::new();
    BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
    assert_eq!(line, format!("a router listens at {endpoint}\n"));
    child
}

/// What `args` print while the gripper is there, and they succeed.
fn beside(args: &[&str]) -> Vec<String> {
    let ran = ran_beside(args);
    assert_eq!(ran.code, 0, "{ran:?}");
    ran.out.lines().map(str::to_owned).collect()
}

/// What becomes of `args` while the gripper is there.
fn ran_beside(args: &[&str]) -> Ran {
    let folder = tempfile::tempdir().unwrap();
    let endpoint = endpoint();
    let mut router = router(&endpoint);
    let (end, there) = (AtomicBool::new(false), AtomicBool::new(false));
    thread::scope(|scope| {
        scope.spawn(|| play(&endpoint, &end, &there));
        while !there.load(Ordering::SeqCst) {
            thread::yield_now();
        }
        let ran = gripfleet(folder.path(), &[args, &["--router", &endpoint]].concat());
        end.store(true, Ordering::SeqCst);
        router.kill().unwrap();
        router.wait().unwrap();
        ran
    })
}

const MEMBER: &str = "hall/abababababababababababababababab";

#[test]
fn who_is_there_is_listed() {
    let lines = beside(&["list"]);
    assert_eq!(lines, [format!("{MEMBER}  link closed, 1000 Hz; gripd 1, firmware 1.2.3")]);
    let lines = beside(&["list", "--json", "--site", "hall"]);
    let value: Value = serde_json::from_str(&lines[0]).unwrap();
    assert_eq!(value["about"]["firmware"], "1.2.3");
    assert_eq!((&value["site"], &value["gripper"]["rate_hz"]), (&"hall".into(), &1000.into()));
    assert_eq!(beside(&["list", "--site", "yard"]), ["no gripper is there at yard"]);
}

#[test]
fn a_gripper_is_reported_what_to_do_and_its_reasons_are_shown() {
    let reported = |what: &[&str]| beside(&[&["command", MEMBER], what].concat());
    for what in [&["at-least", "2.5"][..], &["release"]] {
        assert_eq!(reported(what), [format!("{MEMBER}  has taken the command")]);
    }
    let ran = ran_beside(&["command", MEMBER, "grasp"]);
    assert_eq!((ran.code, ran.out.as_str()), (1, ""));
    assert!(ran.err.contains(&format!("{MEMBER}: too many commands wait")), "{}", ran.err);
}

#[test]
fn kept_events_are_shown_once_and_in_order() {
    let lines = beside(&["events", "--all", "--seconds", "5"]);
    let events: Vec<&String> = lines.iter().filter(|line| line.contains("link: ")).collect();
    let wanted =
        ["one", "two", "three"].map(|text| format!("{MEMBER}      1.0000 s  link: {text}"));
    assert_eq!(events, wanted.iter().collect::<Vec<_>>(), "{lines:?}");
    assert_eq!(lines[0], format!("{MEMBER}  is there"));
    let uid = "00000000000000000000000000000001";
    let ran = ran_beside(&["events", "--uid", uid, "--seconds", "4"]);
    assert!(ran.out.is_empty() && ran.err.contains("nobody is there who is meant"), "{ran:?}");
    let ran = ran_beside(&["tail", uid]);
    assert!(ran.code == 1 && ran.err.contains("no such gripper is there"), "{ran:?}");
    let lines = beside(&["events", "--all", "--seconds", "5", "--json"]);
    let values: Vec<Value> = lines.iter().map(|line| serde_json::from_str(line).unwrap()).collect();
    let ids: Vec<&str> = values.iter().filter_map(|value| value["id"].as_str()).collect();
    assert_eq!(ids, ["00000001.1", "00000001.2", "00000001.3"]);
    // The file of the place names what was reported: nothing comes again.
    let folder = tempfile::tempdir().unwrap();
    let state = folder.path().join("place.json");
    let file = state.to_str().unwrap();
    let args = ["events", "--all", "--seconds", "5", "--state", file];
    let shown = |lines: &[String]| lines.iter().filter(|line| line.contains("link: ")).count();
    assert_eq!([beside(&args), beside(&args)].map(|lines| shown(&lines)), [3, 0]);
    std::fs::write(&state, "rubbish").unwrap();
    let ran = ran_beside(&args);
    assert!(ran.code == 2 && ran.err.contains("no file of --state"), "{ran:?}");
}

#[test]
fn what_cannot_be_is_reported_in_a_sentence() {
    let refuse = |code: i32, args: &[&str], words: &[&str]| {
        let ran = gripfleet(Path::new("."), &[args].concat());
        assert_eq!(ran.code, code, "{ran:?}");
        for word in words {
            assert!(ran.err.contains(word), "no {word:?} in {}", ran.err);
        }
    };
    refuse(2, &["list"], &["no router: say where one listens"]);
    refuse(2, &["list", "--router", "here"], &["router = here: ", "expected an endpoint"]);
    refuse(2, &["list", "--network", "none.json5"], &["none.json5: no Zenoh configuration"]);
    refuse(2, &["router", "--listen", "there"], &["router = there: "]);
    let nobody = "tcp/127.0.0.1:1";
    refuse(2, &["command", "x", "grasp", "--router", nobody], &["expected a gripper as SITE/UID"]);
    let below = ["command", MEMBER, "at-least", "-1", "--router", nobody];
    refuse(2, &below, &["-1 is no force; expected newtons"]);
    refuse(2, &["command", MEMBER, "clear-fault", "xyz"], &["expected up to four hexadecimal"]);
    refuse(2, &["list", "--site", "a/b"], &["`a/b` is no name of a site"]);
    refuse(2, &["tail", "12", "--router", "tcp/127.0.0.1:1"], &["`12` is no identity"]);
    let seconds = ["events", "--seconds", "0", "--router", "tcp/127.0.0.1:1"];
    refuse(2, &seconds, &["--seconds 0: expected a number of more than 0"]);
    let nobody = endpoint();
    refuse(1, &["list", "--router", &nobody], &[&format!("no router answers at {nobody}: ")]);
    let taken = TcpListener::bind("127.0.0.1:0").unwrap();
    let place = format!("tcp/{}", taken.local_addr().unwrap());
    let reported = format!("a router cannot listen at {place}: ");
    refuse(2, &["router", "--listen", &place], &[&reported]);
}

/// A gripper that grasps something twenty times a second; with another model than its own it loses each n-th object, none for 0.
fn try_models(endpoint: &str, folder: &Path, hall: &Hall, uid: u8, end: &AtomicBool) {
    let session = Network { router: Some(endpoint.to_owned()), file: None }.open().unwrap();
    let member = Member { site: "hall".parse().unwrap(), uid: Uid([uid; 16]) };
    let text = default_text();
    let own = examine("own", &digest(text.as_bytes()), text.as_bytes()).unwrap();
    let mut models = Models::open(folder, own.id).unwrap().with_keys(hall.keys.clone());
    let lost = hall.lost;
    let mut announced = Announced::new(&session, &member, &[Part::Model]).unwrap();
    let mut number = 0;
    let mut grasp = |models: &mut Models| {
        number += 1;
        let is_own = models.standing().in_force.name == "own";
        let lost = !is_own && lost > 0 && number % lost == 0;
        let force_ratio = Some([1.0, 1.2, 1.1][usize::try_from(number % 3).unwrap()]);
        // As a shadow it asks for what the model in force asks for.
        let (in_force_n, shadow_n, held_n) = (Some(6.0), Some(6.0), Some(6.0));
        let beside = models.standing().shadow.is_some();
        let compared = beside.then_some(Compared { in_force_n, shadow_n, slipped_n: 3.0, held_n });
        let grasp = Grasp { lost, regrasps: 1, slip_mm: 0.5, force_ratio, compared };
        models.grasped(&Finished { number, grasp });
    };
    (0..200).for_each(|_| grasp(&mut models));
    hall.there.fetch_add(1, Ordering::SeqCst);
    let mut now_us = 0;
    while !end.load(Ordering::SeqCst) {
        thread::park_timeout(core::time::Duration::from_millis(10));
        now_us += 10_000;
        if now_us % 50_000 == 0 {
            grasp(&mut models);
        }
        models.tick(now_us, FaultCode::NONE, &mut |_| Ok(0));
        let log = EventLog::new(1, 1 << 16);
        announced.answer(&|use_it| use_it(&log), &[[0; 0]; 0], "");
        while let Some(question) = announced.question() {
            let order = Order::read(|name| question.parameter(name), question.payload()).unwrap();
            let obeyed = models.obey(order, now_us, &mut |_| Ok(0));
            if models.rehearsing().is_some() {
                let skipped = vec!["nothing is recorded here".to_owned()];
                models.rehearsed(Rehearsal { skipped, ..Rehearsal::default() });
            }
            match obeyed {
                Ok(standing) => question.reply(&serde_json::to_vec(&standing).unwrap()).unwrap(),
                Err(fault) => question.refuse(&fault.to_string()).unwrap(),
            }
        }
    }
}

/// What `gripfleet deploy` prints where a gripper loses each n-th object with the new model.
fn deployed(lost: u64, text: &str, args: &[&str]) -> Ran {
    reported(lost, text, &[&["deploy", "new.json"], args].concat())
}

/// The same of any command for the grippers of the hall.
fn reported(lost: u64, text: &str, args: &[&str]) -> Ran {
    in_hall(lost, text, |folder, endpoint| {
        gripfleet(folder, &[args, &["--to", "hall", "--router", endpoint]].concat())
    })
}

/// A folder with a model and an endpoint with a router and the gripper for the operator.
fn in_hall<T>(lost: u64, text: &str, operate: impl FnOnce(&Path, &str) -> T) -> T {
    in_hall_of(&Hall::new(1, lost, ModelKeys::default()), text, operate)
}

/// What its grippers are like.
struct Hall {
    grippers: u8,
    /// With another model than its own each loses each n-th object, none for 0.
    lost: u64,
    /// Whose models they take.
    keys: ModelKeys,
    /// So many are there.
    there: AtomicU8,
}

impl Hall {
    const fn new(grippers: u8, lost: u64, keys: ModelKeys) -> Self {
        Self { grippers, lost, keys, there: AtomicU8::new(0) }
    }
}

fn in_hall_of<T>(hall: &Hall, text: &str, operate: impl FnOnce(&Path, &str) -> T) -> T {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("new.json"), text).unwrap();
    let endpoint = endpoint();
    let router = router(&endpoint);
    let end = AtomicBool::new(false);
    thread::scope(|scope| {
        let (end, place) = (&end, endpoint.as_str());
        let _ends = Ends(end, router);
        let begin = |uid: u8| {
            let models = folder.path().join(format!("models-{uid}"));
            scope.spawn(move || try_models(place, &models, hall, uid, end))
        };
        let grippers: Vec<_> = (0..hall.grippers).map(|number| begin(0xAB + number)).collect();
        while hall.there.load(Ordering::SeqCst) < hall.grippers {
            assert!(grippers.iter().all(|gripper| !gripper.is_finished()), "a gripper has failed");
            thread::yield_now();
        }
        operate(folder.path(), &endpoint)
    })
}

/// Ends the gripper and the router, also where the operator has failed: the scope waits for the gripper.
pub(crate) struct Ends<'a>(pub(crate) &'a AtomicBool, pub(crate) Child);

impl Drop for Ends<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::SeqCst);
        // Of one that has ended there is nothing to kill.
        drop(self.1.kill());
        drop(self.1.wait());
    }
}

#[test]
fn an_unsigned_model_is_refused_with_the_command_to_type_and_a_signed_one_is_taken() {
    let signature = include_str!("../../../../crates/grip-session/tests/signed/model.json.minisig");
    let model = include_str!("../../../../crates/grip-session/tests/signed/model.json");
    let key = "RWQX4ME9UTGBr9z/nnfFMLox/Beua3vRoZ+aO7nc6TUMmM0TFCAfbnmZ".to_owned();
    let hall = Hall::new(1, 0, ModelKeys::new(&[key], false).unwrap());
    in_hall_of(&hall, &format!("{} ", default_text()), |folder, endpoint| {
        let run = |words: &[&str]| {
            let fixed = ["--to", "hall", "--router", endpoint];
            gripfleet(folder, &[words, &fixed].concat())
        };
        let deploy = ["deploy", "new.json", "--grasps", "20", "--shadow", "5"];
        let ran = run(&deploy);
        let next = "refuses it: new.json: it is not signed, and model_keys takes signed models only; sign it: `minisign -Sm new.json`\n";
        assert!(ran.code == 1 && ran.out.contains(next), "{ran:?}");
        assert!(ran.out.contains(" went to nobody: "), "{ran:?}");
        let beside = folder.join("new.json.minisig");
        for (text, words) in [
            (
                String::new(),
                "its signature cannot be read, or is cut off; sign it: `minisign -Sm new.json`",
            ),
            (
                "x".repeat(4097),
                "new.json.minisig: the signature of the model cannot be read: it has 4097 bytes",
            ),
        ] {
            std::fs::write(&beside, text).unwrap();
            let ran = run(&deploy);
            assert!(ran.code == 2 && ran.err.contains(words) && ran.out.is_empty(), "{ran:?}");
        }
        std::fs::write(&beside, signature).unwrap();
        std::fs::write(folder.join("new.json"), model).unwrap();
        let ran = run(&deploy).done();
        assert!(ran.out.contains(&format!("{MEMBER}  keeps it\n")), "{ran:?}");
        let history = run(&["history"]).done().out;
        let signer = ", signed with key AF8131513DC1E017: trained in hall-2, card sha256:0f1e\n";
        assert!(history.contains(signer), "{history}");
    });
}

#[test]
fn a_model_is_given_to_a_gripper_that_keeps_it() {
    let other = format!("{} ", default_text());
    let ran = deployed(0, &other, &["--notice-lost", "0.3"]);
    assert_eq!(ran.code, 0, "{ran:?}");
    let lines: Vec<&str> = ran.out.lines().collect();
    let plan = "everybody was asked and would take it; beside the models in force it is asked in ";
    let at = |words: &str| lines.iter().position(|line| line.starts_with(words));
    assert!(at(plan).is_some_and(|line| lines[line].contains("; a stage takes ")), "{ran:?}");
    let replayed = format!("{MEMBER}  could not try it on recordings; nothing is recorded here");
    let beside = format!("{MEMBER}  lets it estimate beside the model in force; it moves nothing");
    let tries = format!("{MEMBER}  tries it; it has made ");
    let order = [at(&replayed), at(&beside), at("stage 1 begins"), at(&tries)];
    assert!(order.is_sorted() && order[0].is_some(), "{order:?} {ran:?}");
    assert!(ran.out.contains(&format!("{MEMBER}  keeps it\n")), "{ran:?}");
    assert!(
        ran.out
            .ends_with(&format!("1 gripper has new.json ({})\n", &digest(other.as_bytes())[..12]))
    );
    let ran = deployed(0, default_text(), &["--grasps", "20", "--json"]);
    let lines: Vec<Value> =
        ran.out.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let states: Vec<&str> = lines.iter().filter_map(|line| line["says"].as_str()).collect();
    assert_eq!((states, &lines[lines.len() - 1]["done"]), (vec!["had"], &true.into()));
    // The plan alone gives it to nobody.
    let ran = deployed(1, &other, &["--plan", "--json", "--notice-lost", "0.3"]);
    let plan: Value = serde_json::from_str(ran.out.lines().last().unwrap()).unwrap();
    assert!(ran.code == 0 && plan["type"] == "plan" && !ran.out.contains("taken"), "{ran:?}");
}

/// The third one never has a model that shows itself at the first.
#[test]
fn three_grippers_get_a_model_one_after_the_other() {
    let other = format!("{} ", default_text());
    for (lost, code, wanted, taken) in [(0, 0, &[1, 2, 3][..], 3), (1, 1, &[1], 1)] {
        let hall = Hall::new(3, lost, ModelKeys::default());
        let ran = in_hall_of(&hall, &other, |folder, endpoint| {
            let flags = ["--grasps", "20", "--shadow", "0", "--json", "--to", "all"];
            gripfleet(folder, &[&["deploy", "new.json", "--router", endpoint][..], &flags].concat())
        });
        assert_eq!(ran.code, code, "{ran:?}");
        let lines: Vec<Value> =
            ran.out.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
        let stages: Vec<u64> = lines.iter().filter_map(|line| line["stage"].as_u64()).collect();
        assert_eq!(stages, wanted, "{ran:?}");
        let says = |what: &str| lines.iter().filter(|line| line["says"] == what).count();
        assert_eq!((says("fit"), says("taken")), (3, taken), "{ran:?}");
        assert_eq!((says("kept"), says("back")), if code == 0 { (3, 0) } else { (0, 1) });
    }
}

#[test]
fn a_model_that_is_worse_is_taken_back_and_a_broken_one_is_not_even_sent() {
    let other = format!("{} ", default_text());
    let ran = deployed(2, &other, &["--grasps", "150"]);
    assert_eq!(ran.code, 1, "{ran:?}");
    let why = " was stopped and rolled back: after ";
    let what = " grasps with the new model: objects are lost, or slip more often or further\n";
    assert!(ran.out.contains(why) && ran.out.ends_with(what), "{ran:?}");
    let ran = deployed(0, &other, &["--notice-lost", "0.001"]);
    assert!(ran.code == 1 && ran.out.contains("went to nobody: 500 grasps do not show"), "{ran:?}");
    let ran = deployed(0, &other, &["--grasps", "500"]);
    assert!(ran.code == 1 && ran.out.contains(" grasps, and 500 are needed to compare"), "{ran:?}");
    let ran = deployed(1, "{}", &[]);
    assert!(ran.code == 2 && ran.err.contains("nothing was sent (--force sends it"), "{ran:?}");
    let ran = deployed(1, "{}", &["--force", "--json"]);
    let end: Value = serde_json::from_str(ran.out.lines().last().unwrap()).unwrap();
    assert!(ran.code == 1 && end["reason"].as_str().unwrap().contains("no model file"), "{ran:?}");
    let ran = deployed(1, "{}", &["--force"]);
    let reported = ["refuses it: new.json: this is no model file", "went to nobody: "];
    assert!(ran.code == 1 && reported.iter().all(|words| ran.out.contains(words)), "{ran:?}");
}

#[test]
fn the_way_back_is_one_command() {
    let ran = reported(1, "{}", &["back"]);
    assert!(ran.code == 0 && ran.out.starts_with(&format!("{MEMBER}  model own (")), "{ran:?}");
    let ran = reported(1, "{}", &["back", "--json"]);
    let line: Value = serde_json::from_str(&ran.out).unwrap();
    assert_eq!((&line["in_force"]["name"], &line["reason"]), (&"own".into(), &Value::Null));
}

/// Runs gripfleet until it prints a line with these words, and kills it.
fn killed(folder: &Path, args: &[String], words: &str) {
    let mut running = process::Command::new(env!("CARGO_BIN_EXE_gripfleet"))
        .current_dir(folder)
        .args(args)
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let lines = BufReader::new(running.stdout.take().unwrap()).lines();
    let found = lines.map(Result::unwrap).any(|line| line.contains(words));
    running.kill().unwrap();
    running.wait().unwrap();
    assert!(found, "no line with {words}");
}

#[test]
fn a_gripper_goes_back_after_its_lease_where_the_operator_is_killed_in_a_stage() {
    let other = format!("{} ", default_text());
    in_hall(0, &other, |folder, endpoint| {
        let fixed = ["--to", "hall", "--router", endpoint];
        let run = |words: &[&str]| gripfleet(folder, &[words, &fixed].concat()).done().out;
        let args = ["deploy", "new.json", "--grasps", "150", "--shadow", "0", "--lease", "5"];
        let args = [&args[..], &fixed].concat();
        let args: Vec<String> = args.into_iter().map(str::to_owned).collect();
        killed(folder, &args, "tries it; it has made ");
        assert!(run(&["history"]).contains(" grasps, goes on"));
        let mut history = String::new();
        for _ in 0..300 {
            history = run(&["history"]);
            if history.contains("given back: nobody watched its trial any more") {
                return;
            }
            thread::park_timeout(core::time::Duration::from_millis(100));
        }
        panic!("{history}");
    });
}

/// It pauses before it begins, its operator is killed and another one goes on; the history names all of it.
#[test]
fn a_roll_out_pauses_over_a_kill_of_its_operator_and_is_in_the_history() {
    let other = format!("{} ", default_text());
    in_hall(0, &other, |folder, endpoint| {
        let args = |words: &[&str]| -> Vec<String> {
            let fixed = ["--to", "hall", "--router", endpoint];
            [words, &fixed].concat().into_iter().map(str::to_owned).collect()
        };
        let run = |words: &[&str]| {
            let args = args(words);
            gripfleet(folder, &args.iter().map(String::as_str).collect::<Vec<_>>())
        };
        assert_eq!(run(&["history"]).done().out, "no roll-out is known there\n");
        let ran = run(&["pause", "--by", "bob"]).done();
        assert!(ran.out.ends_with("is in force; roll-outs pause, by order of bob\n"), "{ran:?}");
        let deploy = ["deploy", "new.json", "--grasps", "20", "--shadow", "5", "--by", "alice"];
        killed(folder, &args(&deploy), "lets roll-outs pause, by order of bob");
        assert_eq!(run(&["history"]).done().out, "no roll-out is known there\n", "nobody has it");
        let ran = run(&["resume"]).done();
        assert!(!ran.out.contains("pause"), "{ran:?}");
        run(&deploy).done();
        run(&["back", "--by", "carol"]).done();
        let history = run(&["history"]).done().out;
        let lines: Vec<&str> = history.lines().collect();
        let digest = &digest(other.as_bytes())[..12];
        assert!(lines[0].ends_with(&format!("  model new.json ({digest}) by alice")), "{history}");
        let kept = format!("  {MEMBER}  stage 1, ");
        assert!(lines[1].starts_with(&kept) && lines[1].ends_with(" grasps, kept"), "{history}");
        assert!(lines[2].ends_with(" grasps, given back: ordered by carol"), "{history}");
        let entries = run(&["history", "--json"]).done().json();
        assert_eq!((entries.len(), &entries[0]["how"]), (2, &"accepted".into()));
        assert!(entries[0]["grasps"].as_u64().unwrap() >= 20, "{entries:?}");
    });
}

#[test]
fn a_roll_out_that_cannot_be_is_reported_before_anything_is_sent() {
    let other = format!("{} ", default_text());
    for (args, code, words) in [
        (&["--patience", "0"][..], 2, "--patience 0: expected a number of more than 0"),
        (&["--grasps", "0"], 2, "--grasps 1 to 500"),
        (&["--lease", "1"], 2, "--lease 5 to 86400 s"),
        (&["--error", "0.9"], 2, "--error takes 1e-6 to 0.5"),
        (&["--notice-lost", "0"], 2, "--notice-lost 0.001 to 1"),
        (&["--some", "2"], 2, "--some 2: expected a share from 0 to 1"),
        (&["--notice-force", "1.1"], 2, "--notice-force 1.2 to 100"),
        (&["--site", "yard"], 1, "hall: no such gripper is there"),
    ] {
        let ran = deployed(1, &other, args);
        assert!(ran.code == code && ran.err.contains(words) && ran.out.is_empty(), "{ran:?}");
    }
}
