//! Twenty simulated grippers with one router on loopback, each with its models on disk and grasps that are played with the model in force: whole
//! objects are lifted slowly, each grasp another one. A model that is worse is stopped as a shadow, and without that stage gets no further than
//! the first; what is no model for
//! them is refused by each; one that is as good reaches all.
//!
//! A model that asks for 23 % less force than is right passes the self-test, whose bounds are wider. gripd makes up for it while an object
//! slides on, which takes 10 mm instead of 0.5. These fingers end after 6 mm, so most objects fall, which the gripper reports as a fault.
#![expect(clippy::unwrap_used, clippy::panic, reason = "test code")]

use core::{
    sync::atomic::{AtomicBool, AtomicU64, Ordering},
    time::Duration,
};
use grip_fleet::{
    EventLog, Member, Part, Uid,
    deploy::{Examined, How, ModelId, Models, Offer, Order, Origin, Put, digest},
    net::{self, Announced, Deployer, Happening, NetError, Network, Question, Session, standing},
    rollout::{Finished, Grasp, Progress, Rehearsal, Report, RolloutConfig, Stop, Worse, Wrong},
};
use grip_link::message::FaultCode;
use grip_session::{
    HostEstimator,
    model::{default_estimator, default_text},
};
use grip_sim::Scene;
use hand::{grasp, scaled};
use std::{
    collections::{BTreeMap, BTreeSet},
    net::TcpListener,
    path::Path,
    sync::{Arc, Mutex},
    thread,
};

mod hand;

const GRIPPERS: u8 = 20;
/// Grasps before the first roll-out, and of a stage.
const BEFORE: usize = 80;
const GRASPS: usize = 20;
/// Objects; each gripper begins with another one.
const OBJECTS: u64 = 60;
const PATIENCE: Duration = Duration::from_secs(120);
const SCENE: &str = include_str!("../examples/rollouts/slow_lift.toml");

/// Grasps that were played, by models and object.
type Played = Mutex<BTreeMap<(String, Option<String>, u64), Grasp>>;

/// A gripper with its daemon's part of this.
struct Hand {
    announced: Announced,
    _session: Session,
    models: Models,
    estimator: HostEstimator,
    shadow: Option<Examined>,
    number: u64,
    seed: u64,
    scene: Scene,
    member: Member,
    had: Arc<Had>,
    played: Arc<Played>,
    now_us: Arc<AtomicU64>,
}

fn member(number: u8) -> Member {
    Member { site: "hall".parse().unwrap(), uid: Uid([number; 16]) }
}

impl Hand {
    fn new(folder: &Path, network: &Network, number: u8, common: &Common) -> Self {
        let (session, member) = (network.open().unwrap(), member(number));
        let sha256 = digest(default_text().as_bytes());
        let configured = ModelId { name: "default".to_owned(), sha256 };
        let folder = folder.join(member.uid.to_string());
        Self {
            announced: Announced::new(&session, &member, &[Part::Model]).unwrap(),
            _session: session,
            models: Models::open(&folder, configured).unwrap(),
            estimator: default_estimator().unwrap(),
            shadow: None,
            number: 0,
            seed: 7 * u64::from(number),
            scene: Scene::from_toml(SCENE).unwrap(),
            member,
            had: Arc::clone(&common.had),
            played: Arc::clone(&common.played),
            now_us: Arc::clone(&common.now_us),
        }
    }

    /// One more object. Who has enough to compare with and is on no trial rests, so that the others have the processor.
    fn work(&mut self) {
        let standing = self.models.standing();
        if standing.trial.is_none() && self.shadow.is_none() && standing.grasped >= BEFORE {
            return thread::park_timeout(Duration::from_millis(20));
        }
        self.seed += 1;
        let shadow = self.shadow.as_ref().map(|model| model.id.sha256.clone());
        let key = (standing.in_force.sha256, shadow, self.seed % OBJECTS);
        let known = self.played.lock().unwrap().get(&key).copied();
        let grasp = known.unwrap_or_else(|| {
            // The gripper holds each object, or loses it.
            let shadow = self.shadow.as_ref().map(|model| &model.estimator);
            grasp(&self.scene, key.2, &self.estimator, shadow, 2).unwrap().unwrap()
        });
        thread::park_timeout(Duration::from_millis(2));
        self.played.lock().unwrap().insert(key, grasp);
        self.number += 1;
        self.models.grasped(&Finished { number: self.number, grasp });
        let now_us = self.now_us.load(Ordering::Relaxed);
        let (had, member, number) = (&self.had, &self.member, self.number);
        let (estimator, shadow) = (&mut self.estimator, &mut self.shadow);
        self.models.tick(now_us, FaultCode::NONE, &mut |to| {
            put(to, estimator, shadow, had, member);
            Ok(number)
        });
    }

    fn answer(&mut self) {
        let log = EventLog::new(1, 1 << 16);
        self.announced.answer(&|use_it| use_it(&log), &[[0; 0]; 0], "");
        while let Some(question) = self.announced.question() {
            self.obey(&question);
        }
    }

    fn obey(&mut self, question: &Question) {
        let order = Order::read(|name| question.parameter(name), question.payload()).unwrap();
        let Self { models, estimator, shadow, had, member, number, now_us, .. } = self;
        let obeyed = models.obey(order, now_us.load(Ordering::Relaxed), &mut |to| {
            put(to, estimator, shadow, had, member);
            Ok(*number)
        });
        // These grippers record nothing.
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

fn put(
    to: Put<'_>,
    estimator: &mut HostEstimator,
    shadow: &mut Option<Examined>,
    had: &Had,
    member: &Member,
) {
    let model = match to {
        Put::InForce(model) => model,
        Put::Beside(model) => {
            *shadow = model.cloned();
            return;
        }
    };
    *estimator = model.map_or_else(|| default_estimator().unwrap(), |new| new.estimator.clone());
    if let Some(model) = model {
        had.lock().unwrap().insert((member.clone(), model.id.sha256.clone()));
    }
}

/// A roll-out to its end, with so many grasps in the shadow stage: the stages it went through, and what was reported.
fn roll_out(
    session: &Session,
    text: &str,
    shadow: Option<usize>,
) -> (Deployer, BTreeSet<usize>, Vec<Happening>) {
    let (grasps, silence_us) = (Some(GRASPS), 600_000_000);
    let config = RolloutConfig { grasps, shadow, silence_us, ..RolloutConfig::default() };
    let offer = Offer::new("model.json".to_owned(), text.as_bytes().to_vec(), 3600);
    let members = (0..GRIPPERS).map(member);
    let mut deployer = Deployer::new(session.clone(), config, offer, members, PATIENCE);
    let (mut stages, mut reported) = (BTreeSet::new(), Vec::new());
    for now in 0..100_000 {
        reported.extend(deployer.turn(&|| 100_000 * now));
        match deployer.progress() {
            Progress::Stage(stage) => stages.insert(stage),
            Progress::Replay
            | Progress::Shadow
            | Progress::Checking
            | Progress::Accepting
            | Progress::Stopped(1..) => true,
            Progress::Done | Progress::Stopped(0) => break,
        };
        thread::park_timeout(Duration::from_millis(50));
    }
    (deployer, stages, reported)
}

/// Who has which model in force.
fn in_force(session: &Session) -> BTreeSet<String> {
    let ask = |number| standing(session, &member(number), &Order::Notify, PATIENCE).unwrap();
    (0..GRIPPERS).map(|number| ask(number).in_force.sha256).collect()
}

/// What each of them states to a model that is none for it; none of them takes it.
fn refusals(session: &Session, text: &str, sha256: &str) -> Vec<String> {
    let (name, bytes) = ("model.json".to_owned(), text.as_bytes().into());
    let order = Order::Take(Offer {
        name,
        sha256: sha256.to_owned(),
        lease_s: 3600,
        origin: Origin::default(),
        bytes,
    });
    let refused = |number| match standing(session, &member(number), &order, PATIENCE) {
        Err(NetError::Declined { reason, .. }) => reason,
        other => panic!("{number}: {other:?}"),
    };
    (0..GRIPPERS).map(refused).collect()
}

type Had = Mutex<BTreeSet<(Member, String)>>;

/// What all grippers share: who had which model, grasps that were played, and the time.
#[derive(Default)]
struct Common {
    had: Arc<Had>,
    played: Arc<Played>,
    now_us: Arc<AtomicU64>,
}

fn check(session: &Session, common: &Common) {
    let had = &common.had;
    check_none(session, had);
    check_worse(session, had);
    check_better(session);
    check_back(session);
    check_lease(session, common);
}

/// What is no model for them: each states why, also in a roll-out, before anybody has it.
fn check_none(session: &Session, had: &Had) {
    let default = digest(default_text().as_bytes());
    let text = default_text();
    let corrupt = text.replacen("4.3647456", "4.3647457", 1);
    let reported = refusals(session, &corrupt, &default);
    assert!(
        reported.iter().all(|reported| reported.starts_with("what came is not what was ordered"))
    );
    let foreign = text.replacen("slip_acceleration_m_s2", "temperature_k", 1);
    let reported = refusals(session, &foreign, &digest(foreign.as_bytes()));
    assert!(
        reported
            .iter()
            .all(|reported| reported.contains("`temperature_k` is no feature of a slip"))
    );
    assert_eq!((reported.len(), in_force(session)), (20, BTreeSet::from([default])));
    let (stopped, stages, reported) = roll_out(session, &foreign, None);
    assert!(matches!(stopped.stopped(), Some(Stop::Refused { .. })), "{reported:?}");
    let refused =
        |happening: &&Happening| matches!(happening, Happening::Reported(_, Report::Refused(_)));
    assert_eq!(
        (reported.iter().filter(refused).count(), reported.len(), stages.len()),
        (20, 20, 0)
    );
    assert_eq!(stopped.progress(), Progress::Stopped(0));
    assert!(had.lock().unwrap().is_empty(), "nobody has swapped");
}

fn check_worse(session: &Session, had: &Had) {
    let worse = scaled(0.77).unwrap();
    let sha256 = digest(worse.as_bytes());
    // As a shadow it is stopped before a finger has moved.
    let (stopped, stages, reported) = roll_out(session, &worse, None);
    let why = stopped.stopped();
    assert!(matches!(why, Some(Stop::Wrong { what: Wrong::Low, .. })), "{why:?} {reported:?}");
    assert_eq!((stopped.progress(), stages.len()), (Progress::Stopped(0), 0));
    let has = |had: &BTreeSet<(Member, String)>| had.iter().any(|(_, sha)| *sha == sha256);
    assert!(!has(&had.lock().unwrap()), "nobody had it in force");
    // Without a shadow stage the first one tries it.
    let (stopped, stages, reported) = roll_out(session, &worse, Some(0));
    let why = stopped.stopped();
    assert!(matches!(why, Some(Stop::Worse { what: Worse::Hold, .. })), "{why:?} {reported:?}");
    assert_eq!(stopped.progress(), Progress::Stopped(0));
    assert_eq!(stages, BTreeSet::from([1]));
    let default = digest(default_text().as_bytes());
    assert_eq!(in_force(session), BTreeSet::from([default]));
    let got: Vec<Member> = had
        .lock()
        .unwrap()
        .iter()
        .filter(|(_, sha)| *sha == sha256)
        .map(|(who, _)| who.clone())
        .collect();
    assert_eq!(got, [member(0)], "the others never had it");
}

fn check_better(session: &Session) {
    let better = scaled(1.02).unwrap();
    let (done, stages, reported) = roll_out(session, &better, None);
    let (wanted, tally) = done.shadow();
    assert!(wanted >= 10 && tally.grasps >= wanted, "{wanted} {tally}");
    assert_eq!((done.stopped(), done.progress()), (None, Progress::Done), "{reported:?}");
    assert_eq!(stages, BTreeSet::from([1, 2, 3]));
    assert_eq!(in_force(session), BTreeSet::from([digest(better.as_bytes())]));
    let taken =
        |happening: &&Happening| matches!(happening, Happening::Reported(_, Report::Taken(_)));
    assert_eq!(reported.iter().filter(taken).count(), 20);
}

/// The model of the configuration is deployed as any other one, and needs no trial.
fn check_back(session: &Session) {
    let (done, stages, reported) = roll_out(session, default_text(), None);
    assert_eq!((done.stopped(), done.progress()), (None, Progress::Done), "{reported:?}");
    assert_eq!((stages.last(), done.grasps()), (Some(&1), None));
    assert_eq!(in_force(session), BTreeSet::from([digest(default_text().as_bytes())]));
}

/// The program of the operator ends in a trial: the gripper goes back by itself, and one that is started in time takes the roll-out up again.
fn check_lease(session: &Session, common: &Common) {
    let text = scaled(1.01).unwrap();
    let ask = || standing(session, &member(0), &Order::Notify, PATIENCE).unwrap();
    while ask().grasped < BEFORE {
        thread::park_timeout(Duration::from_millis(50));
    }
    let begin = || {
        let offer = Offer::new("model.json".to_owned(), text.as_bytes().to_vec(), 3600);
        let (grasps, shadow) = (Some(GRASPS), Some(0));
        let replay = false;
        let config = RolloutConfig { grasps, replay, shadow, ..RolloutConfig::default() };
        let mut deployer = Deployer::new(session.clone(), config, offer, [member(0)], PATIENCE);
        (0..3).for_each(|_| drop(deployer.turn(&|| 0)));
        assert_eq!(deployer.holding().count(), 1);
    };
    begin();
    common.now_us.store(3_000_000_000, Ordering::Relaxed);
    begin();
    common.now_us.store(6_500_000_000, Ordering::Relaxed);
    thread::park_timeout(Duration::from_millis(500));
    assert!(ask().trial.is_some(), "watched 3500 s ago");
    common.now_us.store(6_601_000_000, Ordering::Relaxed);
    while ask().trial.is_some() {
        thread::park_timeout(Duration::from_millis(50));
    }
    let standing = ask();
    assert_eq!(standing.last.unwrap().how, How::Unwatched);
    assert_eq!(standing.in_force.sha256, digest(default_text().as_bytes()));
}

#[test]
fn a_worse_model_stops_at_the_first_a_wrong_one_is_refused_by_each_and_a_good_one_reaches_all() {
    let folder = tempfile::tempdir().unwrap();
    let port = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
    let endpoint = format!("tcp/127.0.0.1:{port}");
    let network = Network { router: Some(endpoint), file: None };
    let _router = net::router(&network).unwrap();
    let (over, ready, common) = (AtomicBool::new(false), Mutex::new(0), Common::default());
    thread::scope(|scope| {
        let hands: Vec<_> =
            (0..GRIPPERS).map(|n| Hand::new(folder.path(), &network, n, &common)).collect();
        for mut hand in hands {
            let (over, ready) = (&over, &ready);
            let work = move || {
                while hand.models.standing().grasped < BEFORE {
                    hand.work();
                }
                *ready.lock().unwrap() += 1;
                while !over.load(Ordering::Relaxed) {
                    hand.answer();
                    hand.work();
                }
            };
            scope.spawn(work);
        }
        while *ready.lock().unwrap() < GRIPPERS {
            thread::park_timeout(Duration::from_millis(50));
        }
        let session = network.open().unwrap();
        let checked =
            std::panic::catch_unwind(core::panic::AssertUnwindSafe(|| check(&session, &common)));
        over.store(true, Ordering::Relaxed);
        if let Err(panic) = checked {
            std::panic::resume_unwind(panic);
        }
    });
}
