//! A session, a model and a clock in; who has taken the model, how it does there and who gives it back out: [`Rollout`] over a network.
//!
//! Nothing here reads a clock of its own. Many grippers are asked at once; one that does not answer is asked again with the next turn, since each order
//! may come twice.

use super::{Ask, NetError, ask};
use crate::{
    deploy::{How, Offer, Order, Standing, digest},
    key::{Member, Part},
    rollout::{self, Progress, Report, Rollout, RolloutConfig, Stop},
};
use core::time::Duration;
use std::{collections::BTreeSet, thread};
use zenoh::Session;

/// Grippers that are asked at once.
const AT_ONCE: usize = 32;

/// A model for many grippers.
#[derive(Debug)]
pub struct Deployer {
    session: Session,
    offer: Offer,
    rollout: Rollout,
    /// Who was asked whether it would take the model, told to take it, or told to give it back, and has not answered.
    checking: BTreeSet<Member>,
    taking: BTreeSet<Member>,
    returning: BTreeSet<Member>,
    /// Who may have taken it without our hearing of it.
    unsure: BTreeSet<Member>,
    patience: Duration,
}

/// Something that a person wants to see.
#[derive(Clone, Debug, PartialEq)]
pub enum Happening {
    /// This stage begins.
    Stage(usize),
    /// A gripper has said something about the model.
    Reported(Member, Report),
    /// A gripper did not answer, or said why it cannot; it is asked again.
    Silent(Member, Option<String>),
}

impl Deployer {
    /// A roll-out of a model file of that name, which begins with the first turn. An answer may take `patience`.
    pub fn new(
        session: Session,
        config: RolloutConfig,
        (name, bytes): (String, Vec<u8>),
        members: impl IntoIterator<Item = Member>,
        patience: Duration,
    ) -> Self {
        let (sha256, judge) = (digest(&bytes), config.judge);
        let offer = Offer { name, sha256, judge, bytes: bytes.into() };
        let rollout = Rollout::new(config, members);
        let (checking, taking) = (BTreeSet::new(), BTreeSet::new());
        let (returning, unsure) = (BTreeSet::new(), BTreeSet::new());
        Self { session, offer, rollout, checking, taking, returning, unsure, patience }
    }

    /// Gives orders, asks how it goes and tells what was heard. The clock is read when an answer has come, or patience has ended.
    pub fn turn(&mut self, now_us: &dyn Fn() -> u64) -> Vec<Happening> {
        let mut happenings = Vec::new();
        let before = self.rollout.stage();
        let steps = self.rollout.step();
        if self.rollout.stage() != before {
            happenings.push(Happening::Stage(self.rollout.stage()));
        }
        for order in steps {
            match order {
                rollout::Order::Check(member) => self.checking.insert(member),
                rollout::Order::Take(member) => self.taking.insert(member),
                rollout::Order::GiveBack(member) => {
                    self.taking.remove(&member);
                    self.returning.insert(member)
                }
            };
        }
        if !matches!(self.rollout.progress(), Progress::Checking) {
            self.checking.clear();
        }
        let mut orders: Vec<(Member, Order)> = Vec::new();
        let back = Order::Back { sha256: Some(self.offer.sha256.clone()) };
        orders.extend(self.returning.iter().map(|who| (who.clone(), back.clone())));
        let check = self.checking.iter().map(|who| (who, Order::Check(self.offer.clone())));
        let take = self.taking.iter().map(|who| (who, Order::Take(self.offer.clone())));
        orders.extend(check.chain(take).map(|(who, order)| (who.clone(), order)));
        let open = self.rollout.holding().filter(|who| self.rollout.is_open(who));
        orders.extend(open.map(|who| (who.clone(), Order::Notify)));
        for some in orders.chunks(AT_ONCE) {
            for (member, order, answer) in self.ask(some) {
                happenings.push(self.receive(member, &order, answer, now_us()));
            }
        }
        happenings
    }

    /// Stops it; the next turn asks for the model back.
    pub fn abort(&mut self) {
        self.rollout.abort();
    }

    /// Which stage it is in or was in; 0 before the first.
    #[must_use]
    pub const fn stage(&self) -> usize {
        self.rollout.stage()
    }

    /// Where it is.
    #[must_use]
    pub fn progress(&self) -> Progress {
        self.rollout.progress()
    }

    /// Why it was stopped.
    #[must_use]
    pub const fn stopped(&self) -> Option<&Stop> {
        self.rollout.stopped()
    }

    /// Who may have the model by this roll-out.
    pub fn holding(&self) -> impl Iterator<Item = &Member> {
        self.rollout.holding()
    }

    /// Asks many at once.
    fn ask(&self, orders: &[(Member, Order)]) -> Vec<(Member, Order, Result<Standing, NetError>)> {
        let Self { session, patience, .. } = self;
        thread::scope(|scope| {
            let asking: Vec<_> = orders
                .iter()
                .map(|(member, order)| {
                    scope.spawn(move || standing(session, member, order, *patience))
                })
                .collect();
            let answers = asking.into_iter().zip(orders).map(|(asking, (member, order))| {
                // A thread that panicked has no answer.
                let silent = || Err(NetError::Silent { member: member.to_string() });
                (member.clone(), order.clone(), asking.join().unwrap_or_else(|_| silent()))
            });
            answers.collect()
        })
    }

    fn receive(
        &mut self,
        member: Member,
        order: &Order,
        answer: Result<Standing, NetError>,
        now_us: u64,
    ) -> Happening {
        let report = match (order, answer) {
            (Order::Check(_) | Order::Take(_), Err(error @ NetError::Declined { .. })) => {
                Report::Refused(reason(&error))
            }
            // It is asked again: what cannot be given back now can be later.
            (order, Err(error)) => {
                if matches!(order, Order::Take(_)) {
                    self.unsure.insert(member.clone());
                }
                let reason = match error {
                    NetError::Silent { .. } => None,
                    error => Some(reason(&error)),
                };
                self.rollout.miss(&member, reason.clone(), now_us);
                return Happening::Silent(member, reason);
            }
            (Order::Check(_), Ok(standing)) => self.checked(&standing),
            (Order::Take(_), Ok(standing)) => self.taken(&member, &standing),
            (Order::Back { .. }, Ok(_)) => Report::Back,
            (Order::Notify, Ok(standing)) => self.reported(&standing),
        };
        match order {
            Order::Check(_) => self.checking.remove(&member),
            Order::Take(_) => self.taking.remove(&member),
            Order::Back { .. } => self.returning.remove(&member),
            Order::Notify => false,
        };
        self.rollout.receive(&member, report.clone(), now_us);
        Happening::Reported(member, report)
    }

    /// The answer of one that would take the model.
    fn checked(&self, standing: &Standing) -> Report {
        let ours = standing.in_force.sha256 == self.offer.sha256 && standing.trial.is_none();
        if ours { Report::Had } else { Report::Fit }
    }

    /// The answer to an order to take the model.
    fn taken(&self, member: &Member, standing: &Standing) -> Report {
        match &standing.trial {
            Some(trial) => Report::Taken(trial.before),
            None if self.unsure.contains(member) => Report::Kept,
            None => Report::Had,
        }
    }

    /// The answer to a look.
    fn reported(&self, standing: &Standing) -> Report {
        let ours = standing.in_force.sha256 == self.offer.sha256;
        if ours {
            return match standing.trial {
                Some(_) => Report::Counted(standing.counted),
                None => Report::Kept,
            };
        }
        match standing.last.as_ref().filter(|last| last.model.sha256 == self.offer.sha256) {
            Some(last) => match last.how {
                How::Worse(worse) => Report::FellBack(worse),
                how => Report::Left(how.to_string()),
            },
            None => Report::Left("another model was taken".to_owned()),
        }
    }
}

/// What a gripper says of its models, once it has obeyed the order.
///
/// # Errors
/// As [`ask`], and [`NetError::Unusable`].
pub fn standing(
    session: &Session,
    member: &Member,
    order: &Order,
    patience: Duration,
) -> Result<Standing, NetError> {
    let parameters = order.parameters();
    let parameters: Vec<(&str, &str)> =
        parameters.iter().map(|(name, value)| (*name, value.as_str())).collect();
    let (part, parameters, payload) = (Part::Model, parameters.as_slice(), order.payload());
    let answer = ask(session, &Ask { member, part, parameters, payload, patience })?;
    let unusable = |reason| NetError::Unusable { member: member.to_string(), reason };
    let standing: Standing = serde_json::from_slice(&answer.concat())
        .map_err(|error| unusable(format!("its answer cannot be read: {error}")))?;
    let before = standing.trial.as_ref().map(|trial| trial.before);
    match [Some(standing.counted), before].iter().flatten().find(|counts| !counts.is_sane()) {
        Some(counts) => Err(unusable(format!("it cannot have counted {counts}"))),
        None => Ok(standing),
    }
}

/// What a gripper said, without its name, which stands before it already.
fn reason(error: &NetError) -> String {
    match error {
        NetError::Declined { reason, .. } | NetError::Unusable { reason, .. } => reason.clone(),
        other => other.to_string(),
    }
}
