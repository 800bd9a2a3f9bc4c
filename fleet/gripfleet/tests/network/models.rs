//! Models over the network to gripfleet, and from there to gripd, beside a router in the test: taken, tried, kept over a start, given back; and refused.

use crate::{
    pair::{Pair, configure, gripfleet},
    rig::{at, endpoint, router},
};
use core::time::Duration;
use grip_fleet::{
    Member, Part, Selector,
    deploy::{How, Offer, Order, Standing, digest},
    net::{self, Ask, NetError, Session, list, standing},
};
use grip_link::message::daemon::{Command, GripState, Operation};
use grip_session::model::default_text;
use std::{fs, path::Path};
use stories::until;
use tempfile::TempDir;

const PATIENCE: Duration = Duration::from_secs(30);
/// A key, and a model that it has signed.
const KEY: &str = "RWQX4ME9UTGBr9z/nnfFMLox/Beua3vRoZ+aO7nc6TUMmM0TFCAfbnmZ";
const MODEL: &str = include_str!("../../../../crates/grip-session/tests/signed/model.json");
const SIGNATURE: &str =
    include_str!("../../../../crates/grip-session/tests/signed/model.json.minisig");

/// A router, a folder with a configuration, and the session of an operator.
struct Hall {
    session: Session,
    _router: Session,
    folder: TempDir,
    endpoint: String,
}

impl Hall {
    /// Commands are taken, and models into a folder.
    fn new() -> Self {
        Self::with("models = \"models\"")
    }

    /// `rest` goes behind [fleet].
    fn with(rest: &str) -> Self {
        let endpoint = endpoint();
        let (router, folder) = (router(&endpoint), tempfile::tempdir().unwrap());
        let session = at(&endpoint).open().unwrap();
        let hall = Self { session, _router: router, folder, endpoint };
        hall.configure("link.sample_rate_hz = 1000", rest);
        hall
    }

    fn configure(&self, top: &str, rest: &str) {
        let top = format!("allow_models = true\nallow_commands = true\n{top}");
        configure(self.path(), &self.endpoint, &top, &format!("commands = true\n{rest}"));
    }

    fn path(&self) -> &Path {
        self.folder.path()
    }

    /// What a gripper answers to an order.
    fn ask(&self, member: &Member, order: &Order) -> Result<Standing, String> {
        standing(&self.session, member, order, PATIENCE).map_err(|error| match error {
            NetError::Declined { reason, .. } => reason,
            other => panic!("{other}"),
        })
    }
}

/// The gripper that a running gripfleet has announced.
fn member(pair: &Pair) -> Member {
    pair.name().parse().unwrap()
}

/// What `gripfleet command` sends.
fn command(session: &Session, member: &Member, operation: Operation) {
    let ask = |payload: &[u8]| {
        let part = Part::Command;
        let question = Ask { member, part, parameters: &[], payload, patience: PATIENCE };
        net::ask(session, &question).unwrap().concat()
    };
    let token = String::from_utf8(ask(&[])).unwrap().parse().unwrap();
    let command = Command { token, ..Command::new(operation) };
    let mut payload = [0; Command::SIZE];
    command.write(&mut payload).unwrap();
    ask(&payload);
}

/// Lets go, and grasps once more, until the object is held.
fn regrasp(session: &Session, member: &Member) {
    let grip =
        || list(session, &Selector::default()).unwrap().remove(member)?.state.map(|it| it.grip);
    command(session, member, Operation::Release);
    assert!(until(|| grip() == Some(GripState::Released)));
    command(session, member, Operation::Grasp);
    assert!(until(|| grip() == Some(GripState::Holding)));
}

fn take(text: &str) -> Order {
    Order::Take(offer(text))
}

fn offer(text: &str) -> Offer {
    Offer::new("new.json".to_owned(), text.into(), 3600)
}

/// The same model, with another SHA-256.
fn same(spaces: usize) -> String {
    default_text().to_owned() + &" ".repeat(spaces)
}

#[test]
fn a_model_is_tried_kept_over_a_start_and_given_back() {
    let hall = Hall::new();
    // An object that can be let go, since it stands on a table.
    fs::write(hall.path().join("table.toml"), "name = \"table\"\nlift_at_s = 60.0\n").unwrap();
    let first = Pair::start(hall.path(), &["--port", "sim:table.toml"]);
    let who = member(&first);
    let grasped = |count: usize| {
        let now = || hall.ask(&who, &Order::Notify).unwrap().grasped;
        assert!(until(|| now() >= count));
    };
    // Two grasps with the model of the configuration; the one that goes on when the model changes is nobody's.
    (0..3).for_each(|_| regrasp(&hall.session, &who));
    grasped(2);
    let standing = hall.ask(&who, &take(&same(1))).unwrap();
    assert_eq!(
        (standing.in_force.name.as_str(), standing.before.unwrap().name),
        ("new.json", "default".to_owned())
    );
    assert_eq!(
        (standing.trial.unwrap().before, standing.grasps.len(), standing.grasped),
        (2, 2, 0)
    );
    first.gripd.until_reported("of a client is in force");
    (0..2).for_each(|_| regrasp(&hall.session, &who));
    grasped(1);
    let sha256 = digest(same(1).as_bytes());
    let watched = hall.ask(&who, &Order::Watch { sha256: sha256.clone(), from: 0 }).unwrap();
    assert!(watched.grasps.len() == 1 && !watched.grasps[0].lost, "{watched:?}");
    hall.ask(&who, &Order::Accept { sha256 }).unwrap();
    first.fleet.until_reported("its trial is over, and it stays");
    // To ask whether it would take another one changes nothing.
    let would = hall.ask(&who, &Order::Check(offer(&same(3)))).unwrap();
    assert_eq!((would.in_force.sha256, would.trial), (digest(same(1).as_bytes()), None));
    let never = Order::Check(Offer { lease_s: 0, ..offer(&same(3)) });
    assert!(hall.ask(&who, &never).unwrap_err().starts_with("lease=0: "));
    // The second model is on trial when gripd is killed, and gripfleet stays.
    assert!(hall.ask(&who, &take(&same(2))).unwrap().trial.is_some());
    let Pair { gripd, fleet } = first;
    gripd.kill();
    let second = Pair::holding_beside(hall.path(), fleet);
    let mut standing = None;
    assert!(until(|| {
        standing = hall.ask(&who, &Order::Notify).ok();
        standing.is_some()
    }));
    let standing = standing.unwrap();
    assert_eq!(standing.in_force.sha256, digest(same(1).as_bytes()));
    assert_eq!(standing.last.unwrap().how, How::Restarted);
    second.gripd.until_reported("of a client is in force");
    // Also where gripfleet starts again, what was accepted is there. One word leads to the model before.
    let Pair { gripd, fleet } = second;
    fleet.kill();
    let third = Pair { gripd, fleet: gripfleet(hall.path(), &[]) };
    assert_eq!(member(&third), who);
    let back = || hall.ask(&who, &Order::Back { sha256: None, why: None });
    let standing = back().unwrap();
    assert_eq!((standing.in_force.name.as_str(), standing.before), ("default", None));
    assert_eq!(back().unwrap().in_force.name, "default", "there is none before");
    third.gripd.until_reported("model embedded model is in force");
    third.stop();
}

/// The object is pulled out of the fingers during the trial: a grasp that ends with a loss. A gripper in FAULT tries nothing, and goes back all the same.
#[test]
fn a_lost_object_is_a_grasp_and_a_gripper_in_fault_tries_nothing() {
    const PULLED: &str = "name = \"pulled\"\nlift_at_s = 15.0\n[tug]\nforce_n = 400.0\nstart_s = 5.2\nhold_ms = 1000.0\n";
    let hall = Hall::with("models = \"models\"\n[grip]\nrelax_per_s = 0.0");
    fs::write(hall.path().join("pulled.toml"), PULLED).unwrap();
    let running = Pair::start(hall.path(), &["--port", "sim:pulled.toml"]);
    let who = member(&running);
    let taken = hall.ask(&who, &take(&same(1))).unwrap();
    assert_eq!((taken.in_force.name.as_str(), taken.trial.is_some()), ("new.json", true));
    regrasp(&hall.session, &who);
    running.gripd.until_reported("the object is gone");
    let sha256 = digest(same(1).as_bytes());
    let lost = || {
        let watched = hall.ask(&who, &Order::Watch { sha256: sha256.clone(), from: 0 });
        watched.unwrap().grasps.iter().any(|grasp| grasp.lost)
    };
    assert!(until(lost));
    // An empty hand in FAULT is no grasp, however long it lasts.
    let grasped = hall.ask(&who, &Order::Notify).unwrap().grasped;
    let back = hall.ask(&who, &Order::Back { sha256: None, why: None }).unwrap();
    assert_eq!((back.in_force.name.as_str(), back.trial, grasped), ("default", None, 1));
    let refused = hall.ask(&who, &take(&same(2))).unwrap_err();
    assert!(refused.starts_with("this gripper has latched fault 0201"), "{refused}");
    running.stop();
}

/// gripfleet and gripd read the same keys. A model of before is still accepted, and what the way back leads to.
#[test]
fn a_model_that_is_not_signed_comes_only_as_the_way_back() {
    let hall = Hall::new();
    let configured = |keys: &str| {
        let top = format!("dump_dir = \"state\"\nlink.sample_rate_hz = 1000\n{keys}");
        hall.configure(&top, "models = \"models\"");
    };
    configured("");
    let pair = Pair::start(hall.path(), &["--dry-run"]);
    let who = member(&pair);
    let accept = |text: &str| {
        assert!(hall.ask(&who, &take(text)).unwrap().trial.is_some());
        hall.ask(&who, &Order::Accept { sha256: digest(text.as_bytes()) }).unwrap();
    };
    accept(&same(1));
    pair.stop();
    configured(&format!("model_keys = [\"{KEY}\"]"));
    let pair = Pair::start(hall.path(), &["--dry-run"]);
    pair.gripd.until_reported("of a client is in force");
    member(&pair);
    let reported = hall.ask(&who, &take(&same(2))).unwrap_err();
    assert!(reported.starts_with("new.json: it is not signed"), "{reported}");
    accept(&(MODEL.to_owned() + SIGNATURE));
    pair.gripd.until_reported("is in force (signed with key AF8131513DC1E017: trained in hall-2");
    let back = || hall.ask(&who, &Order::Back { sha256: None, why: None }).unwrap();
    assert_eq!(back().in_force.sha256, digest(same(1).as_bytes()));
    assert_eq!(back().in_force.name, "default");
    pair.stop();
}

#[test]
fn settings_that_change_during_a_trial_end_it() {
    let hall = Hall::new();
    let running = Pair::holding(hall.path(), &[]);
    let who = member(&running);
    assert!(hall.ask(&who, &take(&same(1))).unwrap().trial.is_some());
    let rest = "models = \"models\"\n[detector.shear]\nlow_hz = 30.0";
    hall.configure("link.sample_rate_hz = 1000", rest);
    running.reload();
    running.fleet.until_reported("its settings were changed during the trial");
    running.fleet.until_reported("model default");
    let standing = hall.ask(&who, &Order::Notify).unwrap();
    assert_eq!((standing.in_force.name.as_str(), standing.trial), ("default", None));
    let reported = running.stop();
    assert!(reported.contains("are in force: detector.shear.low_hz"), "{reported}");
}

#[test]
fn whoever_wants_no_model_states_so() {
    for (rest, args, words) in [
        ("", &[][..], "models is not set in [fleet]"),
        ("models = \"models\"", &["--model", "default"], "was named with --model or GRIPD_MODEL"),
    ] {
        let hall = Hall::with(rest);
        let running = Pair::start(hall.path(), args);
        let who = member(&running);
        let reported = hall.ask(&who, &take(&same(1))).unwrap_err();
        assert!(reported.contains(words), "{reported}");
        assert!(!hall.path().join("models").exists());
        running.stop();
    }
}

#[test]
fn a_damaged_folder_of_models_keeps_nobody_from_holding() {
    let hall = Hall::new();
    fs::create_dir(hall.path().join("models")).unwrap();
    fs::write(hall.path().join("models/standing.json"), "{").unwrap();
    let running = Pair::holding(hall.path(), &[]);
    running.fleet.until_reported("the model of the configuration is in force");
    let who = member(&running);
    let reported = hall.ask(&who, &take(&same(1))).unwrap_err();
    assert!(reported.contains("the folder of models cannot be used"), "{reported}");
    running.stop();
}

/// A second model is asked beside the one in force, as long as somebody watches it, and on recordings: the one in force stays.
#[test]
fn a_model_is_asked_beside_the_one_in_force_and_on_recordings() {
    let hall = Hall::new();
    let top = "record = \"run-{start}.mcap\"\nlink.sample_rate_hz = 1000";
    hall.configure(top, "models = \"models\"");
    let pair = Pair::holding(hall.path(), &[]);
    let who = member(&pair);
    let order = |lease_s| Offer { lease_s, ..offer(&same(1)) };
    let standing = hall.ask(&who, &Order::Shadow(order(2))).unwrap();
    assert_eq!((standing.in_force.name.as_str(), standing.trial), ("default", None));
    assert_eq!(standing.shadow.unwrap().model.name, "new.json");
    pair.gripd.until_reported("of a client estimates beside the one in force");
    pair.fleet.until_reported("nobody watches it");
    pair.gripd.until_reported("no model estimates beside the one in force any more");
    assert_eq!(hall.ask(&who, &Order::Notify).unwrap().shadow, None);
    let mut replay = None;
    assert!(until(|| {
        replay = hall.ask(&who, &Order::Replay(order(3600))).unwrap().replay;
        replay.as_ref().is_some_and(|replay| !replay.running)
    }));
    let shown = replay.unwrap().rehearsal;
    // The only recording is being written.
    assert_eq!((shown.recordings, shown.skipped.len(), shown.grasps.len()), (0, 1, 0));
    assert_eq!(shown.skipped[0], "no recording has ended here that could be replayed");
    assert_eq!(hall.ask(&who, &Order::Notify).unwrap().in_force.name, "default");
    pair.stop();
}
