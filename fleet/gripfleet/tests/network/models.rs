//! Models over the network to gripfleet, and from there to gripd, beside a router in the test: taken, tried, kept over a start, given back; and refused.

use crate::pair::{Pair, configure, endpoint, gripfleet};
use core::time::Duration;
use grip_fleet::{
    Member, Part, Selector,
    deploy::{How, Offer, Order, Origin, Standing, digest},
    net::{self, Ask, NetError, Network, Session, list, standing},
};
use grip_link::message::daemon::{Command, GripState, Operation};
use grip_session::model::default_text;
use std::{fs, path::Path};
use stories::until;

const PATIENCE: Duration = Duration::from_secs(30);
/// A key, and a model that it has signed.
const KEY: &str = "RWQX4ME9UTGBr9z/nnfFMLox/Beua3vRoZ+aO7nc6TUMmM0TFCAfbnmZ";
const MODEL: &str = include_str!("../../../../crates/grip-session/tests/signed/model.json");
const SIGNATURE: &str =
    include_str!("../../../../crates/grip-session/tests/signed/model.json.minisig");

/// Models are taken, commands too; `rest` goes behind [fleet].
fn place(folder: &Path, endpoint: &str, rest: &str) {
    let top = "allow_models = true\nallow_commands = true\nlink.sample_rate_hz = 1000";
    configure(folder, endpoint, top, &format!("commands = true\n{rest}"));
}

fn network(endpoint: &str) -> Network {
    Network { router: Some(endpoint.to_owned()), file: None }
}

fn router(endpoint: &str) -> Session {
    net::router(&network(endpoint)).unwrap()
}

fn session(endpoint: &str) -> Session {
    network(endpoint).open().unwrap()
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
    let (name, bytes) = ("new.json".to_owned(), text.as_bytes());
    Offer {
        name,
        sha256: digest(bytes),
        lease_s: 3600,
        origin: Origin::default(),
        bytes: bytes.into(),
    }
}

/// What a gripper answers to an order.
fn ask(session: &Session, member: &Member, order: &Order) -> Result<Standing, String> {
    standing(session, member, order, PATIENCE).map_err(|error| match error {
        NetError::Declined { reason, .. } => reason,
        other => panic!("{other}"),
    })
}

/// The same model, with another SHA-256.
fn same(spaces: usize) -> String {
    default_text().to_owned() + &" ".repeat(spaces)
}

#[test]
fn a_model_is_tried_kept_over_a_start_and_given_back() {
    let folder = tempfile::tempdir().unwrap();
    let endpoint = endpoint();
    let _router = router(&endpoint);
    place(folder.path(), &endpoint, "models = \"models\"");
    let session = session(&endpoint);
    // An object that can be let go, since it stands on a table.
    fs::write(folder.path().join("table.toml"), "name = \"table\"\nlift_at_s = 60.0\n").unwrap();
    let first = Pair::start(folder.path(), &["--port", "sim:table.toml"]);
    let who = member(&first);
    let grasped = |count: usize| {
        let now = || ask(&session, &who, &Order::Notify).unwrap().grasped;
        assert!(until(|| now() >= count));
    };
    // Two grasps with the model of the configuration; the one that goes on when the model changes is nobody's.
    (0..3).for_each(|_| regrasp(&session, &who));
    grasped(2);
    let standing = ask(&session, &who, &take(&same(1))).unwrap();
    assert_eq!(
        (standing.in_force.name.as_str(), standing.before.unwrap().name),
        ("new.json", "default".to_owned())
    );
    assert_eq!(
        (standing.trial.unwrap().before, standing.grasps.len(), standing.grasped),
        (2, 2, 0)
    );
    first.gripd.until_reported("of a client is in force");
    (0..2).for_each(|_| regrasp(&session, &who));
    grasped(1);
    let sha256 = digest(same(1).as_bytes());
    let watched = ask(&session, &who, &Order::Watch { sha256: sha256.clone(), from: 0 }).unwrap();
    assert!(watched.grasps.len() == 1 && !watched.grasps[0].lost, "{watched:?}");
    ask(&session, &who, &Order::Accept { sha256 }).unwrap();
    first.fleet.until_reported("its trial is over, and it stays");
    // To ask whether it would take another one changes nothing.
    let would = ask(&session, &who, &Order::Check(offer(&same(3)))).unwrap();
    assert_eq!((would.in_force.sha256, would.trial), (digest(same(1).as_bytes()), None));
    let never = Order::Check(Offer { lease_s: 0, ..offer(&same(3)) });
    assert!(ask(&session, &who, &never).unwrap_err().starts_with("lease=0: "));
    // The second model is on trial when gripd is killed, and gripfleet stays.
    assert!(ask(&session, &who, &take(&same(2))).unwrap().trial.is_some());
    let Pair { gripd, fleet } = first;
    gripd.kill();
    let second = Pair::holding_beside(folder.path(), fleet);
    let mut standing = None;
    assert!(until(|| {
        standing = ask(&session, &who, &Order::Notify).ok();
        standing.is_some()
    }));
    let standing = standing.unwrap();
    assert_eq!(standing.in_force.sha256, digest(same(1).as_bytes()));
    assert_eq!(standing.last.unwrap().how, How::Restarted);
    second.gripd.until_reported("of a client is in force");
    // Also where gripfleet starts again, what was accepted is there. One word leads to the model before.
    let Pair { gripd, fleet } = second;
    fleet.kill();
    let third = Pair { gripd, fleet: gripfleet(folder.path(), &[]) };
    assert_eq!(member(&third), who);
    let back = || ask(&session, &who, &Order::Back { sha256: None, why: None });
    let standing = back().unwrap();
    assert_eq!((standing.in_force.name.as_str(), standing.before), ("default", None));
    assert_eq!(back().unwrap().in_force.name, "default", "there is none before");
    third.gripd.until_reported("model embedded model is in force");
    third.stop();
}

/// The program of the operator ended: a gripper on trial that nobody watches goes back by itself.
#[test]
fn a_model_that_nobody_watches_goes_back() {
    let folder = tempfile::tempdir().unwrap();
    let endpoint = endpoint();
    let _router = router(&endpoint);
    place(folder.path(), &endpoint, "models = \"models\"");
    let session = session(&endpoint);
    let pair = Pair::holding(folder.path(), &[]);
    let who = member(&pair);
    let order = Order::Take(Offer { lease_s: 2, ..offer(&same(1)) });
    assert!(ask(&session, &who, &order).unwrap().trial.is_some());
    pair.fleet.until_reported("nobody watched its trial any more");
    let standing = ask(&session, &who, &Order::Notify).unwrap();
    assert_eq!((standing.in_force.name.as_str(), standing.trial), ("default", None));
    assert_eq!(standing.last.unwrap().how, How::Unwatched);
    pair.stop();
}

/// The object is pulled out of the fingers during the trial: a grasp that ends with a loss. A gripper in FAULT tries nothing, and goes back all the same.
#[test]
fn a_lost_object_is_a_grasp_and_a_gripper_in_fault_tries_nothing() {
    const PULLED: &str = "name = \"pulled\"\nlift_at_s = 15.0\n[tug]\nforce_n = 400.0\nstart_s = 5.2\nhold_ms = 1000.0\n";
    let folder = tempfile::tempdir().unwrap();
    let endpoint = endpoint();
    let _router = router(&endpoint);
    let rest = "models = \"models\"\n[grip]\nrelax_per_s = 0.0";
    place(folder.path(), &endpoint, rest);
    fs::write(folder.path().join("pulled.toml"), PULLED).unwrap();
    let session = session(&endpoint);
    let running = Pair::start(folder.path(), &["--port", "sim:pulled.toml"]);
    let who = member(&running);
    let taken = ask(&session, &who, &take(&same(1))).unwrap();
    assert_eq!((taken.in_force.name.as_str(), taken.trial.is_some()), ("new.json", true));
    regrasp(&session, &who);
    running.gripd.until_reported("the object is gone");
    let sha256 = digest(same(1).as_bytes());
    let lost = || {
        let watched = ask(&session, &who, &Order::Watch { sha256: sha256.clone(), from: 0 });
        watched.unwrap().grasps.iter().any(|grasp| grasp.lost)
    };
    assert!(until(lost));
    // An empty hand in FAULT is no grasp, however long it lasts.
    let grasped = ask(&session, &who, &Order::Notify).unwrap().grasped;
    let back = ask(&session, &who, &Order::Back { sha256: None, why: None }).unwrap();
    assert_eq!((back.in_force.name.as_str(), back.trial, grasped), ("default", None, 1));
    let refused = ask(&session, &who, &take(&same(2))).unwrap_err();
    assert!(refused.starts_with("this gripper has latched fault 0201"), "{refused}");
    running.stop();
}

/// gripfleet and gripd read the same keys. A model of before is still accepted, and what the way back leads to.
#[test]
fn a_model_that_is_not_signed_comes_only_as_the_way_back() {
    let folder = tempfile::tempdir().unwrap();
    let endpoint = endpoint();
    let _router = router(&endpoint);
    let session = session(&endpoint);
    let configured = |keys: &str| {
        let top = format!(
            "allow_models = true\ndump_dir = \"state\"\nlink.sample_rate_hz = 1000\n{keys}"
        );
        configure(folder.path(), &endpoint, &top, "models = \"models\"");
    };
    configured("");
    let pair = Pair::start(folder.path(), &["--dry-run"]);
    let who = member(&pair);
    let accept = |text: &str| {
        assert!(ask(&session, &who, &take(text)).unwrap().trial.is_some());
        ask(&session, &who, &Order::Accept { sha256: digest(text.as_bytes()) }).unwrap();
    };
    accept(&same(1));
    pair.stop();
    configured(&format!("model_keys = [\"{KEY}\"]"));
    let pair = Pair::start(folder.path(), &["--dry-run"]);
    pair.gripd.until_reported("of a client is in force");
    member(&pair);
    let reported = ask(&session, &who, &take(&same(2))).unwrap_err();
    assert!(reported.starts_with("new.json: it is not signed"), "{reported}");
    accept(&(MODEL.to_owned() + SIGNATURE));
    pair.gripd.until_reported("is in force (signed with key AF8131513DC1E017: trained in hall-2");
    let back = || ask(&session, &who, &Order::Back { sha256: None, why: None }).unwrap();
    assert_eq!(back().in_force.sha256, digest(same(1).as_bytes()));
    assert_eq!(back().in_force.name, "default");
    pair.stop();
}

#[test]
fn settings_that_change_during_a_trial_end_it() {
    let folder = tempfile::tempdir().unwrap();
    let endpoint = endpoint();
    let _router = router(&endpoint);
    place(folder.path(), &endpoint, "models = \"models\"");
    let session = session(&endpoint);
    let running = Pair::holding(folder.path(), &[]);
    let who = member(&running);
    assert!(ask(&session, &who, &take(&same(1))).unwrap().trial.is_some());
    place(folder.path(), &endpoint, "models = \"models\"\n[detector.shear]\nlow_hz = 30.0");
    running.reload();
    running.fleet.until_reported("its settings were changed during the trial");
    running.fleet.until_reported("model default");
    let standing = ask(&session, &who, &Order::Notify).unwrap();
    assert_eq!((standing.in_force.name.as_str(), standing.trial), ("default", None));
    let reported = running.stop();
    assert!(reported.contains("are in force: detector.shear.low_hz"), "{reported}");
}

#[test]
fn whoever_wants_no_model_states_so() {
    let endpoint = endpoint();
    let _router = router(&endpoint);
    let session = session(&endpoint);
    for (rest, args, words) in [
        ("", &[][..], "models is not set in [fleet]"),
        ("models = \"models\"", &["--model", "default"], "was named with --model or GRIPD_MODEL"),
    ] {
        let folder = tempfile::tempdir().unwrap();
        place(folder.path(), &endpoint, rest);
        let running = Pair::start(folder.path(), args);
        let who = member(&running);
        let reported = ask(&session, &who, &take(&same(1))).unwrap_err();
        assert!(reported.contains(words), "{reported}");
        assert!(!folder.path().join("models").exists());
        running.stop();
    }
}

#[test]
fn a_damaged_folder_of_models_keeps_nobody_from_holding() {
    let endpoint = endpoint();
    let _router = router(&endpoint);
    let session = session(&endpoint);
    let folder = tempfile::tempdir().unwrap();
    place(folder.path(), &endpoint, "models = \"models\"");
    fs::create_dir(folder.path().join("models")).unwrap();
    fs::write(folder.path().join("models/standing.json"), "{").unwrap();
    let running = Pair::holding(folder.path(), &[]);
    running.fleet.until_reported("the model of the configuration is in force");
    let who = member(&running);
    let reported = ask(&session, &who, &take(&same(1))).unwrap_err();
    assert!(reported.contains("the folder of models cannot be used"), "{reported}");
    running.stop();
}

/// A second model is asked beside the one in force, as long as somebody watches it, and on recordings: the one in force stays.
#[test]
fn a_model_is_asked_beside_the_one_in_force_and_on_recordings() {
    let folder = tempfile::tempdir().unwrap();
    let endpoint = endpoint();
    let _router = router(&endpoint);
    let top = "allow_models = true\nrecord = \"run-{start}.mcap\"\nlink.sample_rate_hz = 1000";
    configure(folder.path(), &endpoint, top, "models = \"models\"");
    let session = session(&endpoint);
    let pair = Pair::holding(folder.path(), &[]);
    let who = member(&pair);
    let order = |lease_s| Offer { lease_s, ..offer(&same(1)) };
    let standing = ask(&session, &who, &Order::Shadow(order(2))).unwrap();
    assert_eq!((standing.in_force.name.as_str(), standing.trial), ("default", None));
    assert_eq!(standing.shadow.unwrap().model.name, "new.json");
    pair.gripd.until_reported("of a client estimates beside the one in force");
    pair.fleet.until_reported("nobody watches it");
    pair.gripd.until_reported("no model estimates beside the one in force any more");
    assert_eq!(ask(&session, &who, &Order::Notify).unwrap().shadow, None);
    let mut replay = None;
    assert!(until(|| {
        replay = ask(&session, &who, &Order::Replay(order(3600))).unwrap().replay;
        replay.as_ref().is_some_and(|replay| !replay.running)
    }));
    let shown = replay.unwrap().rehearsal;
    // The only recording is being written.
    assert_eq!((shown.recordings, shown.skipped.len(), shown.grasps.len()), (0, 1, 0));
    assert_eq!(shown.skipped[0], "no recording has ended here that could be replayed");
    assert_eq!(ask(&session, &who, &Order::Notify).unwrap().in_force.name, "default");
    pair.stop();
}
