//! Roll-outs to simulated grippers whose slip rate depends on the model.

use super::{Counts, Order, Progress, Report, Rollout, RolloutConfig, Stop, Worse};
use crate::key::Member;
use grip_host::config::Uid;
use std::collections::BTreeSet;

const SECOND: u64 = 1_000_000;

fn members(count: u8) -> Vec<Member> {
    let site: grip_host::config::Site = "hall".parse().unwrap();
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
                Order::Take(member) => {
                    let before = Counts { seconds: 3600.0, slips: 360, faults: 2 };
                    self.rollout.hear(&member, Report::Taken(before), self.now_us);
                    self.new.insert(member);
                }
                Order::GiveBack(member) => {
                    self.rollout.hear(&member, Report::Back, self.now_us);
                    self.new.remove(&member);
                }
            }
            self.most = self.most.max(self.new.len());
        }
    }

    /// Ten seconds, and each tells how it does.
    fn turn(&mut self, minute: u64) {
        let orders = self.rollout.step(self.now_us);
        self.obey(orders);
        self.now_us += 10 * SECOND;
        let slips = self.per_minute * minute / 6;
        let counts =
            Counts { seconds: 10.0 * f64::from(u32::try_from(minute).unwrap()), slips, faults: 0 };
        for member in self.new.clone() {
            self.rollout.hear(&member, Report::Counted(counts), self.now_us);
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

#[test]
fn a_refusal_stops_it() {
    let mut rollout = Rollout::new(RolloutConfig::default(), members(3));
    let orders = rollout.step(0);
    let [Order::Take(first)] = orders.as_slice() else { panic!("{orders:?}") };
    rollout.hear(first, Report::Refused("another hash".to_owned()), 1);
    assert_eq!(rollout.step(2), []);
    assert_eq!(rollout.progress(), Progress::Stopped(0));
    let told = rollout.stopped().unwrap().to_string();
    assert_eq!(told, format!("{first} refused the model: another hash"));
}

#[test]
fn silence_stops_it_and_who_comes_back_is_told_to_give_back() {
    let mut rollout = Rollout::new(RolloutConfig::default(), members(3));
    let orders = rollout.step(0);
    let [Order::Take(first)] = orders.as_slice() else { panic!("{orders:?}") };
    rollout.hear(first, Report::Taken(Counts::default()), SECOND);
    assert_eq!(rollout.step(61 * SECOND), []);
    assert_eq!(rollout.step(62 * SECOND), [Order::GiveBack(first.clone())]);
    assert_eq!(rollout.progress(), Progress::Stopped(1), "it may have the model still");
    rollout.hear(first, Report::Back, 70 * SECOND);
    assert_eq!(rollout.progress(), Progress::Stopped(0));
    assert_eq!(rollout.stopped(), Some(&Stop::Gone { member: first.clone() }));
}

#[test]
fn who_falls_back_by_itself_stops_it_for_all() {
    let mut plant = Plant::new(20, 6);
    while plant.new.len() < 5 {
        (0..61).for_each(|minute| plant.turn(minute));
    }
    let fallen = members(3).remove(2);
    plant.new.remove(&fallen);
    plant.rollout.hear(&fallen, Report::FellBack(Worse::Faults), plant.now_us);
    plant.turn(1);
    assert_eq!((plant.new.len(), plant.rollout.progress()), (0, Progress::Stopped(0)));
    let told = plant.rollout.stopped().unwrap().to_string();
    assert_eq!(told, format!("{fallen} has more faults with the new model"));
}

#[test]
fn strangers_and_late_words_change_nothing() {
    let mut rollout = Rollout::new(RolloutConfig::default(), members(2));
    let stranger = Member { uid: Uid([9; 16]), ..members(1).remove(0) };
    rollout.hear(&stranger, Report::Refused(String::new()), 0);
    rollout.hear(&members(1)[0], Report::Counted(Counts::default()), 0);
    assert_eq!((rollout.stopped(), rollout.progress()), (None, Progress::Stage(1)));
    let nobody = Rollout::new(RolloutConfig::default(), []);
    assert_eq!(nobody.progress(), Progress::Done);
}

#[test]
fn who_holds_nothing_is_gone_though_it_answers() {
    let mut rollout = Rollout::new(RolloutConfig::default(), members(2));
    let orders = rollout.step(0);
    let [Order::Take(first)] = orders.as_slice() else { panic!("{orders:?}") };
    rollout.hear(first, Report::Taken(Counts::default()), SECOND);
    for second in 2..62 {
        rollout.hear(first, Report::Counted(Counts::default()), second * SECOND);
    }
    assert_eq!(rollout.step(62 * SECOND), [Order::GiveBack(first.clone())]);
}

#[test]
fn who_had_the_model_before_keeps_it() {
    let mut rollout = Rollout::new(RolloutConfig::default(), members(3));
    let mut told = Vec::new();
    for now_us in 0..3 {
        for order in rollout.step(now_us) {
            let (Order::Take(member) | Order::GiveBack(member)) = &order;
            let report =
                if told.is_empty() { Report::Had } else { Report::Taken(Counts::default()) };
            rollout.hear(member, report, now_us);
            told.push(order);
        }
    }
    rollout.abort();
    let back = rollout.step(9);
    assert!(!back.is_empty());
    assert!(!back.contains(&Order::GiveBack(members(1).remove(0))), "{back:?}");
    assert_eq!(rollout.stopped(), Some(&Stop::Told));
    let holding: Vec<Member> = rollout.holding().cloned().collect();
    assert_eq!(rollout.progress(), Progress::Stopped(holding.len()));
    holding.iter().for_each(|member| rollout.hear(member, Report::Back, 10));
    assert_eq!(rollout.progress(), Progress::Stopped(0));
}

#[test]
fn who_left_by_itself_is_named_with_its_reason() {
    let mut rollout = Rollout::new(RolloutConfig::default(), members(3));
    let first = members(1).remove(0);
    rollout.step(0);
    rollout.hear(&first, Report::Taken(Counts::default()), 1);
    rollout.hear(&first, Report::Left("it has started again".to_owned()), 2);
    assert_eq!(rollout.step(3), []);
    let told = rollout.stopped().unwrap().to_string();
    assert_eq!(told, format!("{first} has gone back to the model before: it has started again"));
}
