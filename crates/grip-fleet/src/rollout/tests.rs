//! Roll-outs to simulated grippers whose slip rate depends on the model.

use super::{Counts, Order, Progress, Report, Rollout, RolloutConfig, Stop, Worse};
use crate::key::Member;
use grip_session::config::Uid;
use std::collections::BTreeSet;

const SECOND: u64 = 1_000_000;

fn members(count: u8) -> Vec<Member> {
    let site: grip_session::config::Site = "hall".parse().unwrap();
    (0..count).map(|n| Member { site: site.clone(), uid: Uid([n; 16]) }).collect()
}

/// Twenty grippers, one slip in ten seconds with the old model; with the new one so many in a minute.
struct Plant {
    rollout: Rollout,
    now_us: u64,
    new: BTreeSet<Member>,
    most: usize,
    per_minute: u64,
}

impl Plant {
    fn new(count: u8, per_minute: u64) -> Self {
        let rollout = Rollout::new(RolloutConfig::default(), members(count));
        Self { rollout, now_us: 0, new: BTreeSet::new(), most: 0, per_minute }
    }

    fn obey(&mut self, orders: Vec<Order>) {
        for order in orders {
            match order {
                Order::Check(member) => self.rollout.receive(&member, Report::Fit, self.now_us),
                Order::Take(member) => {
                    let before = Counts { seconds: 3600.0, slips: 360, faults: 2, grasps: 1 };
                    self.rollout.receive(&member, Report::Taken(before), self.now_us);
                    self.new.insert(member);
                }
                Order::GiveBack(member) => {
                    self.rollout.receive(&member, Report::Back, self.now_us);
                    self.new.remove(&member);
                }
            }
            self.most = self.most.max(self.new.len());
        }
    }

    /// Ten seconds, and each tells how it does.
    fn turn(&mut self, minute: u64) {
        loop {
            let orders = self.rollout.step();
            if orders.is_empty() {
                break;
            }
            self.obey(orders);
        }
        self.now_us += 10 * SECOND;
        let slips = self.per_minute * minute / 6;
        let counts = Counts {
            seconds: 10.0 * f64::from(u32::try_from(minute).unwrap()),
            slips,
            faults: 0,
            grasps: 1,
        };
        for member in self.new.clone() {
            self.rollout.receive(&member, Report::Counted(counts), self.now_us);
        }
    }

    /// Stages until the end; for each the count of those that have the model.
    fn run(&mut self) -> Vec<usize> {
        let mut stages = Vec::new();
        for turn in 0..1000 {
            self.turn(turn % 61);
            if stages.last() != Some(&self.new.len()) {
                stages.push(self.new.len());
            }
        }
        stages
    }
}

#[test]
fn a_good_model_goes_to_one_then_some_then_all() {
    let mut plant = Plant::new(20, 6);
    assert_eq!(plant.run(), [1, 5, 20]);
    assert_eq!(plant.rollout.progress(), Progress::Done);
    assert_eq!(plant.rollout.stopped(), None);
}

#[test]
fn a_worse_model_stops_at_the_first_and_goes_back() {
    let mut plant = Plant::new(20, 30);
    assert_eq!(plant.run(), [1, 0]);
    assert_eq!((plant.most, plant.rollout.progress()), (1, Progress::Stopped(0)));
    let Some(Stop::Worse { what: Worse::Slips, .. }) = plant.rollout.stopped() else {
        panic!("{:?}", plant.rollout.stopped())
    };
}

/// A roll-out to grippers that would all take the model.
fn checked(count: u8) -> Rollout {
    let mut rollout = Rollout::new(RolloutConfig::default(), members(count));
    let asked: Vec<Order> = members(count).into_iter().map(Order::Check).collect();
    assert_eq!((rollout.progress(), rollout.step()), (Progress::Checking, asked));
    members(count).iter().for_each(|member| rollout.receive(member, Report::Fit, 0));
    rollout
}

/// The first of them has got the model, and tries it since then (1 s).
fn tried(count: u8) -> (Rollout, Member) {
    let mut rollout = checked(count);
    let first = members(1).remove(0);
    assert_eq!(rollout.step(), [Order::Take(first.clone())]);
    rollout.receive(&first, Report::Taken(Counts::default()), SECOND);
    (rollout, first)
}

#[test]
fn who_would_refuse_it_stops_it_before_anybody_has_it_and_all_are_received() {
    let mut rollout = Rollout::new(RolloutConfig::default(), members(4));
    rollout.step();
    let who = members(4);
    rollout.receive(&who[0], Report::Fit, 1);
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
    let mut rollout = Rollout::new(RolloutConfig::default(), members(3));
    rollout.step();
    rollout.abort();
    assert_eq!((rollout.step(), rollout.progress()), (vec![], Progress::Stopped(0)));
    rollout.receive(&members(1)[0], Report::Fit, 2);
    assert_eq!((rollout.step(), rollout.stopped()), (vec![], Some(&Stop::Told)));
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
    // It answers once, and then says why it cannot.
    rollout.receive(first, Report::Counted(Counts::default()), 40 * SECOND);
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
        rollout.receive(first, Report::Counted(Counts::default()), second * SECOND);
        assert_eq!(rollout.step(), []);
        // One answer that was lost is none of patience, however late the next question comes.
        rollout.miss(first, None, (second + 100) * SECOND);
        assert_eq!((rollout.step(), rollout.stopped()), (vec![], None));
    }
}

#[test]
fn who_falls_back_by_itself_stops_it_for_all() {
    let mut plant = Plant::new(20, 6);
    while plant.new.len() < 5 {
        (0..61).for_each(|minute| plant.turn(minute));
    }
    let fallen = members(3).remove(2);
    plant.new.remove(&fallen);
    plant.rollout.receive(&fallen, Report::FellBack(Worse::Faults), plant.now_us);
    plant.turn(1);
    assert_eq!((plant.new.len(), plant.rollout.progress()), (0, Progress::Stopped(0)));
    let reported = plant.rollout.stopped().unwrap().to_string();
    assert_eq!(reported, format!("{fallen} has more faults with the new model"));
}

#[test]
fn strangers_and_late_words_change_nothing() {
    let mut rollout = Rollout::new(RolloutConfig::default(), members(2));
    let stranger = Member { uid: Uid([9; 16]), ..members(1).remove(0) };
    rollout.receive(&stranger, Report::Refused(String::new()), 0);
    rollout.receive(&members(1)[0], Report::Counted(Counts::default()), 0);
    assert_eq!((rollout.stopped(), rollout.progress()), (None, Progress::Checking));
    let nobody = Rollout::new(RolloutConfig::default(), []);
    assert_eq!(nobody.progress(), Progress::Done);
}

#[test]
fn who_holds_nothing_for_too_long_stops_it_though_it_answers() {
    let (mut rollout, first) = tried(2);
    let first = &first;
    for second in 2..=3601 {
        rollout.receive(first, Report::Counted(Counts::default()), second * SECOND);
        assert_eq!(rollout.step(), [], "a pause of an hour at most");
    }
    rollout.receive(first, Report::Counted(Counts::default()), 3602 * SECOND);
    assert_eq!(rollout.step(), [Order::GiveBack(first.clone())]);
    assert_eq!(rollout.stopped(), Some(&Stop::Idle { member: first.clone() }));
}

#[test]
fn who_had_the_model_before_does_not_stand_for_the_first_to_try_it() {
    let mut rollout = Rollout::new(RolloutConfig::default(), members(4));
    rollout.step();
    let who = members(4);
    rollout.receive(&who[0], Report::Had, 1);
    who[1..].iter().for_each(|member| rollout.receive(member, Report::Fit, 1));
    assert_eq!(rollout.step(), [Order::Take(who[1].clone())]);
    rollout.receive(&who[1], Report::Taken(Counts::default()), 3);
    rollout.receive(&who[1], Report::Kept, 4);
    assert_eq!(rollout.step(), [Order::Take(who[2].clone())]);
    rollout.receive(&who[2], Report::Taken(Counts::default()), 6);
    rollout.abort();
    let back = [Order::GiveBack(who[1].clone()), Order::GiveBack(who[2].clone())];
    assert_eq!(rollout.step(), back);
    // All of them have it already.
    let mut rollout = Rollout::new(RolloutConfig::default(), members(2));
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
            let (Order::Check(member) | Order::Take(member) | Order::GiveBack(member)) = &order;
            let report =
                if reported.is_empty() { Report::Had } else { Report::Taken(Counts::default()) };
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
    assert_eq!(rollout.stopped(), Some(&Stop::Told));
    let holding: Vec<Member> = rollout.holding().cloned().collect();
    assert_eq!(rollout.progress(), Progress::Stopped(holding.len()));
    holding.iter().for_each(|member| rollout.receive(member, Report::Back, 10));
    assert_eq!(rollout.progress(), Progress::Stopped(0));
}

#[test]
fn who_left_by_itself_is_named_with_its_reason() {
    let (mut rollout, first) = tried(3);
    rollout.receive(&first, Report::Left("it has started again".to_owned()), 2 * SECOND);
    assert_eq!(rollout.step(), []);
    let reported = rollout.stopped().unwrap().to_string();
    assert_eq!(
        reported,
        format!("{first} has gone back to the model before: it has started again")
    );
}
