//! Trials of models: kept, given back, left alone, interrupted; and what is refused before.

use super::{Declined, Deployment, Ended, How, Lasting, ModelId, Step, digest, examine};
use crate::rollout::{Finished, Grasp};
use grip_link::message::FaultCode;
use grip_session::model::default_text;

const SECOND: u64 = 1_000_000;
const LEASE_S: u32 = 60;

fn model(name: &str) -> ModelId {
    ModelId { name: name.to_owned(), sha256: digest(name.as_bytes()) }
}

/// Some grasps, of these numbers.
fn grasped(deployment: &mut Deployment, numbers: core::ops::RangeInclusive<u64>) {
    let grasp = Grasp::default();
    numbers.for_each(|number| deployment.grasped(&Finished { number, grasp }));
}

/// A gripper that has made twelve grasps, and a model on trial there from 0 s on.
fn on_trial(lasting: Lasting, name: &str) -> Deployment {
    let mut deployment = Deployment::new(model("file"), lasting);
    grasped(&mut deployment, 1..=12);
    let taken = deployment.take(model(name), LEASE_S, 0);
    assert_eq!(taken, Ok(Step::Swap(Some(model(name)))));
    deployment.swapped(13);
    deployment
}

fn accepted(name: &str) -> Deployment {
    let mut deployment = on_trial(Lasting::default(), name);
    deployment.accept(&model(name).sha256, 0).unwrap();
    deployment
}

fn last(deployment: &Deployment) -> Option<(String, How)> {
    deployment.standing().last.map(|Ended { model, how }| (model.name, how))
}

#[test]
fn a_model_on_trial_has_grasps_of_its_own_and_stays_when_it_is_accepted() {
    let mut deployment = on_trial(Lasting::default(), "a");
    let standing = deployment.standing();
    assert_eq!((standing.in_force, standing.before), (model("a"), Some(model("file"))));
    assert_eq!((standing.trial.unwrap().before, standing.grasped), (12, 0));
    // One that had begun before counts for neither.
    grasped(&mut deployment, 13..=18);
    assert_eq!((deployment.grasps(0).len(), deployment.grasps_before().len()), (5, 12));
    assert_eq!((deployment.grasps(3).len(), deployment.grasps(9).len()), (2, 0));
    let sha256 = model("a").sha256;
    deployment.accept(&sha256, 0).unwrap();
    deployment.accept(&sha256, 0).unwrap();
    assert_eq!((deployment.standing().trial, deployment.standing().grasped), (None, 5));
    assert_eq!(last(&deployment), Some(("a".to_owned(), How::Accepted)));
    assert_eq!(deployment.lasting().accepted, Some(model("a")));
    // Nobody needs to watch it any more.
    assert_eq!(deployment.tick(9999 * SECOND, FaultCode::NONE), Step::Stay);
    assert_eq!(deployment.back(Some(&model("other").sha256)), Step::Stay);
    assert_eq!(deployment.back(Some(&sha256)), Step::Swap(None));
    assert_eq!(last(&deployment), Some(("a".to_owned(), How::Ordered)));
    assert_eq!(deployment.back(Some(&sha256)), Step::Stay, "asked twice");
}

/// The program of the operator was killed.
#[test]
fn a_model_that_nobody_watches_goes_by_itself() {
    let mut deployment = on_trial(Lasting::default(), "a");
    let sha256 = model("a").sha256;
    let none = FaultCode::NONE;
    for second in [50, 100, 150] {
        assert_eq!(deployment.tick(second * SECOND, none), Step::Stay);
        deployment.watch(&sha256, second * SECOND).unwrap();
    }
    assert!(deployment.watch(&model("b").sha256, 200 * SECOND).is_err(), "another one is no watch");
    assert_eq!(deployment.tick(210 * SECOND, none), Step::Stay);
    // An order to take it again is one.
    assert_eq!(deployment.take(model("a"), LEASE_S, 210 * SECOND), Ok(Step::Stay));
    assert_eq!(deployment.tick(270 * SECOND, none), Step::Stay);
    assert_eq!(deployment.tick(271 * SECOND, none), Step::Swap(None));
    deployment.swapped(20);
    assert_eq!(deployment.standing().grasped, 12, "it goes on where it was");
    let why = deployment.accept(&sha256, 271 * SECOND).unwrap_err();
    assert_eq!(why, Declined::NoTrial(Some(How::Unwatched)));
    assert_eq!(
        why.to_string(),
        "that model is not on trial here: nobody watched its trial any more"
    );
    assert_eq!(last(&deployment), Some(("a".to_owned(), How::Unwatched)));
    let standing = deployment.standing();
    assert_eq!(*deployment.lasting(), Lasting { last: standing.last, ..Lasting::default() });
}

/// In the first seconds of a trial, without a single grasp, and when the trial is over: each time to the model before.
#[test]
fn the_way_back_is_always_open() {
    let mut deployment = accepted("a");
    deployment.take(model("b"), LEASE_S, 0).unwrap();
    assert_eq!(deployment.back(None), Step::Swap(Some(model("a"))));
    assert_eq!(deployment.back(None), Step::Swap(None));
    assert_eq!(deployment.back(None), Step::Stay, "this is the model of the configuration");
}

/// Deployed as any other, in FAULT and without a grasp: a bad model does not lock itself in.
#[test]
fn the_models_of_the_configuration_and_before_need_no_trial() {
    for (first, wanted, step) in [
        ("a", "file", Step::Swap(None)),
        ("b", "file", Step::Swap(None)),
        ("b", "a", Step::Swap(Some(model("a")))),
    ] {
        let mut deployment = accepted("a");
        if first == "b" {
            deployment.take(model("b"), LEASE_S, 0).unwrap();
            deployment.swapped(14);
            deployment.accept(&model("b").sha256, 0).unwrap();
        }
        deployment.tick(0, FaultCode::OBJECT_LOST);
        assert_eq!(deployment.take(model(wanted), LEASE_S, 0), Ok(step));
        let standing = deployment.standing();
        assert_eq!((standing.in_force, standing.trial), (model(wanted), None));
    }
}

#[test]
fn a_gripper_in_fault_tries_nothing() {
    let mut deployment = Deployment::new(model("file"), Lasting::default());
    deployment.tick(0, FaultCode::OBJECT_LOST);
    let reported = deployment.check(&model("a"), LEASE_S).unwrap_err().to_string();
    assert_eq!(reported, "this gripper has latched fault 0201, and nothing can be tried on it");
    deployment.tick(0, FaultCode::NONE);
    assert_eq!(deployment.check(&model("a"), LEASE_S), Ok(true));
}

#[test]
fn a_daemon_that_starts_again_during_the_trial_has_the_model_of_before() {
    let first = accepted("a");
    let mut second = on_trial(first.lasting().clone(), "b");
    assert_eq!(second.standing().before, Some(model("a")));
    let third = Deployment::new(model("file"), second.lasting().clone());
    assert_eq!(third.wanted(), Some(&model("a")), "accepted before");
    assert_eq!(last(&third), Some(("b".to_owned(), How::Restarted)));
    // The whole trial in the second run: then it survives.
    second.accept(&model("b").sha256, 0).unwrap();
    let third = Deployment::new(model("file"), second.lasting().clone());
    assert_eq!((third.wanted(), third.standing().before), (Some(&model("b")), Some(model("a"))));
}

#[test]
fn other_settings_during_the_trial_end_it() {
    let mut deployment = on_trial(Lasting::default(), "a");
    assert_eq!(deployment.reloaded(model("file 2")), Step::Swap(None));
    deployment.swapped(13);
    assert_eq!(deployment.standing().in_force, model("file 2"));
    assert_eq!(last(&deployment), Some(("a".to_owned(), How::Reloaded)));
    // Grasps with other settings are nothing to compare with.
    assert_eq!(deployment.standing().grasped, 0);
    grasped(&mut deployment, 14..=15);
    assert_eq!(deployment.reloaded(model("file")), Step::Stay);
    assert_eq!(deployment.standing().grasped, 0);
}

#[test]
fn one_trial_at_a_time_and_none_of_what_is_in_force() {
    let mut deployment = on_trial(Lasting::default(), "a");
    assert_eq!(deployment.take(model("a"), LEASE_S, 0), Ok(Step::Stay), "asked twice");
    assert_eq!(deployment.take(model("b"), LEASE_S, 0), Err(Declined::OnTrial(model("a"))));
    let mut fresh = Deployment::new(model("file"), Lasting::default());
    assert_eq!(fresh.take(model("file"), LEASE_S, 0), Ok(Step::Stay));
    assert_eq!(fresh.take(model("a"), 0, 0), Err(Declined::Lease(0)));
    assert_eq!(*fresh.lasting(), Lasting::default());
}

#[test]
fn what_cannot_be_put_in_force_is_on_no_trial() {
    let mut deployment = Deployment::new(model("file"), Lasting::default());
    grasped(&mut deployment, 1..=3);
    deployment.take(model("a"), LEASE_S, 0).unwrap();
    deployment.failed();
    assert_eq!(
        (deployment.wanted(), last(&deployment)),
        (None, Some(("a".to_owned(), How::Failed)))
    );
    assert_eq!(deployment.standing().grasped, 3, "nothing has changed");
}

/// A long run keeps the latest grasps, a long trial the first ones.
#[test]
fn grasps_are_kept_up_to_a_thousand() {
    let mut deployment = Deployment::new(model("file"), Lasting::default());
    let numbered = |number: u64| {
        let regrasps = u32::try_from(number).unwrap();
        Finished { number, grasp: Grasp { regrasps, ..Grasp::default() } }
    };
    (1..=1500).for_each(|number| deployment.grasped(&numbered(number)));
    assert_eq!((deployment.grasps(0).len(), deployment.grasps(0)[0].regrasps), (1000, 501));
    deployment.take(model("a"), LEASE_S, 0).unwrap();
    deployment.swapped(1500);
    (1501..=3000).for_each(|number| deployment.grasped(&numbered(number)));
    assert_eq!((deployment.grasps(0).len(), deployment.grasps(0)[0].regrasps), (1000, 1501));
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
    let unit = with(
        "\"adequate_force_n\",\n      \"unit\": \"N\"",
        "\"adequate_force_n\",\n      \"unit\": \"lbf\"",
    );
    assert!(unit.contains("`lbf`, not a force in N"), "{unit}");
    let feature = with("slip_acceleration_m_s2", "temperature_k");
    assert!(feature.contains("temperature_k"), "{feature}");
    let version = with("\"version\": 1", "\"version\": 2");
    assert!(version.contains("has version 2"), "{version}");
    let kind = with("mlp-model", "tree-model");
    assert!(kind.contains("of the kind tree-model"), "{kind}");
}

#[test]
fn a_model_that_does_not_know_the_force_fails_the_self_test() {
    let wrong = with("0.8985352", "0.5");
    assert!(
        wrong.starts_with("m.json fails the self-test: half of its answers are off"),
        "{wrong}"
    );
    let paper = grip_session::model::built_in(std::path::Path::new("paper")).unwrap();
    assert!(refused(paper.as_bytes()).contains("fails the self-test"));
    let good =
        examine("../a b/m.json", &digest(default_text().as_bytes()), default_text().as_bytes());
    assert_eq!(good.unwrap().id.name, "..abm.json");
}
