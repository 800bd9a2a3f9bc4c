//! Trials of models: better, worse, given back, interrupted; and what is refused before.

use super::{Declined, Deployment, Ended, How, Lasting, ModelId, Step, digest, examine};
use crate::rollout::{Counts, JudgeConfig, Worse};
use grip_session::model::default_text;

const JUDGE: JudgeConfig = JudgeConfig { factor: 1.5, alpha: 1e-3, watch_s: 60.0 };

fn model(name: &str) -> ModelId {
    ModelId { name: name.to_owned(), sha256: digest(name.as_bytes()) }
}

/// A grasp with each slip.
fn counts(seconds: f64, slips: u64) -> Counts {
    Counts { seconds, slips, faults: 0, grasps: slips }
}

/// A gripper that has run for two minutes with 12 slips, and a model on trial there.
fn on_trial(lasting: Lasting, name: &str) -> Deployment {
    let mut deployment = Deployment::new(model("file"), lasting);
    assert_eq!(deployment.count(counts(120.0, 12)), Step::Stay);
    let taken = deployment.take(model(name), JUDGE);
    assert_eq!(taken, Ok(Step::Swap(Some(model(name)))));
    deployment.swapped(counts(120.0, 12));
    deployment
}

fn last(deployment: &Deployment) -> Option<(String, How)> {
    deployment.standing().last.map(|Ended { model, how }| (model.name, how))
}

#[test]
fn a_model_that_is_as_good_stays_and_gives_way_when_somebody_asks() {
    let mut deployment = on_trial(Lasting::default(), "a");
    let standing = deployment.standing();
    assert_eq!((standing.in_force, standing.before), (model("a"), Some(model("file"))));
    assert_eq!(standing.trial.unwrap().before, counts(120.0, 12));
    assert_eq!(standing.counted, Counts::default());
    assert_eq!(deployment.count(counts(150.0, 15)), Step::Stay);
    assert!(deployment.standing().trial.is_some());
    assert_eq!(deployment.count(counts(181.0, 18)), Step::Stay);
    assert!(deployment.standing().trial.is_none());
    assert_eq!(last(&deployment), Some(("a".to_owned(), How::Accepted)));
    assert_eq!(deployment.lasting().accepted, Some(model("a")));
    // What comes later is no trial any more.
    assert_eq!(deployment.count(counts(200.0, 500)), Step::Stay);
    assert_eq!(deployment.back(Some(&model("other").sha256)), Step::Stay);
    assert_eq!(deployment.back(Some(&model("a").sha256)), Step::Swap(None));
    assert_eq!(last(&deployment), Some(("a".to_owned(), How::Told)));
    assert_eq!(deployment.back(Some(&model("a").sha256)), Step::Stay, "told twice");
}

#[test]
fn a_model_that_is_worse_goes_by_itself() {
    for (now, worse) in [
        (counts(140.0, 40), Worse::Slips),
        (Counts { seconds: 140.0, slips: 13, faults: 9, grasps: 13 }, Worse::Faults),
    ] {
        let mut deployment = on_trial(Lasting::default(), "a");
        assert_eq!(deployment.count(now), Step::Swap(None));
        deployment.swapped(now);
        let standing = deployment.standing();
        assert_eq!((standing.in_force, standing.before), (model("file"), None));
        assert_eq!(standing.counted, counts(120.0, 12), "it goes on where it was");
        assert_eq!(last(&deployment), Some(("a".to_owned(), How::Worse(worse))));
        assert_eq!(*deployment.lasting(), Lasting { last: standing.last, ..Lasting::default() });
    }
}

#[test]
fn a_model_with_which_nothing_was_grasped_goes_back() {
    let mut deployment = on_trial(Lasting::default(), "a");
    let held = Counts { seconds: 181.0, ..counts(120.0, 12) };
    assert_eq!(deployment.count(held), Step::Swap(None));
    assert_eq!(last(&deployment), Some(("a".to_owned(), How::Idle)));
    assert_eq!(deployment.lasting().accepted, None);
}

/// In the first seconds of a trial, with nothing counted, and when the trial is over: each time to the model before.
#[test]
fn the_way_back_is_always_open() {
    let mut deployment = on_trial(Lasting::default(), "a");
    deployment.count(counts(181.0, 18));
    deployment.take(model("b"), JUDGE).unwrap();
    assert_eq!(deployment.back(None), Step::Swap(Some(model("a"))));
    assert_eq!(deployment.back(None), Step::Swap(None));
    assert_eq!(deployment.back(None), Step::Stay, "this is the model of the configuration");
}

#[test]
fn a_daemon_that_starts_again_during_the_trial_has_the_model_of_before() {
    let mut first = on_trial(Lasting::default(), "a");
    first.count(counts(200.0, 20));
    let mut second = on_trial(first.lasting().clone(), "b");
    assert_eq!(second.standing().before, Some(model("a")));
    let mut third = Deployment::new(model("file"), second.lasting().clone());
    assert_eq!(third.wanted(), Some(&model("a")), "accepted before");
    assert_eq!(last(&third), Some(("b".to_owned(), How::Restarted)));
    assert_eq!(third.count(counts(3600.0, 900)), Step::Stay, "no trial");
    // The whole trial in the second run: then it survives.
    second.count(counts(181.0, 20));
    let third = Deployment::new(model("file"), second.lasting().clone());
    assert_eq!((third.wanted(), third.standing().before), (Some(&model("b")), Some(model("a"))));
}

#[test]
fn an_order_to_give_back_ends_the_trial() {
    let mut deployment = on_trial(Lasting::default(), "a");
    assert_eq!(deployment.back(Some(&model("a").sha256)), Step::Swap(None));
    deployment.swapped(counts(120.0, 12));
    assert_eq!(last(&deployment), Some(("a".to_owned(), How::Told)));
    assert_eq!(deployment.count(counts(130.0, 100)), Step::Stay, "no trial");
}

#[test]
fn other_settings_during_the_trial_end_it() {
    let mut deployment = on_trial(Lasting::default(), "a");
    assert_eq!(deployment.reloaded(model("file 2")), Step::Swap(None));
    deployment.swapped(counts(120.0, 12));
    assert_eq!(deployment.standing().in_force, model("file 2"));
    assert_eq!(last(&deployment), Some(("a".to_owned(), How::Reloaded)));
    // Outside of a trial they only begin the counts anew.
    deployment.count(counts(300.0, 30));
    assert_eq!(deployment.reloaded(model("file")), Step::Stay);
    let early = deployment.take(model("b"), JUDGE).unwrap_err();
    assert_eq!(early, Declined::TooEarly { counted_s: 0, watch_s: 60 });
}

#[test]
fn one_trial_at_a_time_and_none_of_what_is_in_force() {
    let mut deployment = on_trial(Lasting::default(), "a");
    assert_eq!(deployment.take(model("a"), JUDGE), Ok(Step::Stay), "asked twice");
    assert_eq!(deployment.take(model("b"), JUDGE), Err(Declined::OnTrial(model("a"))));
    let mut fresh = Deployment::new(model("file"), Lasting::default());
    assert_eq!(fresh.take(model("file"), JUDGE), Ok(Step::Stay));
    let reported = fresh.take(model("a"), JUDGE).unwrap_err().to_string();
    assert!(reported.starts_with("there are only 0 s with an object"), "{reported}");
    let never = JudgeConfig { watch_s: f64::NAN, ..JUDGE };
    assert_eq!(fresh.take(model("a"), never), Err(Declined::Judge));
    assert_eq!(*fresh.lasting(), Lasting::default());
}

#[test]
fn what_cannot_be_put_in_force_is_on_no_trial() {
    let mut deployment = Deployment::new(model("file"), Lasting::default());
    deployment.count(counts(120.0, 12));
    deployment.take(model("a"), JUDGE).unwrap();
    deployment.failed();
    assert_eq!(
        (deployment.wanted(), last(&deployment)),
        (None, Some(("a".to_owned(), How::Failed)))
    );
    assert_eq!(deployment.standing().counted, counts(120.0, 12), "nothing has changed");
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
