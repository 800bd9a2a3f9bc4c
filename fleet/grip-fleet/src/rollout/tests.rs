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

    fn obey(&mut self, orders: Vec<Order>) {
        for order in orders {
            let (member, report) = match order {
                Order::Check(member) => (member, Report::Fit(before())),
                Order::Replay(member) => (member, Report::Replayed(Rehearsal::default())),
                Order::Shadow(member) => (member, Report::Beside),
                Order::Take(member) => {
                    self.new.insert(member.clone(), 0);
                    (member, Report::Taken(before()))
                }
                Order::Accept(member) => (member, Report::Kept),
                Order::GiveBack(member) => {
                    self.new.remove(&member);
                    (member, Report::Back)
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
    plant.obey(members(3).into_iter().map(Order::Check).collect());
    let first = members(1).remove(0);
    plant.rollout.step();
    plant.obey(members(3).into_iter().map(Order::Check).collect());
    assert_eq!(plant.rollout.step(), [Order::Take(first.clone())]);
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

/// A roll-out to grippers that would all take the model.
fn checked(count: u8) -> Rollout {
    let mut rollout = Rollout::new(CONFIG, members(count));
    let asked: Vec<Order> = members(count).into_iter().map(Order::Check).collect();
    assert_eq!((rollout.progress(), rollout.step()), (Progress::Checking, asked));
    members(count).iter().for_each(|member| rollout.receive(member, Report::Fit(before()), 0));
    rollout
}

/// The first of them has got the model, and tries it since then (1 s).
fn tried(count: u8) -> (Rollout, Member) {
    let mut rollout = checked(count);
    let first = members(1).remove(0);
    assert_eq!(rollout.step(), [Order::Take(first.clone())]);
    rollout.receive(&first, Report::Taken(before()), SECOND);
    (rollout, first)
}

/// No grasp has ended.
fn nothing() -> Report {
    Report::Grasps { from: 0, grasps: Vec::new() }
}

/// The grasps that are wanted of a gripper.
fn enough() -> Report {
    Report::Grasps { from: 0, grasps: before() }
}

#[test]
fn who_would_refuse_it_stops_it_before_anybody_has_it_and_all_are_received() {
    let mut rollout = Rollout::new(CONFIG, members(4));
    rollout.step();
    let who = members(4);
    rollout.receive(&who[0], Report::Fit(before()), 1);
    rollout.receive(&who[2], Report::Refused("too early".to_owned()), 1);
    assert_eq!((rollout.progress(), rollout.step()), (Progress::Checking, vec![]));
    rollout.receive(&who[3], Report::Refused("too old".to_owned()), 3);
    assert_eq!((rollout.progress(), rollout.step()), (Progress::Checking, vec![]));
    // The last one never answers.
    for second in [2, 62] {
        rollout.miss(&who[1], None, second * SECOND);
        assert_eq!((rollout.step(), rollout.progress()), (vec![], Progress::Checking));
    }
    rollout.miss(&who[1], None, 63 * SECOND);
    assert_eq!((rollout.step(), rollout.progress()), (vec![], Progress::Stopped(0)));
    let reported = rollout.stopped().unwrap().to_string();
    assert_eq!(reported, format!("{} refused the model: too early", who[2]));
}

#[test]
fn whoever_stops_it_waits_for_nobody_who_has_not_stated_whether_it_would_take_it() {
    let mut rollout = Rollout::new(CONFIG, members(3));
    rollout.step();
    rollout.abort();
    assert_eq!((rollout.step(), rollout.progress()), (vec![], Progress::Stopped(0)));
    rollout.receive(&members(1)[0], Report::Fit(before()), 2);
    assert_eq!((rollout.step(), rollout.stopped()), (vec![], Some(&Stop::Ordered)));
}

#[test]
fn a_refusal_stops_it() {
    let mut rollout = checked(3);
    let orders = rollout.step();
    let [Order::Take(first)] = orders.as_slice() else { panic!("{orders:?}") };
    rollout.receive(first, Report::Refused("another hash".to_owned()), 1);
    assert_eq!(rollout.step(), []);
    assert_eq!(rollout.progress(), Progress::Stopped(0));
    let reported = rollout.stopped().unwrap().to_string();
    assert_eq!(reported, format!("{first} refused the model: another hash"));
}

#[test]
fn silence_stops_it_and_who_comes_back_is_reported_to_give_back() {
    let (mut rollout, first) = tried(3);
    let first = &first;
    rollout.miss(first, None, 2 * SECOND);
    // It answers once, and then states why it cannot.
    rollout.receive(first, nothing(), 40 * SECOND);
    rollout.miss(first, None, 41 * SECOND);
    rollout.miss(first, None, 101 * SECOND);
    assert_eq!(rollout.step(), []);
    rollout.miss(first, Some("no folder".to_owned()), 102 * SECOND);
    assert_eq!(rollout.step(), [Order::GiveBack(first.clone())]);
    assert_eq!(rollout.progress(), Progress::Stopped(1), "it may have the model still");
    rollout.receive(first, Report::Back, 110 * SECOND);
    assert_eq!(rollout.progress(), Progress::Stopped(0));
    let reported = rollout.stopped().unwrap().to_string();
    assert_eq!(reported, format!("{first} has not answered for too long: no folder"));
}

/// A turn over many grippers may take longer than patience: whoever answers when asked is there.
#[test]
fn who_was_not_asked_for_long_is_not_gone() {
    let (mut rollout, first) = tried(2);
    let first = &first;
    for second in [300, 600, 1200] {
        rollout.receive(first, nothing(), second * SECOND);
        assert_eq!(rollout.step(), []);
        // One answer that was lost is none of patience, however late the next question comes.
        rollout.miss(first, None, (second + 100) * SECOND);
        assert_eq!((rollout.step(), rollout.stopped()), (vec![], None));
    }
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
    let (mut rollout, first) = tried(2);
    let second = members(2).remove(1);
    rollout.receive(&first, enough(), SECOND);
    assert_eq!(rollout.step(), [Order::Take(second.clone())]);
    rollout.receive(&second, Report::Taken(before()), SECOND);
    assert_eq!((rollout.step(), rollout.progress()), (vec![], Progress::Stage(2)));
    rollout.receive(&second, enough(), SECOND);
    let all = [Order::Accept(first.clone()), Order::Accept(second.clone())];
    assert_eq!((rollout.step(), rollout.progress()), (all.to_vec(), Progress::Accepting));
    rollout.receive(&first, Report::Kept, SECOND);
    // The second one does not answer any more: both go back.
    rollout.miss(&second, None, SECOND);
    rollout.miss(&second, None, 62 * SECOND);
    let back = [Order::GiveBack(first), Order::GiveBack(second)];
    assert_eq!(rollout.step(), back);
}

/// A way back that is deployed: nobody needs a grasp to compare with.
#[test]
fn who_knows_the_model_gets_it_at_once() {
    let mut rollout = Rollout::new(CONFIG, members(3));
    rollout.step();
    members(3).iter().for_each(|member| rollout.receive(member, Report::Known, 1));
    let all: Vec<Order> = members(3).into_iter().map(Order::Take).collect();
    assert_eq!(rollout.step(), all);
    members(3).iter().for_each(|member| rollout.receive(member, Report::Had, 1));
    assert_eq!((rollout.step(), rollout.progress()), (vec![], Progress::Done));
}

#[test]
fn strangers_and_late_words_change_nothing() {
    let mut rollout = Rollout::new(CONFIG, members(2));
    let stranger = Member { uid: Uid([9; 16]), ..members(1).remove(0) };
    rollout.receive(&stranger, Report::Refused(String::new()), 0);
    rollout.receive(&members(1)[0], nothing(), 0);
    assert_eq!((rollout.stopped(), rollout.progress()), (None, Progress::Checking));
    let nobody = Rollout::new(CONFIG, []);
    assert_eq!(nobody.progress(), Progress::Done);
}

#[test]
fn who_holds_nothing_for_too_long_stops_it_though_it_answers() {
    let (mut rollout, first) = tried(2);
    let first = &first;
    for second in 2..=3601 {
        rollout.receive(first, nothing(), second * SECOND);
        assert_eq!(rollout.step(), [], "a pause of an hour at most");
    }
    rollout.receive(first, nothing(), 3602 * SECOND);
    assert_eq!(rollout.step(), [Order::GiveBack(first.clone())]);
    assert_eq!(rollout.stopped(), Some(&Stop::Idle { member: first.clone() }));
}

#[test]
fn who_had_the_model_before_does_not_stand_for_the_first_to_try_it() {
    let mut rollout = Rollout::new(CONFIG, members(4));
    rollout.step();
    let who = members(4);
    rollout.receive(&who[0], Report::Had, 1);
    who[1..].iter().for_each(|member| rollout.receive(member, Report::Fit(before()), 1));
    assert_eq!(rollout.step(), [Order::Take(who[1].clone())]);
    rollout.receive(&who[1], Report::Taken(before()), 3);
    rollout.receive(&who[1], enough(), 4);
    assert_eq!(rollout.step(), [Order::Take(who[2].clone())]);
    rollout.receive(&who[2], Report::Taken(before()), 6);
    rollout.abort();
    let back = [Order::GiveBack(who[1].clone()), Order::GiveBack(who[2].clone())];
    assert_eq!(rollout.step(), back);
    // All of them have it already.
    let mut rollout = Rollout::new(CONFIG, members(2));
    rollout.step();
    members(2).iter().for_each(|member| rollout.receive(member, Report::Had, 1));
    assert_eq!((rollout.step(), rollout.progress()), (vec![], Progress::Done));
}

#[test]
fn who_has_got_the_model_from_elsewhere_meanwhile_keeps_it() {
    let mut rollout = checked(3);
    let mut reported = Vec::new();
    for now_us in 0..3 {
        for order in rollout.step() {
            let (Order::Check(member)
            | Order::Replay(member)
            | Order::Shadow(member)
            | Order::Take(member)
            | Order::Accept(member)
            | Order::GiveBack(member)) = &order;
            let report = if reported.is_empty() { Report::Had } else { Report::Taken(before()) };
            rollout.receive(member, report, now_us);
            reported.push(order);
        }
    }
    rollout.abort();
    // Another one is the first to try it, alone.
    let [_, second, third] = &members(3)[..] else { panic!() };
    assert_eq!(reported, [Order::Take(members(1).remove(0)), Order::Take(second.clone())]);
    let back = rollout.step();
    assert_eq!((back, rollout.stage()), (vec![Order::GiveBack(second.clone())], 1));
    assert!(rollout.holding().all(|member| member != third));
    assert_eq!(rollout.stopped(), Some(&Stop::Ordered));
    let holding: Vec<Member> = rollout.holding().cloned().collect();
    assert_eq!(rollout.progress(), Progress::Stopped(holding.len()));
    holding.iter().for_each(|member| rollout.receive(member, Report::Back, 10));
    assert_eq!(rollout.progress(), Progress::Stopped(0));
}

/// Grasps in which a shadow asked for this force, where 6 N held the object, and 3 N did not.
fn compared(shadow_n: f32, count: usize) -> Vec<Grasp> {
    let (in_force_n, shadow_n, held_n) = (Some(6.0), Some(shadow_n), Some(6.0));
    let compared = Some(Compared { in_force_n, shadow_n, slipped_n: 3.0, held_n });
    vec![Grasp { compared, ..Grasp::default() }; count]
}

/// A roll-out to two grippers that both let the model estimate, for six grasps.
fn beside() -> (Rollout, [Member; 2]) {
    let mut rollout = Rollout::new(RolloutConfig { shadow: Some(6), ..CONFIG }, members(2));
    rollout.step();
    let both = [members(2).remove(0), members(2).remove(1)];
    both.iter().for_each(|member| rollout.receive(member, Report::Fit(before()), 0));
    assert_eq!(rollout.step(), both.clone().map(Order::Shadow));
    both.iter().for_each(|member| rollout.receive(member, Report::Beside, 0));
    assert_eq!((rollout.progress(), rollout.holding().count()), (Progress::Shadow, 0));
    (rollout, both)
}

#[test]
fn a_model_is_asked_beside_those_in_force_before_anybody_has_it() {
    let (mut rollout, [first, second]) = beside();
    let report = |from, count| Report::Compared { from, grasps: compared(6.0, count) };
    rollout.receive(&first, report(0, 3), 1);
    // What is known already is not counted twice, and what comes after a gap is not taken.
    rollout.receive(&first, report(1, 3), 1);
    rollout.receive(&second, report(1, 3), 1);
    assert_eq!((rollout.known(&first), rollout.known(&second)), (Some(4), Some(0)));
    assert_eq!((rollout.step(), rollout.shadow().1.grasps), (Vec::new(), 4));
    // Its gripfleet has started again: what it had compared counts, and it begins anew.
    rollout.receive(&second, Report::Left("no trial".to_owned()), 2);
    assert_eq!(rollout.step(), [Order::Shadow(second.clone())]);
    rollout.receive(&second, Report::Beside, 2);
    rollout.receive(&second, report(0, 2), 3);
    assert_eq!(rollout.step(), [Order::Take(first)]);
    assert_eq!(rollout.progress(), Progress::Stage(1));
}

#[test]
fn a_model_that_asks_for_far_too_much_is_stopped_before_a_finger_moves() {
    let (mut rollout, [first, second]) = beside();
    rollout.receive(&first, Report::Compared { from: 0, grasps: compared(30.0, 2) }, 1);
    assert_eq!(rollout.stopped(), None);
    rollout.receive(&second, Report::Compared { from: 0, grasps: compared(30.0, 1) }, 1);
    let tally = Tally { grasps: 3, high: 3, ..Tally::default() };
    assert_eq!(rollout.stopped(), Some(&Stop::Wrong { what: Wrong::High, tally }));
    // The shadows go at once, with the reason.
    let both = [first, second];
    assert_eq!(rollout.step(), both.clone().map(Order::GiveBack));
    assert_eq!(rollout.progress(), Progress::Stopped(2));
    both.iter().for_each(|member| rollout.receive(member, Report::Back, 2));
    assert_eq!((rollout.step(), rollout.progress()), (Vec::new(), Progress::Stopped(0)));
    assert_eq!(
        rollout.stopped().unwrap().to_string(),
        "it asks for too much force, as a shadow at the grippers (3 grasps compared: too little in 0, too much in 3, no answer in 0)"
    );
}

#[test]
fn a_shadow_stage_waits_for_those_that_grasp_and_not_for_ever() {
    let (mut rollout, [first, second]) = beside();
    let report = |from, count| Report::Compared { from, grasps: compared(6.0, count) };
    rollout.receive(&first, report(0, 1), 3000 * SECOND);
    rollout.receive(&second, report(0, 0), 4000 * SECOND);
    assert_eq!((rollout.step(), rollout.stopped()), (Vec::new(), None));
    rollout.receive(&first, report(1, 0), 7000 * SECOND);
    rollout.step();
    assert_eq!(rollout.stopped(), Some(&Stop::Idle { member: first }));
}

/// Whoever is on trial with the model already has seen the shadow stage.
#[test]
fn a_roll_out_that_is_taken_up_again_has_no_second_shadow_stage() {
    let mut rollout = Rollout::new(RolloutConfig { shadow: Some(6), ..CONFIG }, members(2));
    rollout.step();
    rollout.receive(&members(2)[0], Report::Trying(before()), 0);
    rollout.receive(&members(2)[1], Report::Fit(before()), 0);
    assert_eq!(rollout.step(), [Order::Take(members(1).remove(0))]);
}

/// A roll-out in which both of two grippers replay their recordings.
fn replaying() -> (Rollout, [Member; 2]) {
    let mut rollout = Rollout::new(RolloutConfig { replay: true, ..CONFIG }, members(2));
    rollout.step();
    let both = [members(2).remove(0), members(2).remove(1)];
    both.iter().for_each(|member| rollout.receive(member, Report::Fit(before()), 0));
    assert_eq!(rollout.step(), both.clone().map(Order::Replay));
    assert_eq!((rollout.progress(), rollout.step()), (Progress::Replay, Vec::new()));
    (rollout, both)
}

fn replayed(shadow_n: f32, count: usize) -> Report {
    let grasps = compared(shadow_n, count);
    Report::Replayed(Rehearsal { recordings: 1, skipped: Vec::new(), grasps })
}

#[test]
fn recordings_are_replayed_before_a_finger_moves() {
    let (mut rollout, [first, second]) = replaying();
    rollout.receive(&first, replayed(6.0, 5), 0);
    rollout.receive(&second, Report::Replaying, 0);
    assert_eq!(rollout.step(), []);
    rollout.receive(&second, Report::Replayed(Rehearsal::default()), 0);
    assert_eq!(rollout.step(), [Order::Take(first)]);
    assert_eq!(rollout.replays(), Tally { grasps: 5, ..Tally::default() });

    let (mut rollout, [first, second]) = replaying();
    rollout.receive(&first, replayed(2.0, 2), 0);
    rollout.receive(&second, replayed(2.0, 2), 0);
    let tally = Tally { grasps: 3, low: 3, ..Tally::default() };
    assert_eq!(rollout.stopped(), Some(&Stop::Replayed { what: Wrong::Low, tally }));
    assert_eq!((rollout.step(), rollout.progress()), (Vec::new(), Progress::Stopped(0)));
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
    assert_eq!(plant.rollout.step(), [Order::GiveBack(who)]);
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
