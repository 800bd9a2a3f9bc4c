//! Roll-outs of one gripper, their pauses and their ends, over starts of its gripfleet.

use super::{Entry, History, MOST, ModelId, Origin, reason};
use crate::{
    deploy::{How, Models, Offer, Order, Put, digest},
    rollout::{Compared, Finished, Grasp},
};
use grip_link::message::FaultCode;
use grip_session::model::default_text;
use std::path::Path;

fn open(folder: &Path) -> Models {
    let sha256 = digest(default_text().as_bytes());
    let mut models = Models::open(folder, ModelId { name: "file".to_owned(), sha256 }).unwrap();
    models.set_utc(5);
    models
}

fn offer(spaces: usize, stage: u32) -> Offer {
    let bytes: Box<[u8]> = (default_text().to_owned() + &" ".repeat(spaces)).into_bytes().into();
    let (name, sha256) = (format!("{spaces}.json"), digest(&bytes));
    Offer {
        name,
        sha256,
        lease_s: 60,
        origin: Origin::new("alice", 17, stage),
        bytes: bytes.into(),
    }
}

/// The next `count` grasps, each compared with a shadow where one is there.
fn grasped(models: &mut Models, number: &mut u64, count: usize) {
    let (in_force_n, shadow_n, slipped_n) = (Some(6.0), Some(6.0), 3.0);
    let compared = Some(Compared { in_force_n, shadow_n, slipped_n, held_n: Some(6.0) });
    for _ in 0..count {
        *number += 1;
        models
            .grasped(&Finished { number: *number, grasp: Grasp { compared, ..Grasp::default() } });
    }
}

fn obey(models: &mut Models, order: Order) -> crate::deploy::Standing {
    models.obey(order, 0, &mut |_: Put<'_>| Ok(0)).unwrap()
}

fn pause() -> Order {
    Order::Pause { by: "bob".to_owned() }
}

#[test]
fn a_paused_gripper_takes_no_model_and_counts_no_grasp_and_goes_on_after_it() {
    let folder = tempfile::tempdir().unwrap();
    let (mut models, mut number) = (open(folder.path()), 0);
    let sha256 = offer(1, 1).sha256;
    obey(&mut models, pause());
    // Neither beside nor in force.
    for order in [Order::Shadow(offer(1, 0)), Order::Take(offer(1, 1))] {
        let standing = obey(&mut models, order);
        assert_eq!((standing.in_force.name.as_str(), standing.shadow), ("file", None));
        assert_eq!(standing.paused.unwrap().by, "bob");
    }
    obey(&mut models, Order::Resume);
    grasped(&mut models, &mut number, 3);
    assert!(obey(&mut models, Order::Take(offer(1, 1))).trial.is_some());
    grasped(&mut models, &mut number, 2);
    obey(&mut models, pause());
    grasped(&mut models, &mut number, 4);
    let watch = Order::Watch { sha256: sha256.clone(), from: 0 };
    let watched = obey(&mut models, watch.clone());
    assert_eq!((watched.grasps.len(), watched.trial.is_some()), (2, true), "it keeps its model");
    obey(&mut models, Order::Resume);
    grasped(&mut models, &mut number, 1);
    let watched = obey(&mut models, watch);
    assert_eq!((watched.grasps.len(), watched.paused), (3, None));
}

#[test]
fn a_pause_keeps_the_lease_and_the_way_back() {
    let folder = tempfile::tempdir().unwrap();
    let mut models = open(folder.path());
    obey(&mut models, Order::Take(offer(1, 1)));
    obey(&mut models, pause());
    models.tick(61_000_000, FaultCode::NONE, &mut |_: Put<'_>| Ok(0));
    let standing = models.standing();
    assert_eq!((standing.trial, standing.last.unwrap().how), (None, How::Unwatched));
    // The model of the configuration is taken in a pause too.
    obey(&mut models, Order::Resume);
    obey(&mut models, Order::Take(offer(2, 1)));
    obey(&mut models, Order::Accept { sha256: offer(2, 1).sha256 });
    obey(&mut models, pause());
    let standing = obey(&mut models, Order::Take(offer(0, 1)));
    assert_eq!(standing.in_force.sha256, digest(default_text().as_bytes()));
    obey(&mut models, Order::Back { sha256: None, why: None });
}

#[test]
fn pause_and_history_survive_a_start() {
    let folder = tempfile::tempdir().unwrap();
    let mut number = 0;
    {
        let mut models = open(folder.path());
        obey(&mut models, Order::Shadow(offer(1, 0)));
        grasped(&mut models, &mut number, 2);
        let why = Some("after 3 grasps with the new model: it is worse".to_owned());
        let back = Order::Back { sha256: Some(offer(1, 0).sha256), why };
        assert_eq!(obey(&mut models, back).shadow, None);
        // From the shadow stage to the end of its trial one entry.
        obey(&mut models, Order::Shadow(offer(2, 0)));
        obey(&mut models, Order::Take(offer(2, 3)));
        grasped(&mut models, &mut number, 4);
        models.set_utc(9);
        let sha256 = offer(2, 0).sha256;
        obey(&mut models, Order::Accept { sha256 });
        obey(&mut models, Order::Take(offer(3, 1)));
        let check = obey(&mut models, Order::Check(offer(3, 1)));
        assert_eq!(check.history.len(), 1, "the one that goes on");
        let history = obey(&mut models, Order::History).history;
        assert_eq!((history.len(), history[2].how, history[2].grasps), (3, None, Some(0)));
        obey(&mut models, pause());
    }
    let mut models = open(folder.path());
    assert_eq!(models.standing().paused.unwrap().at_ns, 9);
    assert_eq!(obey(&mut models, Order::Shadow(offer(1, 0))).shadow, None, "it pauses");
    let history = obey(&mut models, Order::History).history;
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
    assert_eq!(history[0].why.as_deref(), Some("after 3 grasps with the new model: it is worse"));
}

#[test]
fn a_history_that_cannot_be_read_costs_no_model() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("history.json"), "{").unwrap();
    let mut models = open(folder.path());
    assert!(format!("{:?}", models.notices()).contains("history.json"));
    obey(&mut models, Order::Take(offer(1, 1)));
    obey(&mut models, Order::Accept { sha256: offer(1, 1).sha256 });
    drop(models);
    assert_eq!(open(folder.path()).standing().in_force.name, "1.json");
}

#[test]
fn the_latest_entries_are_kept_and_texts_are_those_of_a_parameter() {
    let mut history = History::default();
    for begun_ns in 0..=MOST as u64 {
        let model = ModelId { name: "m".to_owned(), sha256: begun_ns.to_string() };
        history.begin(&model, &Origin::default(), None, begun_ns);
    }
    assert_eq!((history.entries.len(), history.entries[0].begun_ns), (MOST, 1));
    assert_eq!(Origin::new("a;b=c\n", 0, 0).by, "a,b,c");
    assert_eq!(reason(&"x".repeat(1000)).len(), 300);
}
