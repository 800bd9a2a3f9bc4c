//! Models of one gripper in a folder: tried, kept, given back, left alone, interrupted; beside the one in force, on recordings, signed; and
//! what is refused.

use super::{
    Entry, History, How, ModelId, Models, Notice, Offer, Order, Origin, Put, Rehearsal, Standing,
    digest, examine, history::reason,
};
use crate::rollout::{Compared, Finished, Grasp};
use grip_link::message::FaultCode;
use grip_session::{
    model::{built_in, default_text},
    signature::ModelKeys,
};
use std::{fs, path::Path};
use tempfile::TempDir;

const KEY: &str = "RWQX4ME9UTGBr9z/nnfFMLox/Beua3vRoZ+aO7nc6TUMmM0TFCAfbnmZ";
const MODEL: &str = include_str!("../../../../crates/grip-session/tests/signed/model.json");
const SIGNATURE: &str =
    include_str!("../../../../crates/grip-session/tests/signed/model.json.minisig");
const BY_OTHER: &str =
    include_str!("../../../../crates/grip-session/tests/signed/other-key.minisig");

/// The same model with another SHA-256 for each name; `file` is that of the configuration.
fn text(name: &str) -> String {
    let spaces = if name == "file" { 0 } else { usize::from(name.as_bytes()[0]) };
    default_text().to_owned() + &" ".repeat(spaces)
}

fn sha256(name: &str) -> String {
    digest(text(name).as_bytes())
}

fn id(name: &str) -> ModelId {
    ModelId { name: name.to_owned(), sha256: sha256(name) }
}

fn offer(name: &str) -> Offer {
    Offer { origin: Origin::new("alice", 17, 1), ..of(name, &text(name)) }
}

fn of(name: &str, text: &str) -> Offer {
    Offer::new(name.to_owned(), text.into(), 60)
}

fn back() -> Order {
    Order::Back { sha256: None, why: None }
}

/// A gripper and its gripfleet.
struct Gripper {
    folder: TempDir,
    models: Option<Models>,
    keys: ModelKeys,
    now_us: u64,
    fault: FaultCode,
    /// Grasps that have begun. The one that goes on when a model changes belongs to neither.
    number: u64,
    /// What was put where.
    put: Vec<String>,
    /// Nothing can be put anywhere.
    refuses: bool,
}

impl Gripper {
    fn new() -> Self {
        let mut new = Self {
            folder: tempfile::tempdir().unwrap(),
            models: None,
            keys: ModelKeys::default(),
            now_us: 0,
            fault: FaultCode::NONE,
            number: 0,
            put: Vec::new(),
            refuses: false,
        };
        new.start();
        new
    }

    fn path(&self) -> &Path {
        self.folder.path()
    }

    /// gripfleet starts again, beside a gripd with the model of the configuration.
    fn start(&mut self) {
        self.models = None;
        let models = Models::open(self.path(), id("file")).unwrap();
        self.models = Some(models.with_keys(self.keys.clone()));
        self.with(|models, _, swap| models.resume(&sha256("file"), swap));
    }

    fn with<T>(&mut self, act: impl FnOnce(&mut Models, u64, &mut super::Swap<'_>) -> T) -> T {
        let Self { models, now_us, number, put, refuses, .. } = self;
        let mut swap = |what: Put<'_>| {
            if *refuses {
                return Err("no".to_owned());
            }
            let (beside, model) = match what {
                Put::InForce(model) => ("", model),
                Put::Beside(model) => ("beside ", model),
            };
            put.push(format!("{beside}{}", model.map_or("-", |model| &*model.id.name)));
            *number += 1;
            Ok(*number)
        };
        act(models.as_mut().unwrap(), *now_us, &mut swap)
    }

    fn models(&mut self) -> &mut Models {
        self.models.as_mut().unwrap()
    }

    fn standing(&self) -> Standing {
        self.models.as_ref().unwrap().standing()
    }

    fn ask(&mut self, order: Order) -> Result<Standing, String> {
        self.with(|models, now_us, swap| models.obey(order, now_us, swap))
            .map_err(|refused| refused.to_string())
    }

    fn obey(&mut self, order: Order) -> Standing {
        self.ask(order).unwrap()
    }

    fn watch(&mut self, name: &str, from: usize) -> Standing {
        self.obey(Order::Watch { sha256: sha256(name), from })
    }

    fn accept(&mut self, name: &str) -> Standing {
        self.obey(Order::Accept { sha256: sha256(name) })
    }

    fn pass(&mut self, seconds: u64) {
        self.now_us += 1_000_000 * seconds;
        let fault = self.fault;
        self.with(|models, now_us, swap| models.tick(now_us, fault, swap));
    }

    /// Finishes so many grasps, in which both models were asked.
    fn grasp(&mut self, count: u64) {
        let (in_force_n, shadow_n, slipped_n) = (Some(6.0), Some(6.0), 3.0);
        let compared = Some(Compared { in_force_n, shadow_n, slipped_n, held_n: None });
        for _ in 0..count {
            self.number += 1;
            let regrasps = u32::try_from(self.number).unwrap();
            let grasp = Grasp { compared, regrasps, ..Grasp::default() };
            let number = self.number;
            self.models().grasped(&Finished { number, grasp });
        }
    }

    fn notices(&mut self) -> String {
        format!("{:?}", self.models().notices())
    }

    /// Does what a word of a story says; the reason, where that is refused.
    fn act(&mut self, word: &str) -> Option<String> {
        let (verb, what) = word.split_once(' ').unwrap_or((word, ""));
        let order = match verb {
            "take" => Order::Take(offer(what)),
            "shadow" => Order::Shadow(offer(what)),
            "accept" => Order::Accept { sha256: sha256(what) },
            "watch" => Order::Watch { sha256: sha256(what), from: 0 },
            "back" if what.is_empty() => back(),
            "back" => Order::Back { sha256: Some(sha256(what)), why: None },
            "pause" => Order::Pause { by: "bob".to_owned() },
            "resume" => Order::Resume,
            "wait" => {
                self.pass(what.parse().unwrap());
                return None;
            }
            "reload" => {
                self.with(|models, _, swap| models.reloaded(id(what), swap));
                return None;
            }
            "fault" => {
                self.fault = FaultCode::OBJECT_LOST;
                self.pass(0);
                return None;
            }
            "start" => {
                self.start();
                return None;
            }
            "fail" | "recover" => {
                self.refuses = verb == "fail";
                return None;
            }
            _ => panic!("{word}"),
        };
        self.ask(order).err()
    }

    /// The model in force, whether it is on trial, which one comes back, what estimates beside it, and what became of the last one.
    fn shown(&self) -> String {
        let Standing { in_force, before, trial, shadow, last, .. } = self.standing();
        let trial = trial.map_or("", |_| " on trial");
        let before = before.map_or_else(String::new, |before| format!(" over {}", before.name));
        let shadow = shadow.map_or_else(String::new, |it| format!(" beside {}", it.model.name));
        let last = last.map_or_else(String::new, |it| format!("; {} {:?}", it.model.name, it.how));
        format!("{}{trial}{before}{shadow}{last}", in_force.name)
    }
}

#[test]
fn a_model_is_tried_and_stays_or_goes() {
    for (story, wanted) in [
        ("take a", "a on trial over file"),
        ("take a, accept a, accept a", "a over file; a Accepted"),
        // Nobody needs to watch it any more.
        ("take a, accept a, wait 9999", "a over file; a Accepted"),
        ("take a, back", "file; a Ordered"),
        ("take a, accept a, back b", "a over file; a Accepted"),
        ("take a, accept a, back a, back a", "file; a Ordered"),
        // The program of the operator was killed, and another one takes it up again.
        ("take a, wait 50, watch a, wait 60", "a on trial over file"),
        ("take a, wait 50, watch a, wait 61", "file; a Unwatched"),
        ("take a, wait 50, take a, wait 60", "a on trial over file"),
        // The way back is always open: in the first seconds of a trial, without a grasp, and when it is over.
        ("take a, accept a, take b, back", "a over file; b Ordered"),
        ("take a, accept a, take b, back, back", "file; a Ordered"),
        ("take a, accept a, take b, back, back, back", "file; a Ordered"),
        // The models of the configuration and before need no trial: a bad model does not lock itself in.
        ("take a, accept a, fault, take file", "file; a Ordered"),
        ("take a, accept a, take b, accept b, fault, take file", "file; b Ordered"),
        ("take a, accept a, take b, accept b, fault, take a", "a over file; b Ordered"),
        // gripfleet starts again during the trial, or after it.
        ("take a, start", "file; a Restarted"),
        ("take a, accept a, take b, start", "a over file; b Restarted"),
        ("take a, accept a, take b, accept b, start", "b over a; b Accepted"),
        // Other settings come in force.
        ("take a, reload c", "c; a Reloaded"),
        ("take a, accept a, reload c", "a over c; a Accepted"),
        // It cannot be put in force; or the one before cannot, and is tried again.
        ("fail, take a", "file; a Failed"),
        ("take a, fail, wait 61, recover, wait 1", "file; a Unwatched"),
        // A pause keeps model, lease and the way back.
        ("take a, pause", "a on trial over file"),
        ("take a, pause, wait 61", "file; a Unwatched"),
        ("take a, accept a, pause, take file", "file; a Ordered"),
        ("pause, take a, shadow a", "file"),
        ("pause, start, take a, resume, take b", "b on trial over file"),
        // A shadow moves nothing, and goes with its lease, its order, or when a model is taken.
        ("shadow a, wait 50, watch a, wait 60", "file beside a"),
        ("shadow a, wait 61", "file"),
        ("shadow a, back a", "file"),
        ("shadow a, shadow b", "file beside b"),
        ("shadow a, take a", "a on trial over file"),
        ("shadow a, take b", "b on trial over file"),
        ("shadow a, start", "file"),
        // What is in force already is on no trial.
        ("take file", "file"),
    ] {
        let mut gripper = Gripper::new();
        let refused: Vec<String> = story.split(", ").filter_map(|word| gripper.act(word)).collect();
        let may = story.contains("fail") || refused.is_empty();
        assert!(gripper.shown() == wanted && may, "{story}: {} {refused:?}", gripper.shown());
    }
}

#[test]
fn what_cannot_be_obeyed_is_refused_in_a_sentence() {
    for (story, wanted) in [
        ("take a, take b", "is on trial here"),
        ("fault, take a", "this gripper has latched fault 0201, and nothing can be tried on it"),
        ("watch a", "that model is not on trial here"),
        (
            "take a, wait 61, accept a",
            "that model is not on trial here: nobody watched its trial any more",
        ),
        ("shadow a, wait 61, watch a", "that model is not on trial here"),
        ("fail, take a", "the model cannot be put in force: no"),
        ("fail, shadow a", "the model cannot estimate beside the one in force: no"),
    ] {
        let mut gripper = Gripper::new();
        let refused: Vec<String> = story.split(", ").filter_map(|word| gripper.act(word)).collect();
        let [why] = &refused[..] else { panic!("{story}: {refused:?}") };
        assert!(why.ends_with(wanted), "{story}: {why}");
    }
    let lease = Order::Take(Offer { lease_s: 0, ..offer("a") });
    let refused = Gripper::new().ask(lease).unwrap_err();
    assert_eq!(refused, "lease=0: 1 to 86400 s are possible");
}

#[test]
fn each_model_has_grasps_of_its_own() {
    let mut gripper = Gripper::new();
    gripper.grasp(12);
    let taken = gripper.obey(Order::Take(offer("a")));
    assert_eq!((taken.trial.unwrap().before, taken.grasps.len(), taken.grasped), (12, 12, 0));
    gripper.grasp(5);
    let watched = gripper.watch("a", 3);
    assert_eq!((watched.grasped, watched.grasps.len()), (5, 2), "those that are not known yet");
    assert_eq!(gripper.watch("a", 9).grasps, []);
    // In a pause none counts.
    gripper.act("pause");
    gripper.grasp(4);
    assert_eq!(gripper.watch("a", 0).grasps.len(), 5);
    gripper.act("resume");
    gripper.grasp(1);
    assert_eq!(gripper.watch("a", 0).grasps.len(), 6);
    gripper.pass(61);
    assert_eq!(gripper.standing().grasped, 12, "it goes on where it was");
    // A shadow has those in which both were asked.
    gripper.act("shadow b");
    gripper.grasp(2);
    let grasp = Grasp::default();
    let number = gripper.number + 1;
    gripper.models().grasped(&Finished { number, grasp });
    let watched = gripper.watch("b", 1);
    assert_eq!((watched.grasps.len(), watched.shadow.unwrap().compared), (1, 2));
    // Asked again nothing is put, and the grasps stay.
    gripper.act("shadow b");
    assert_eq!(gripper.standing().shadow.unwrap().compared, 2);
    // Grasps with other settings are nothing to compare with.
    gripper.act("reload c");
    assert_eq!(gripper.standing().grasped, 0);
    assert_eq!(gripper.put, ["a", "-", "beside b"]);
}

/// A long run keeps the latest grasps, a long trial the first ones.
#[test]
fn grasps_are_kept_up_to_a_thousand() {
    let mut gripper = Gripper::new();
    gripper.grasp(1500);
    let taken = gripper.obey(Order::Take(offer("a"))).grasps;
    assert_eq!((taken.len(), taken[0].regrasps), (1000, 501));
    gripper.grasp(1500);
    let watched = gripper.watch("a", 0).grasps;
    assert_eq!((watched.len(), watched[0].regrasps), (1000, 1502));
}

#[test]
fn what_is_accepted_is_put_in_force_at_the_next_start_and_the_rest_is_let_go() {
    let mut gripper = Gripper::new();
    for word in ["take a", "accept a", "take b", "start"] {
        assert_eq!(gripper.act(word), None);
    }
    assert_eq!(gripper.put, ["a", "b", "a"]);
    assert!(gripper.notices().contains("gripfleet has started again during the trial"));
    let file = |name: &str| gripper.path().join(format!("{}.json", sha256(name)));
    assert!(file("a").exists() && !file("b").exists(), "nothing names it");
    let second = Models::open(gripper.path(), id("file")).unwrap_err().to_string();
    assert!(second.ends_with("another gripd keeps its models there"), "{second}");
    // A file that was changed is not believed, and one that is none is reported.
    fs::write(file("a"), "other").unwrap();
    let wrong = |gripper: &mut Gripper| {
        gripper.models = None;
        Models::open(gripper.path(), id("file")).unwrap_err().to_string()
    };
    let reported = wrong(&mut gripper);
    assert!(reported.ends_with("another SHA-256 than its name says"), "{reported}");
    fs::write(gripper.path().join("standing.json"), "{").unwrap();
    let reported = wrong(&mut gripper);
    assert!(reported.contains("standing.json: EOF"), "{reported}");
}

#[test]
fn the_way_back_that_fails_is_reported_once() {
    let mut gripper = Gripper::new();
    gripper.act("take a");
    gripper.models().notices();
    for word in ["fail", "wait 61", "wait 1", "wait 1"] {
        gripper.act(word);
    }
    let notices = gripper.models().notices();
    let troubles = notices.iter().filter(|notice| matches!(notice, Notice::Trouble(_)));
    assert_eq!(troubles.count(), 1, "{notices:?}");
    gripper.act("recover");
    gripper.pass(1);
    let back = format!("{} is in force", id("file"));
    assert_eq!(gripper.models().notices(), [Notice::Done(back)]);
}

#[test]
fn recordings_are_replayed_once_and_what_they_show_is_kept_for_a_lease() {
    let mut gripper = Gripper::new();
    let replay = |name: &str| Order::Replay(offer(name));
    assert!(gripper.obey(replay("a")).replay.unwrap().running);
    assert_eq!(gripper.models().rehearsing().unwrap().id.sha256, sha256("a"));
    // Asked again, also for another model, it goes on.
    gripper.pass(1);
    for name in ["a", "b"] {
        assert!(gripper.obey(replay(name)).replay.unwrap().running);
        assert!(gripper.models().rehearsing().is_none());
    }
    let shown = Rehearsal { recordings: 2, skipped: vec!["x".to_owned()], grasps: Vec::new() };
    gripper.models().rehearsed(shown.clone());
    gripper.pass(1);
    let asked = gripper.obey(replay("a")).replay.unwrap();
    assert_eq!((asked.running, asked.rehearsal), (false, shown));
    gripper.pass(61);
    assert!(gripper.obey(replay("a")).replay.unwrap().running);
    assert!(gripper.models().rehearsing().is_some(), "what was shown then is too old");
    assert_eq!(gripper.put, [""; 0]);
}

#[test]
fn the_history_has_each_model_with_its_end_and_survives_a_start() {
    let mut gripper = Gripper::new();
    gripper.models().set_utc(5);
    let stage =
        |name: &str, stage| Offer { origin: Origin::new("alice", 17, stage), ..offer(name) };
    gripper.obey(Order::Shadow(stage("a", 0)));
    gripper.grasp(2);
    let why = Some("after 3 grasps with the new model: it is worse".to_owned());
    gripper.obey(Order::Back { sha256: Some(sha256("a")), why: why.clone() });
    // From the shadow stage to the end of its trial one entry.
    gripper.obey(Order::Shadow(stage("b", 0)));
    gripper.obey(Order::Take(stage("b", 3)));
    gripper.grasp(4);
    gripper.models().set_utc(9);
    gripper.accept("b");
    gripper.obey(Order::Take(stage("c", 1)));
    let check = gripper.obey(Order::Check(stage("c", 1)));
    assert_eq!(check.history.len(), 1, "the one that goes on");
    let history = gripper.obey(Order::History).history;
    assert_eq!((history.len(), history[2].how, history[2].grasps), (3, None, Some(0)));
    gripper.act("pause");
    gripper.start();
    assert_eq!(gripper.standing().paused.map(|it| (it.by, it.at_ns)), Some(("bob".to_owned(), 9)));
    let history = gripper.obey(Order::History).history;
    let short = |entry: &Entry| {
        let Origin { by, rollout_ns, stage } = entry.origin.clone();
        (by, rollout_ns, stage, entry.grasps, entry.how, entry.ended_ns)
    };
    let alice = || "alice".to_owned();
    assert_eq!(
        history.iter().map(short).collect::<Vec<_>>(),
        [
            (alice(), 17, 0, Some(2), Some(How::Ordered), Some(5)),
            (alice(), 17, 3, Some(4), Some(How::Accepted), Some(9)),
            (alice(), 17, 1, None, Some(How::Restarted), None),
        ]
    );
    assert_eq!(history[0].why, why);
    // A file that cannot be read costs no model.
    gripper.models = None;
    fs::write(gripper.path().join("history.json"), "{").unwrap();
    gripper.start();
    assert!(gripper.notices().contains("history.json"));
    assert_eq!(gripper.shown(), "b over file; c Restarted");
}

#[test]
fn the_latest_entries_are_kept_and_texts_are_those_of_a_parameter() {
    let mut history = History::default();
    for begun_ns in 0..=100 {
        let model = ModelId { name: "m".to_owned(), sha256: begun_ns.to_string() };
        history.begin(&model, &Origin::default(), None, begun_ns);
    }
    assert_eq!((history.entries.len(), history.entries[0].begun_ns), (100, 1));
    assert_eq!(Origin::new("a;b=c\n", 0, 0).by, "a,b,c");
    assert_eq!(reason(&"x".repeat(1000)).len(), 300);
}

/// A model was accepted before keys were set; then a signed one. The way leads back over both, and the older one may be ordered as well.
#[test]
fn a_model_that_is_not_signed_comes_only_as_the_way_back() {
    let mut gripper = Gripper::new();
    for word in ["take a", "accept a"] {
        gripper.act(word);
    }
    gripper.keys = ModelKeys::new(&[KEY.to_owned()], false).unwrap();
    gripper.start();
    let unsigned = "new.json: it is not signed, and model_keys takes signed models only; sign it: `minisign -Sm new.json`";
    let other = "new.json: it is signed with key A1645C1206F7CE7B, which is not in model_keys; add that key";
    let changed = "new.json: its signature is not of this model";
    for (text, why) in [
        (text("b"), unsigned),
        (MODEL.to_owned() + BY_OTHER, other),
        (MODEL.to_owned() + " " + SIGNATURE, changed),
    ] {
        for order in [Order::Check, Order::Replay, Order::Shadow, Order::Take] {
            let reason = gripper.ask(order(of("new.json", &text))).unwrap_err();
            assert!(reason.starts_with(why), "{reason}");
        }
    }
    assert_eq!(gripper.shown(), "a over file; a Accepted");
    // A signed one is taken, kept as it came, and its signer stands in the history.
    let signed = MODEL.to_owned() + SIGNATURE;
    let digest = digest(signed.as_bytes());
    let accept = |gripper: &mut Gripper| {
        gripper.obey(Order::Take(of("new.json", &signed)));
        gripper.obey(Order::Accept { sha256: digest.clone() });
    };
    accept(&mut gripper);
    let signer = gripper.obey(Order::History).history.pop().unwrap().signed.unwrap();
    let comment = "trained in hall-2, card sha256:0f1e";
    assert_eq!((&*signer.key, &*signer.comment), ("AF8131513DC1E017", comment));
    assert_eq!(fs::read_to_string(gripper.path().join(format!("{digest}.json"))).unwrap(), signed);
    assert_eq!(gripper.act("take a"), None);
    assert_eq!(gripper.shown(), "a over file; new.json Ordered");
    accept(&mut gripper);
    for wanted in ["a over file; new.json Ordered", "file; a Ordered"] {
        gripper.act("back");
        assert_eq!(gripper.shown(), wanted);
    }
    // It is a model like any other now.
    assert!(gripper.act("take a").unwrap().starts_with("a: it is not signed"));
}

/// What comes of a model file in which something is replaced.
fn with(from: &str, to: &str) -> String {
    let text = default_text().replacen(from, to, 1);
    assert_ne!(text, default_text());
    refused(text.as_bytes())
}

fn refused(bytes: &[u8]) -> String {
    examine("m.json", &digest(bytes), bytes).unwrap_err().to_string()
}

#[test]
fn a_model_that_is_broken_or_foreign_is_refused_in_a_sentence() {
    let text = default_text();
    let reported = examine("m.json", &digest(b"x"), text.as_bytes()).unwrap_err().to_string();
    assert!(reported.starts_with("what came is not what was ordered"), "{reported}");
    assert_eq!(refused(b""), "no model came with the order");
    assert!(refused(&[b' '; (1 << 20) + 1]).contains("1048577 bytes; more than 1048576"));
    assert!(refused(&[0xFF; 9]).contains("no text"));
    let cut = refused(&text.as_bytes()[..text.len() / 2]);
    assert!(cut.starts_with("m.json: ") && cut.contains("line"), "{cut}");
    let nan = with("4.3647456", "NaN");
    assert!(nan.starts_with("m.json: "), "{nan}");
    let force = "\"adequate_force_n\",\n      \"unit\": \"N\"";
    for (from, to, words) in [
        (force, &*force.replace("\"N\"", "\"lbf\""), "`lbf`, not a force in N"),
        ("slip_acceleration_m_s2", "temperature_k", "temperature_k"),
        ("\"version\": 1", "\"version\": 2", "has version 2"),
        ("mlp-model", "tree-model", "of the kind tree-model"),
    ] {
        let reported = with(from, to);
        assert!(reported.contains(words), "{reported}");
    }
}

#[test]
fn a_model_that_does_not_know_the_force_fails_the_self_test() {
    let wrong = with("0.8985352", "0.5");
    let begin = "m.json fails the self-test: half of its answers are off";
    assert!(wrong.starts_with(begin), "{wrong}");
    assert!(wrong.ends_with(" % or more; 25 % and 50 % are the most"), "{wrong}");
    assert!(refused(built_in(Path::new("paper")).unwrap().as_bytes()).contains("self-test"));
    let text = default_text().as_bytes();
    assert_eq!(examine("../a b/m.json", &digest(text), text).unwrap().id.name, "..abm.json");
}
