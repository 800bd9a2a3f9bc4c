//! Roll-outs to simulated grippers whose grasps depend on the model.

use super::{
    Compared, Grasp, JudgeConfig, Order, Progress, Rehearsal, Report, Rollout, RolloutConfig, Stop,
    Tally, Worse, Wrong,
};
use crate::key::Member;
use grip_session::config::Uid;
use std::collections::BTreeMap;

const SECOND: u64 = 1_000_000;
const CONFIG: RolloutConfig = RolloutConfig {
    some: 0.2,
    judge: JudgeConfig { alpha: 0.05, margin: 1.2 },
    difference: super::Difference { lost: 0.1, force: 1.5 },
    grasps: Some(20),
    replay: false,
    shadow: Some(0),
    silence_us: 60 * SECOND,
    idle_us: 3600 * SECOND,
};

fn members(count: u8) -> Vec<Member> {
    let site: grip_session::config::Site = "hall".parse().unwrap();
    (0..count).map(|n| Member { site: site.clone(), uid: Uid([n; 16]) }).collect()
}

/// The n-th grasp of a gripper; of the model of before one of 50 is lost.
fn grasp(n: usize, is_lost: bool) -> Grasp {
    let slip_mm = 0.5 + 0.1 * (n * 7 % 10) as f32;
    Grasp {
        lost: is_lost || n % 50 == 7,
        regrasps: 1,
        slip_mm,
        force_ratio: Some(1.0 + 0.1 * slip_mm),
        compared: None,
    }
}

fn before() -> Vec<Grasp> {
    (0..100).map(|n| grasp(n, false)).collect()
}

/// Grippers, each with 100 grasps before; with the new model every n-th grasp is lost, none for 0.
struct Plant {
    rollout: Rollout,
    now_us: u64,
    new: BTreeMap<Member, usize>,
    most: usize,
    lost_every: usize,
}

impl Plant {
    fn new(count: u8, lost_every: usize) -> Self {
        let rollout = Rollout::new(CONFIG, members(count));
        Self { rollout, now_us: 0, new: BTreeMap::new(), most: 0, lost_every }
    }

    fn obey(&mut self, orders: impl IntoIterator<Item = (Member, Order)>) {
        for (member, order) in orders {
            let report = match order {
                Order::Check => Report::Fit(before()),
                Order::Replay => Report::Replayed(Rehearsal::default()),
                Order::Shadow => Report::Beside,
                Order::Take => {
                    self.new.insert(member.clone(), 0);
                    Report::Taken(before())
                }
                Order::Accept => Report::Kept,
                Order::GiveBack => {
                    self.new.remove(&member);
                    Report::Back
                }
            };
            self.rollout.receive(&member, report, self.now_us);
            self.most = self.most.max(self.new.len());
        }
    }

    /// Ten seconds, and one grasp more of each.
    fn turn(&mut self) {
        loop {
            let orders = self.rollout.step();
            if orders.is_empty() {
                break;
            }
            self.obey(orders);
        }
        self.now_us += 10 * SECOND;
        // What is made in a pause is asked for again, and not played here.
        if !self.rollout.paused().is_empty() {
            return;
        }
        for (member, from) in self.new.clone() {
            let is_lost = self.lost_every > 0 && from % self.lost_every == 0;
            let grasps = vec![grasp(from + 11, is_lost)];
            self.new.insert(member.clone(), from + 1);
            self.rollout.receive(&member, Report::Grasps { from, grasps }, self.now_us);
        }
    }

    /// Stages until the end; for each the count of those that have the model.
    fn run(&mut self) -> Vec<usize> {
        let mut stages = Vec::new();
        for _ in 0..300 {
            self.turn();
            if stages.last() != Some(&self.new.len()) {
                stages.push(self.new.len());
            }
        }
        stages
    }
}

#[test]
fn a_good_model_goes_to_one_then_some_then_all() {
    let mut plant = Plant::new(20, 0);
    assert_eq!(plant.run(), [1, 5, 20]);
    assert_eq!(plant.rollout.progress(), Progress::Done);
    assert_eq!((plant.rollout.stopped(), plant.rollout.grasps()), (None, Some(20)));
}

#[test]
fn a_worse_model_stops_at_the_first_and_goes_back() {
    let mut plant = Plant::new(20, 3);
    assert_eq!(plant.run(), [1, 0]);
    assert_eq!((plant.most, plant.rollout.progress()), (1, Progress::Stopped(0)));
    let Some(Stop::Worse { what: Worse::Hold, grasps }) = plant.rollout.stopped() else {
        panic!("{:?}", plant.rollout.stopped())
    };
    let reported = plant.rollout.stopped().unwrap().to_string();
    let wanted = "grasps with the new model: objects are lost, or slip more often or further";
    assert!(*grasps <= 20 && reported.ends_with(wanted), "{reported}");
}

/// Evidence of many grippers adds up where that of none would do.
#[test]
fn grasps_are_judged_together() {
    let mut plant = Plant::new(20, 0);
    while plant.new.len() < 20 {
        plant.turn();
    }
    plant.lost_every = 1;
    plant.turn();
    assert_eq!(plant.rollout.step().len(), 20, "one lost object each");
    assert!(matches!(plant.rollout.stopped(), Some(Stop::Worse { .. })));
}

#[test]
fn who_has_too_few_grasps_to_compare_with_stops_it_before_anybody_has_the_model() {
    let plan = |config: RolloutConfig, has: usize| {
        let mut rollout = Rollout::new(config, members(2));
        rollout.step();
        rollout.receive(&members(2)[0], Report::Fit(before()), 0);
        rollout.receive(&members(2)[1], Report::Fit(before()[..has].to_vec()), 0);
        let orders = rollout.step();
        (rollout.stopped().cloned(), orders.len(), rollout.grasps())
    };
    let few = |has, wanted| Some(Stop::Few { member: members(2).remove(1), has, wanted });
    assert_eq!(plan(CONFIG, 19), (few(19, 20), 0, None));
    assert_eq!(plan(CONFIG, 20), (None, 1, Some(20)));
    assert_eq!(plan(CONFIG, 0), (few(0, 20), 0, None));
    // Where nobody names the number, it is computed from the grasps and the difference.
    let difference = super::Difference { lost: 0.5, ..CONFIG.difference };
    let computed = RolloutConfig { grasps: None, difference, ..CONFIG };
    let (stopped, orders, grasps) = plan(computed, 100);
    assert!(
        stopped.is_none() && orders == 1 && grasps.is_some_and(|grasps| grasps < 100),
        "{grasps:?}"
    );
    let difference = super::Difference { lost: 0.001, ..CONFIG.difference };
    assert_eq!(plan(RolloutConfig { difference, ..computed }, 100).0, Some(Stop::Blind));
}

/// The program of the operator was started again: the grippers on trial are asked as everybody, and go on where they were.
#[test]
fn a_roll_out_is_taken_up_again() {
    let mut plant = Plant::new(3, 0);
    (0..15).for_each(|_| plant.turn());
    assert_eq!(plant.new.len(), 1);
    plant.rollout = Rollout::new(CONFIG, members(3));
    plant.obey(members(3).into_iter().map(|who| (who, Order::Check)));
    let first = members(1).remove(0);
    plant.rollout.step();
    plant.obey(members(3).into_iter().map(|who| (who, Order::Check)));
    assert_eq!(plant.rollout.step(), [(first.clone(), Order::Take)]);
    plant.rollout.receive(&first, Report::Taken(before()), plant.now_us);
    let grasps = (0..15).map(|n| grasp(n, false)).collect();
    plant.rollout.receive(&first, Report::Grasps { from: 0, grasps }, plant.now_us);
    assert_eq!(plant.rollout.known(&first), Some(15));
    // What is known already, or comes after a gap, adds nothing.
    let again = |from| Report::Grasps { from, grasps: vec![grasp(0, false); 2] };
    plant.rollout.receive(&first, again(14), plant.now_us);
    assert_eq!(plant.rollout.known(&first), Some(16));
    plant.rollout.receive(&first, again(18), plant.now_us);
    assert_eq!(plant.rollout.known(&first), Some(16));
}

/// A roll-out to some grippers, each called by its number.
struct Story {
    rollout: Rollout,
    now_us: u64,
}

impl Story {
    /// Everybody was asked whether it would take the model.
    fn new(config: RolloutConfig, count: u8) -> Self {
        let mut rollout = Rollout::new(config, members(count));
        let asked: Vec<_> = members(count).into_iter().map(|who| (who, Order::Check)).collect();
        assert_eq!((rollout.progress(), rollout.step()), (Progress::Checking, asked));
        Self { rollout, now_us: 0 }
    }

    /// Takes words such as `@60 0 silent, all fit`: from 60 s on nothing is reported of the first one.
    fn report(&mut self, words: &str) {
        for word in words.split(", ").filter(|word| !word.is_empty()) {
            let word = match word.strip_prefix('@').and_then(|word| word.split_once(' ')) {
                Some((second, word)) => {
                    self.now_us = SECOND * second.parse::<u64>().unwrap();
                    word
                }
                None => word,
            };
            let (who, what) = word.split_once(' ').unwrap_or((word, ""));
            let all = self.rollout.members.keys().cloned();
            let who: Vec<Member> = match who {
                "all" => all.collect(),
                "stop" => {
                    self.rollout.abort();
                    continue;
                }
                number => vec![members(10).remove(number.parse().unwrap())],
            };
            who.iter().for_each(|who| self.say(who, what));
        }
    }

    fn say(&mut self, who: &Member, what: &str) {
        let (what, reason) = what.split_once(": ").unwrap_or((what, ""));
        let count = |n: usize| Report::Compared { from: 0, grasps: compared(6.0, n) };
        let report = match what {
            "silent" => {
                let reason = Some(reason.to_owned()).filter(|reason| !reason.is_empty());
                return self.rollout.miss(who, reason, self.now_us);
            }
            "fits" => Report::Fit(before()),
            "tries" => Report::Trying(before()),
            "knows" => Report::Known,
            "had" => Report::Had,
            "takes" => Report::Taken(before()),
            "beside" => Report::Beside,
            "compares" => count(reason.parse().unwrap()),
            "replays" => Report::Replaying,
            "replayed" => replayed(6.0, 5),
            "nothing" => Report::Grasps { from: 0, grasps: Vec::new() },
            "enough" => Report::Grasps { from: 0, grasps: before() },
            "keeps" => Report::Kept,
            "back" => Report::Back,
            "refuses" => Report::Refused(reason.to_owned()),
            "leaves" => Report::Left(reason.to_owned()),
            _ => panic!("{what}"),
        };
        self.rollout.receive(who, report, self.now_us);
    }

    /// What is ordered now, of whom, and where the roll-out is.
    fn ordered(&mut self) -> String {
        let mut text = String::new();
        for (who, order) in self.rollout.step() {
            text += &format!("{order:?} {}, ", who.uid.0[0]);
        }
        format!("{text}{:?}", self.rollout.progress())
    }

    /// What is reported, and what is ordered then, step by step.
    #[track_caller]
    fn goes(mut self, steps: &[(&str, &str)]) -> Self {
        for (reported, wanted) in steps {
            self.report(reported);
            assert_eq!(self.ordered(), *wanted, "{reported}");
        }
        self
    }

    /// The reason why it was stopped, with the numbers of the grippers for their names.
    fn why(&self) -> String {
        let text = self.rollout.stopped().map(ToString::to_string).unwrap_or_default();
        members(10).iter().enumerate().fold(text, |text, (number, member)| {
            text.replace(&member.to_string(), &number.to_string())
        })
    }
}

fn story(count: u8) -> Story {
    Story::new(CONFIG, count)
}

#[test]
fn who_would_refuse_it_stops_it_before_anybody_has_it_and_all_are_received() {
    let story = story(4).goes(&[
        ("@1 0 fits, 2 refuses: too early", "Checking"),
        ("@3 3 refuses: too old", "Checking"),
        // The last one never answers.
        ("@2 1 silent", "Checking"),
        ("@62 1 silent", "Checking"),
        ("@63 1 silent", "Stopped(0)"),
    ]);
    assert_eq!(story.why(), "2 refused the model: too early");
    // Whoever stops it waits for nobody who has not said.
    let story = self::story(3).goes(&[("stop", "Stopped(0)"), ("0 fits", "Stopped(0)")]);
    assert_eq!(story.rollout.stopped(), Some(&Stop::Ordered));
}

#[test]
fn a_refusal_stops_it() {
    let steps = [("all fits", "Take 0, Stage(1)"), ("0 refuses: another hash", "Stopped(0)")];
    assert_eq!(story(3).goes(&steps).why(), "0 refused the model: another hash");
}

#[test]
fn silence_stops_it_and_who_comes_back_is_reported_to_give_back() {
    let story = story(3).goes(&[
        ("all fits", "Take 0, Stage(1)"),
        // It answers once, and then states why it cannot.
        ("@1 0 takes, @2 0 silent, @40 0 nothing, @41 0 silent, @101 0 silent", "Stage(1)"),
        ("@102 0 silent: no folder", "GiveBack 0, Stopped(1)"),
        ("@110 0 back", "Stopped(0)"),
    ]);
    assert_eq!(story.why(), "0 has not answered for too long: no folder");
}

/// A turn over many grippers may take longer than patience: whoever answers when asked is there.
#[test]
fn who_was_not_asked_for_long_is_not_gone() {
    let story = story(2).goes(&[
        ("all fits", "Take 0, Stage(1)"),
        ("0 takes, @300 0 nothing", "Stage(1)"),
        // One answer that was lost is none of patience, however late the next question comes.
        ("@400 0 silent", "Stage(1)"),
        ("@600 0 nothing", "Stage(1)"),
        ("@700 0 silent", "Stage(1)"),
        ("@1200 0 nothing, @1300 0 silent", "Stage(1)"),
    ]);
    assert_eq!(story.why(), "");
}

#[test]
fn who_goes_back_by_itself_stops_it_for_all() {
    let mut plant = Plant::new(20, 0);
    while plant.new.len() < 5 {
        plant.turn();
    }
    let fallen = members(3).remove(2);
    plant.new.remove(&fallen);
    let why = "nobody watched its trial any more".to_owned();
    plant.rollout.receive(&fallen, Report::Left(why.clone()), plant.now_us);
    plant.turn();
    assert_eq!((plant.new.len(), plant.rollout.progress()), (0, Progress::Stopped(0)));
    let reported = plant.rollout.stopped().unwrap().to_string();
    assert_eq!(reported, format!("{fallen} has gone back to the model before: {why}"));
}

#[test]
fn nobody_keeps_it_before_everybody_has_tried_it() {
    story(2).goes(&[
        ("all fits", "Take 0, Stage(1)"),
        ("0 takes, 0 enough", "Take 1, Stage(2)"),
        ("1 takes", "Stage(2)"),
        ("1 enough", "Accept 0, Accept 1, Accepting"),
        // The second one does not answer any more: both go back.
        ("0 keeps, @1 1 silent, @62 1 silent", "GiveBack 0, GiveBack 1, Stopped(2)"),
    ]);
}

#[test]
fn who_has_the_model_or_knows_it_needs_no_trial_and_is_not_the_first_to_try_it() {
    // A way back that is deployed: nobody needs a grasp to compare with.
    story(3).goes(&[("all knows", "Take 0, Take 1, Take 2, Stage(1)"), ("all had", "Done")]);
    story(2).goes(&[("all had", "Done")]);
    story(4).goes(&[
        ("0 had, 1 fits, 2 fits, 3 fits", "Take 1, Stage(1)"),
        ("1 takes, 1 enough", "Take 2, Stage(2)"),
        ("2 takes, stop", "GiveBack 1, GiveBack 2, Stopped(2)"),
    ]);
    // It has got it from elsewhere meanwhile: another one is the first to try it, alone.
    story(3).goes(&[
        ("all fits", "Take 0, Stage(1)"),
        ("0 had", "Take 1, Stage(1)"),
        ("1 takes, stop", "GiveBack 1, Stopped(1)"),
        ("1 back", "Stopped(0)"),
    ]);
}

#[test]
fn strangers_and_late_words_change_nothing() {
    story(2).goes(&[("5 refuses: all of it", "Checking"), ("0 nothing", "Checking")]);
    assert_eq!(Rollout::new(CONFIG, []).progress(), Progress::Done);
}

#[test]
fn who_holds_nothing_for_too_long_stops_it_though_it_answers() {
    let mut story = story(2).goes(&[("all fits", "Take 0, Stage(1)"), ("@1 0 takes", "Stage(1)")]);
    for second in 2..=3601 {
        story = story.goes(&[(&format!("@{second} 0 nothing"), "Stage(1)")]);
    }
    let story = story.goes(&[("@3602 0 nothing", "GiveBack 0, Stopped(1)")]);
    assert_eq!(story.why(), "0 has grasped nothing for too long");
}

/// Grasps in which a shadow asked for this force, where 6 N held the object, and 3 N did not.
fn compared(shadow_n: f32, count: usize) -> Vec<Grasp> {
    let (in_force_n, shadow_n, held_n) = (Some(6.0), Some(shadow_n), Some(6.0));
    let compared = Some(Compared { in_force_n, shadow_n, slipped_n: 3.0, held_n });
    vec![Grasp { compared, ..Grasp::default() }; count]
}

/// A roll-out to two grippers that both let the model estimate, for six grasps.
fn beside() -> Story {
    Story::new(RolloutConfig { shadow: Some(6), ..CONFIG }, 2)
        .goes(&[("all fits", "Shadow 0, Shadow 1, Shadow"), ("all beside", "Shadow")])
}

#[test]
fn a_model_is_asked_beside_those_in_force_before_anybody_has_it() {
    let (mut story, both) = (beside(), members(2));
    assert_eq!(story.rollout.holding().count(), 0);
    // What is known already is not counted twice, and what comes after a gap is not taken.
    for (who, from) in [(0, 0), (0, 1), (1, 1)] {
        story.rollout.receive(&both[who], Report::Compared { from, grasps: compared(6.0, 3) }, 1);
    }
    assert_eq!(
        both.iter().map(|who| story.rollout.known(who)).collect::<Vec<_>>(),
        [Some(4), Some(0)]
    );
    assert_eq!((story.ordered().as_str(), story.rollout.shadow().1.grasps), ("Shadow", 4));
    // Its gripfleet has started again: what it had compared counts, and it begins anew.
    story.goes(&[
        ("1 leaves: no trial", "Shadow 1, Shadow"),
        ("1 beside, 1 compares: 2", "Take 0, Stage(1)"),
    ]);
}

#[test]
fn a_model_that_asks_for_far_too_much_is_stopped_before_a_finger_moves() {
    let (mut story, both) = (beside(), members(2));
    for (who, count, stops) in [(0, 2, false), (1, 1, true)] {
        let grasps = compared(30.0, count);
        story.rollout.receive(&both[who], Report::Compared { from: 0, grasps }, 1);
        assert_eq!(story.rollout.stopped().is_some(), stops);
    }
    // The shadows go at once, with the reason.
    let story =
        story.goes(&[("", "GiveBack 0, GiveBack 1, Stopped(2)"), ("all back", "Stopped(0)")]);
    assert_eq!(
        story.why(),
        "it asks for too much force, as a shadow at the grippers (3 grasps compared: too little in 0, too much in 3, no answer in 0)"
    );
}

#[test]
fn a_shadow_stage_waits_for_those_that_grasp_and_not_for_ever() {
    let story = beside().goes(&[
        ("@3000 0 compares: 1, @4000 1 compares: 0", "Shadow"),
        ("@7000 0 compares: 1", "GiveBack 0, GiveBack 1, Stopped(2)"),
    ]);
    assert_eq!(story.why(), "0 has grasped nothing for too long");
}

/// Whoever is on trial with the model already has seen the shadow stage.
#[test]
fn a_roll_out_that_is_taken_up_again_has_no_second_shadow_stage() {
    let story = Story::new(RolloutConfig { shadow: Some(6), ..CONFIG }, 2);
    story.goes(&[("0 tries, 1 fits", "Take 0, Stage(1)")]);
}

/// A roll-out in which both of two grippers replay their recordings.
fn replaying() -> Story {
    Story::new(RolloutConfig { replay: true, ..CONFIG }, 2)
        .goes(&[("all fits", "Replay 0, Replay 1, Replay"), ("", "Replay")])
}

fn replayed(shadow_n: f32, count: usize) -> Report {
    let grasps = compared(shadow_n, count);
    Report::Replayed(Rehearsal { recordings: 1, skipped: Vec::new(), grasps })
}

#[test]
fn recordings_are_replayed_before_a_finger_moves() {
    let mut story = replaying().goes(&[("0 replayed, 1 replays", "Replay")]);
    story.rollout.receive(&members(2)[1], Report::Replayed(Rehearsal::default()), 0);
    let story = story.goes(&[("", "Take 0, Stage(1)")]);
    assert_eq!(story.rollout.replays(), Tally { grasps: 5, ..Tally::default() });

    let mut story = replaying();
    members(2).iter().for_each(|who| story.rollout.receive(who, replayed(2.0, 2), 0));
    let tally = Tally { grasps: 3, low: 3, ..Tally::default() };
    assert_eq!(story.rollout.stopped(), Some(&Stop::Replayed { what: Wrong::Low, tally }));
    story.goes(&[("", "Stopped(0)")]);
}

#[test]
fn a_pause_gives_the_model_to_nobody_and_judges_nothing_until_it_is_over() {
    let mut plant = Plant::new(20, 1);
    plant.turn();
    let who = plant.new.keys().next().unwrap().clone();
    assert!(plant.rollout.pause(&who, true));
    assert!(!plant.rollout.pause(&who, true), "it pauses already");
    let before = plant.rollout.evidence();
    // Longer than a gripper may be idle, with a model that loses each object.
    for _ in 0..400 {
        plant.now_us += 10 * SECOND;
        let grasps = vec![grasp(11, true); 30];
        plant.rollout.receive(&who, Report::Grasps { from: 1, grasps }, plant.now_us);
        assert_eq!(plant.rollout.step(), []);
    }
    assert_eq!((plant.rollout.evidence(), plant.new.len()), (before, 1));
    assert_eq!(plant.rollout.stopped(), None);
    assert!(plant.rollout.pause(&who, false));
    let grasps = vec![grasp(11, true); 30];
    plant.rollout.receive(&who, Report::Grasps { from: 1, grasps }, plant.now_us);
    assert!(matches!(plant.rollout.stopped(), Some(Stop::Worse { .. })));
    // The way back is open in a pause too.
    plant.rollout.pause(&who, true);
    assert_eq!(plant.rollout.step(), [(who, Order::GiveBack)]);
}

#[test]
fn a_pause_at_a_gripper_that_waits_stops_the_next_stage() {
    let mut plant = Plant::new(20, 0);
    plant.turn();
    let waiting = members(20).pop().unwrap();
    plant.rollout.pause(&waiting, true);
    (0..60).for_each(|_| plant.turn());
    assert_eq!((plant.new.len(), plant.rollout.progress()), (1, Progress::Stage(1)));
    plant.rollout.pause(&waiting, false);
    assert_eq!(plant.run().last(), Some(&20));
    assert_eq!(plant.rollout.progress(), Progress::Done);
}
