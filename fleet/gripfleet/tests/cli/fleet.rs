//! The commands of gripfleet beside a router, and grippers that the test plays.

use crate::{
    PROGRAM,
    rig::{Played, at, endpoint, member, notice},
    run::{Ran, run as gripfleet},
};
use grip_fleet::{
    About, EventLog, Part,
    deploy::{Models, Order, digest, examine},
    net::Question,
    rollout::{Compared, Finished, Grasp, Rehearsal},
    wire,
};
use grip_link::message::{
    FaultCode, Kind,
    daemon::{Command, Gripper, Operation},
};
use grip_session::{model::default_text, signature::ModelKeys};
use serde_json::Value;
use std::{net::TcpListener, path::Path};
use stories::Program;
use tempfile::TempDir;

/// gripfleet in `folder`, while it runs.
pub(crate) fn running(folder: &Path, args: &[&str]) -> Program {
    Program::start(Path::new(PROGRAM), folder, args)
}

/// `gripfleet router`, as soon as it listens.
pub(crate) fn router(endpoint: &str) -> Program {
    let router = running(Path::new("."), &["router", "--listen", endpoint]);
    router.until_printed(&format!("a router listens at {endpoint}\n"));
    router
}

/// A gripper with three events.
pub(crate) fn gripper(endpoint: &str) -> Played {
    let mut log = EventLog::new(1, 1 << 20);
    for text in ["one", "two", "three"] {
        log.append(notice(text));
    }
    let member = member(0xAB);
    let gripper = Gripper { uid: member.uid.0, rate_hz: 1000, ..Gripper::NONE };
    let gripper = wire(Kind::GRIPPER, |out| gripper.write(out).unwrap());
    let session = at(endpoint).open().unwrap();
    Played::new(session, &member, &[Part::About, Part::Command], move |announced| {
        announced.publish(Part::State, log.head(), &gripper);
        announced.answer(&|use_it| use_it(&log), &[&gripper], "");
        while let Some(question) = announced.question() {
            answer(&question);
        }
    })
}

/// It takes commands, but lets go only with its token and holds with 2.5 N only.
fn answer(question: &Question) {
    if question.part() == Part::About {
        let firmware = Some("1.2.3".to_owned());
        let about = About { program: "gripd 1".to_owned(), firmware, model: None };
        return question.reply(&serde_json::to_vec(&about).unwrap()).unwrap();
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

/// What `args` print while the gripper is there, and they succeed.
fn beside(args: &[&str]) -> Vec<String> {
    let ran = ran_beside(args).done();
    ran.out.lines().map(str::to_owned).collect()
}

/// What becomes of `args` while the gripper is there.
fn ran_beside(args: &[&str]) -> Ran {
    let (folder, endpoint) = (tempfile::tempdir().unwrap(), endpoint());
    let _router = router(&endpoint);
    let _gripper = gripper(&endpoint);
    gripfleet(folder.path(), &[args, &["--router", &endpoint]].concat())
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
    let wait = format!("{MEMBER}: too many commands wait");
    ran_beside(&["command", MEMBER, "grasp"]).refused(1, &[&wait]);
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
    ran_beside(&["tail", uid]).refused(1, &["no such gripper is there"]);
    let values = ran_beside(&["events", "--all", "--seconds", "5", "--json"]).done().json();
    let ids: Vec<&str> = values.iter().filter_map(|value| value["id"].as_str()).collect();
    assert_eq!(ids, ["00000001.1", "00000001.2", "00000001.3"]);
    // The file of the place names what was reported: nothing comes again.
    let folder = tempfile::tempdir().unwrap();
    let state = folder.path().join("place.json");
    let args = ["events", "--all", "--seconds", "5", "--state", state.to_str().unwrap()];
    let shown = |lines: &[String]| lines.iter().filter(|line| line.contains("link: ")).count();
    assert_eq!([beside(&args), beside(&args)].map(|lines| shown(&lines)), [3, 0]);
    std::fs::write(&state, "rubbish").unwrap();
    ran_beside(&args).refused(2, &["no file of --state"]);
}

#[test]
fn what_cannot_be_is_reported_in_a_sentence() {
    let refuse = |code: i32, args: &[&str], words: &[&str]| {
        gripfleet(Path::new("."), args).refused(code, words);
    };
    refuse(2, &["list"], &["no router: say where one listens"]);
    refuse(2, &["list", "--router", "here"], &["router = here: ", "expected an endpoint"]);
    refuse(2, &["list", "--network", "none.json5"], &["none.json5: no Zenoh configuration"]);
    refuse(2, &["router", "--listen", "there"], &["router = there: "]);
    let nobody = "tcp/127.0.0.1:1";
    for (args, words) in [
        (&["command", "x", "grasp"][..], "expected a gripper as SITE/UID"),
        (&["command", MEMBER, "at-least", "-1"], "-1 is no force; expected newtons"),
        (&["command", MEMBER, "clear-fault", "xyz"], "expected up to four hexadecimal"),
        (&["list", "--site", "a/b"], "`a/b` is no name of a site"),
        (&["tail", "12"], "`12` is no identity"),
        (&["events", "--seconds", "0"], "--seconds 0: expected a number of more than 0"),
    ] {
        refuse(2, &[args, &["--router", nobody]].concat(), &[words]);
    }
    let nobody = endpoint();
    refuse(1, &["list", "--router", &nobody], &[&format!("no router answers at {nobody}: ")]);
    let taken = TcpListener::bind("127.0.0.1:0").unwrap();
    let place = format!("tcp/{}", taken.local_addr().unwrap());
    let reported = format!("a router cannot listen at {place}: ");
    refuse(2, &["router", "--listen", &place], &[&reported]);
}

/// A gripper that grasps something twenty times a second; with another model than its own it loses each n-th object, none for 0.
fn try_models(endpoint: &str, folder: &Path, keys: ModelKeys, lost: u64, uid: u8) -> Played {
    let text = default_text();
    let own = examine("own", &digest(text.as_bytes()), text.as_bytes()).unwrap();
    let mut models = Models::open(folder, own.id).unwrap().with_keys(keys);
    let mut number = 0;
    let mut grasp = move |models: &mut Models| {
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
    let session = at(endpoint).open().unwrap();
    let (mut now_us, log) = (0, EventLog::new(1, 1 << 16));
    Played::new(session, &member(uid), &[Part::Model], move |announced| {
        now_us += 2_000;
        if now_us % 50_000 == 0 {
            grasp(&mut models);
        }
        models.tick(now_us, FaultCode::NONE, &mut |_| Ok(0));
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
    })
}

/// A folder with a model `new.json`, and some grippers for the operator.
struct Hall {
    _grippers: Vec<Played>,
    _router: Program,
    folder: TempDir,
    endpoint: String,
}

impl Hall {
    /// One gripper, which loses each n-th object with another model than its own.
    fn new(lost: u64, text: &str) -> Self {
        Self::of(1, lost, &ModelKeys::default(), text)
    }

    fn of(grippers: u8, lost: u64, keys: &ModelKeys, text: &str) -> Self {
        let (folder, endpoint) = (tempfile::tempdir().unwrap(), endpoint());
        let router = router(&endpoint);
        let gripper = |number: u8| {
            let models = folder.path().join(format!("models-{number}"));
            try_models(&endpoint, &models, keys.clone(), lost, 0xAB + number)
        };
        let grippers = (0..grippers).map(gripper).collect();
        let hall = Self { _grippers: grippers, _router: router, folder, endpoint };
        hall.write("new.json", text);
        hall
    }

    fn write(&self, name: &str, text: &str) {
        std::fs::write(self.folder.path().join(name), text).unwrap();
    }

    /// For all of the hall, where `words` name nobody else.
    fn args<'a>(&'a self, words: &[&'a str]) -> Vec<&'a str> {
        let to = if words.contains(&"--to") { &[][..] } else { &["--to", "hall"] };
        [words, to, &["--router", &self.endpoint]].concat()
    }

    fn run(&self, words: &[&str]) -> Ran {
        gripfleet(self.folder.path(), &self.args(words))
    }

    /// Runs gripfleet until it prints these words, and kills it.
    fn killed(&self, words: &[&str], printed: &str) {
        let running = running(self.folder.path(), &self.args(words));
        running.until_printed(printed);
        running.kill();
    }
}

/// What `gripfleet deploy` prints where a gripper loses each n-th object with the new model.
fn deployed(lost: u64, text: &str, args: &[&str]) -> Ran {
    Hall::new(lost, text).run(&[&["deploy", "new.json"], args].concat())
}

/// As good as the model of the gripper, and another one.
fn other() -> String {
    format!("{} ", default_text())
}

/// What a gripper said, line by line.
fn said(ran: &Ran) -> Vec<String> {
    let lines = ran.json();
    lines.iter().filter_map(|line| line["says"].as_str().map(str::to_owned)).collect()
}

#[test]
fn an_unsigned_model_is_refused_with_the_command_to_type_and_a_signed_one_is_taken() {
    let signature = include_str!("../../../../crates/grip-session/tests/signed/model.json.minisig");
    let model = include_str!("../../../../crates/grip-session/tests/signed/model.json");
    let key = "RWQX4ME9UTGBr9z/nnfFMLox/Beua3vRoZ+aO7nc6TUMmM0TFCAfbnmZ".to_owned();
    let hall = Hall::of(1, 0, &ModelKeys::new(&[key], false).unwrap(), &other());
    let deploy = ["deploy", "new.json", "--grasps", "20", "--shadow", "5"];
    let ran = hall.run(&deploy);
    let next = "refuses it: new.json: it is not signed, and model_keys takes signed models only; sign it: `minisign -Sm new.json`\n";
    assert!(ran.code == 1 && ran.out.contains(next), "{ran:?}");
    assert!(ran.out.contains(" went to nobody: "), "{ran:?}");
    let cut = "its signature cannot be read, or is cut off; sign it: `minisign -Sm new.json`";
    let long =
        "new.json.minisig: the signature of the model cannot be read: it has 4097 bytes".to_owned();
    for (text, words) in [(String::new(), cut), ("x".repeat(4097), &long)] {
        hall.write("new.json.minisig", &text);
        hall.run(&deploy).refused(2, &[words]);
    }
    hall.write("new.json.minisig", signature);
    hall.write("new.json", model);
    let ran = hall.run(&deploy).done();
    assert!(ran.out.contains(&format!("{MEMBER}  keeps it\n")), "{ran:?}");
    let history = hall.run(&["history"]).done().out;
    let signer = ", signed with key AF8131513DC1E017: trained in hall-2, card sha256:0f1e\n";
    assert!(history.contains(signer), "{history}");
}

#[test]
fn a_model_is_given_to_a_gripper_that_keeps_it() {
    let hall = Hall::new(0, &other());
    let ran = hall.run(&["deploy", "new.json", "--notice-lost", "0.3"]).done();
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
    let digest = &digest(other().as_bytes())[..12];
    assert!(ran.out.ends_with(&format!("1 gripper has new.json ({digest})\n")), "{ran:?}");
    // It has it; and that of its configuration, which it knows, comes without a trial, once.
    let again = ["deploy", "new.json", "--grasps", "20", "--json"];
    assert_eq!(said(&hall.run(&again).done()), ["had"]);
    hall.write("own.json", default_text());
    let in_force = || hall.run(&["back", "--json"]).done().json()[0]["in_force"]["name"].clone();
    let known = hall.run(&["deploy", "own.json", "--json"]).done();
    assert_eq!(
        (said(&known), known.json().pop().unwrap()["done"].clone()),
        (vec!["had".to_owned()], true.into())
    );
    assert!(!known.out.contains("\"plan\"") && !known.out.contains("\"stage\""), "{known:?}");
    assert_eq!(in_force(), "own");
    let history = hall.run(&["history"]).done().out;
    assert!(history.contains(" grasps, given back: it was asked to"), "{history}");
    // The plan alone gives it to nobody.
    let ran = deployed(1, &other(), &["--plan", "--json", "--notice-lost", "0.3"]).done();
    assert!(ran.json().pop().unwrap()["type"] == "plan" && !ran.out.contains("taken"), "{ran:?}");
}

/// The third one never has a model that shows itself at the first.
#[test]
fn three_grippers_get_a_model_one_after_the_other() {
    for (lost, code, wanted, taken) in [(0, 0, &[1, 2, 3][..], 3), (1, 1, &[1], 1)] {
        let hall = Hall::of(3, lost, &ModelKeys::default(), &other());
        let flags = ["--grasps", "20", "--shadow", "0", "--json", "--to", "all"];
        let ran = hall.run(&[&["deploy", "new.json"][..], &flags].concat());
        assert_eq!(ran.code, code, "{ran:?}");
        let stages: Vec<u64> =
            ran.json().iter().filter_map(|line| line["stage"].as_u64()).collect();
        assert_eq!(stages, wanted, "{ran:?}");
        let says = |what: &str| said(&ran).iter().filter(|said| *said == what).count();
        assert_eq!((says("fit"), says("taken")), (3, taken), "{ran:?}");
        assert_eq!((says("kept"), says("back")), if code == 0 { (3, 0) } else { (0, 1) });
    }
}

#[test]
fn a_model_that_is_worse_is_taken_back_and_a_broken_one_is_not_even_sent() {
    let what = " grasps with the new model: objects are lost, or slip more often or further\n";
    let broken = ["refuses it: new.json: this is no model file", "went to nobody: "];
    for (lost, text, args, words) in [
        (
            2,
            &*other(),
            &["--grasps", "150"][..],
            &[" was stopped and rolled back: after ", what][..],
        ),
        (0, &other(), &["--notice-lost", "0.001"], &["went to nobody: 500 grasps do not show"]),
        (0, &other(), &["--grasps", "500"], &[" grasps, and 500 are needed to compare"]),
        (1, "{}", &["--force"], &broken),
    ] {
        let ran = deployed(lost, text, args);
        assert!(ran.code == 1 && words.iter().all(|words| ran.out.contains(words)), "{ran:?}");
    }
    deployed(1, "{}", &[]).refused(2, &["nothing was sent (--force sends it"]);
    let ran = deployed(1, "{}", &["--force", "--json"]);
    let end = ran.json().pop().unwrap();
    assert!(ran.code == 1 && end["reason"].as_str().unwrap().contains("no model file"), "{ran:?}");
}

#[test]
fn the_way_back_is_one_command() {
    let hall = Hall::new(1, "{}");
    let ran = hall.run(&["back"]).done();
    assert!(ran.out.starts_with(&format!("{MEMBER}  model own (")), "{ran:?}");
    let line = hall.run(&["back", "--json"]).done().json().remove(0);
    assert_eq!((&line["in_force"]["name"], &line["reason"]), (&"own".into(), &Value::Null));
}

#[test]
fn a_gripper_goes_back_after_its_lease_where_the_operator_is_killed_in_a_stage() {
    let hall = Hall::new(0, &other());
    let history = || hall.run(&["history"]).done().out;
    let deploy = ["deploy", "new.json", "--grasps", "150", "--shadow", "0", "--lease", "5"];
    hall.killed(&deploy, "tries it; it has made ");
    assert!(history().contains(" grasps, goes on"));
    let gone = || history().contains("given back: nobody watched its trial any more");
    assert!(stories::until(gone), "{}", history());
}

/// The same command within the lease: nobody is asked again what was answered, and what the first one began is its roll-out still.
#[test]
fn a_roll_out_is_taken_up_again_where_its_operator_was_killed() {
    let hall = Hall::new(0, &other());
    hall.killed(
        &["deploy", "new.json", "--grasps", "150", "--by", "alice"],
        "tries it; it has made ",
    );
    let again = ["deploy", "new.json", "--grasps", "20", "--shadow", "5", "--by", "bob", "--json"];
    let says = said(&hall.run(&again).done());
    // Neither on recordings nor beside the model in force.
    let new: Vec<&String> = says.iter().filter(|says| *says != "grasped").collect();
    assert_eq!(new, ["taken", "kept"], "{says:?}");
    let history = hall.run(&["history", "--json"]).done().json();
    assert_eq!((history.len(), &history[0]["by"]), (1, &"alice".into()), "{history:?}");
    assert_eq!(history[0]["how"], "accepted");
}

/// It pauses before it begins, its operator is killed and another one goes on; the history names all of it.
#[test]
fn a_roll_out_pauses_over_a_kill_of_its_operator_and_is_in_the_history() {
    let hall = Hall::new(0, &other());
    let unknown = "no roll-out is known there\n";
    assert_eq!(hall.run(&["history"]).done().out, unknown);
    let ran = hall.run(&["pause", "--by", "bob"]).done();
    assert!(ran.out.ends_with("is in force; roll-outs pause, by order of bob\n"), "{ran:?}");
    let deploy = ["deploy", "new.json", "--grasps", "20", "--shadow", "5", "--by", "alice"];
    hall.killed(&deploy, "lets roll-outs pause, by order of bob");
    assert_eq!(hall.run(&["history"]).done().out, unknown, "nobody has it");
    let ran = hall.run(&["resume"]).done();
    assert!(!ran.out.contains("pause"), "{ran:?}");
    hall.run(&deploy).done();
    hall.run(&["back", "--by", "carol"]).done();
    let history = hall.run(&["history"]).done().out;
    let lines: Vec<&str> = history.lines().collect();
    let digest = &digest(other().as_bytes())[..12];
    assert!(lines[0].ends_with(&format!("  model new.json ({digest}) by alice")), "{history}");
    let kept = format!("  {MEMBER}  stage 1, ");
    assert!(lines[1].starts_with(&kept) && lines[1].ends_with(" grasps, kept"), "{history}");
    assert!(lines[2].ends_with(" grasps, given back: ordered by carol"), "{history}");
    let entries = hall.run(&["history", "--json"]).done().json();
    assert_eq!((entries.len(), &entries[0]["how"]), (2, &"accepted".into()));
    assert!(entries[0]["grasps"].as_u64().unwrap() >= 20, "{entries:?}");
}

#[test]
fn a_roll_out_that_cannot_be_is_reported_before_anything_is_sent() {
    let hall = Hall::new(1, &other());
    for (args, code, words) in [
        (["--patience", "0"], 2, "--patience 0: expected a number of more than 0"),
        (["--grasps", "0"], 2, "--grasps 1 to 500"),
        (["--lease", "1"], 2, "--lease 5 to 86400 s"),
        (["--error", "0.9"], 2, "--error takes 1e-6 to 0.5"),
        (["--notice-lost", "0"], 2, "--notice-lost 0.001 to 1"),
        (["--some", "2"], 2, "--some 2: expected a share from 0 to 1"),
        (["--notice-force", "1.1"], 2, "--notice-force 1.2 to 100"),
        (["--site", "yard"], 1, "hall: no such gripper is there"),
    ] {
        hall.run(&[&["deploy", "new.json"][..], &args].concat()).refused(code, &[words]);
    }
}
