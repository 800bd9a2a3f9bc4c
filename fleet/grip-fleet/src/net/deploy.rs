//! A session, a model and a clock in; who has taken the model, how it does there and who gives it back out: [`Rollout`] over a network.
//!
//! Nothing here reads a clock of its own. Many grippers are asked at once; one that does not answer is asked again with the next turn, since each order
//! may come twice.

use super::{Ask, NetError, ask};
use crate::{
    deploy::{ModelId, Offer, Order, Origin, Paused, Standing},
    key::{Member, Part},
    rollout::{self, Evidence, Grasp, Progress, Report, Rollout, RolloutConfig, Stop, Tally},
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
    /// Who was asked whether it would take the model, ordered to let it estimate, to take it, to keep it or to give it back, and has not answered.
    checking: BTreeSet<Member>,
    replaying: BTreeSet<Member>,
    casting: BTreeSet<Member>,
    taking: BTreeSet<Member>,
    accepting: BTreeSet<Member>,
    returning: BTreeSet<Member>,
    patience: Duration,
}

/// Something that a person wants to see.
#[derive(Clone, Debug, PartialEq)]
pub enum Happening {
    /// Nobody has the model yet.
    Planned {
        /// Grasps that the shadow stage takes.
        shadow: usize,
        /// Grasps that a stage takes.
        grasps: usize,
    },
    /// This stage begins.
    Stage(usize),
    /// A gripper has said something about the model.
    Reported(Member, Report),
    /// Roll-outs pause at a gripper, or go on there.
    Paused(Member, Option<Paused>),
    /// A gripper did not answer, or said why it cannot; it is asked again.
    Silent(Member, Option<String>),
}

impl Deployer {
    /// A roll-out of the model of `offer`, which begins with the first turn. A gripper goes back by itself where no turn watches it for
    /// the lease of the offer. An answer may take `patience`. Grippers that try this very model go on with their trial: a roll-out whose program has ended
    /// can be taken up again within the lease.
    pub fn new(
        session: Session,
        config: RolloutConfig,
        offer: Offer,
        members: impl IntoIterator<Item = Member>,
        patience: Duration,
    ) -> Self {
        let rollout = Rollout::new(config, members);
        let none = BTreeSet::new;
        Self {
            session,
            offer,
            rollout,
            checking: none(),
            replaying: none(),
            casting: none(),
            taking: none(),
            accepting: none(),
            returning: none(),
            patience,
        }
    }

    /// The same of a roll-out that somebody began at this time of day (ns since 1970), for the histories of the grippers. Where one of them
    /// tries the model already, the roll-out is the one that brought it.
    #[must_use]
    pub fn with_origin(mut self, by: &str, rollout_ns: u64) -> Self {
        self.offer.origin = Origin::new(by, rollout_ns, 0);
        self
    }

    /// Gives orders, watches the trials and hands out what was answered. The clock is read when an answer has come, or patience has ended.
    pub fn turn(&mut self, now_us: &dyn Fn() -> u64) -> Vec<Happening> {
        if self.rollout.plan() {
            let (shadow, _) = self.rollout.shadow();
            let planned = |grasps| Happening::Planned { shadow, grasps };
            return self.rollout.grasps().map(planned).into_iter().collect();
        }
        let mut happenings = Vec::new();
        let before = self.rollout.stage();
        let steps = self.rollout.step();
        if self.rollout.stage() != before {
            happenings.push(Happening::Stage(self.rollout.stage()));
        }
        for order in steps {
            match order {
                rollout::Order::Check(member) => self.checking.insert(member),
                rollout::Order::Replay(member) => self.replaying.insert(member),
                rollout::Order::Shadow(member) => self.casting.insert(member),
                rollout::Order::Take(member) => self.taking.insert(member),
                rollout::Order::Accept(member) => self.accepting.insert(member),
                rollout::Order::GiveBack(member) => {
                    self.taking.remove(&member);
                    self.accepting.remove(&member);
                    self.returning.insert(member)
                }
            };
        }
        if !matches!(self.rollout.progress(), Progress::Checking) {
            self.checking.clear();
        }
        if !matches!(self.rollout.progress(), Progress::Replay) {
            self.replaying.clear();
        }
        if !matches!(self.rollout.progress(), Progress::Shadow) {
            self.casting.clear();
        }
        for some in self.orders().chunks(AT_ONCE) {
            for (member, order, answer) in self.ask(some) {
                if let Ok(standing) = &answer {
                    let paused = standing.paused.clone();
                    if self.rollout.pause(&member, paused.is_some()) {
                        happenings.push(Happening::Paused(member.clone(), paused));
                    }
                }
                happenings.extend(self.receive(member, &order, answer, now_us()));
            }
        }
        happenings
    }

    /// What is to be sent now.
    fn orders(&self) -> Vec<(Member, Order)> {
        let sha256 = || self.offer.sha256.clone();
        let each = |members: &BTreeSet<Member>, order: Order| {
            members.iter().map(move |who| (who.clone(), order.clone())).collect::<Vec<_>>()
        };
        let watch =
            |(who, from): (&Member, usize)| (who.clone(), Order::Watch { sha256: sha256(), from });
        let why = self.rollout.stopped().map(ToString::to_string);
        let back = each(&self.returning, Order::Back { sha256: Some(sha256()), why });
        if !self.rollout.paused().is_empty() && self.checking.is_empty() {
            let watched: Vec<_> = self.rollout.watched().map(watch).collect();
            let is_asked = |who: &&Member| !watched.iter().any(|(member, _)| member == *who);
            let paused = self.rollout.paused().iter().filter(is_asked);
            let paused = paused.map(|who| (who.clone(), Order::Notify)).collect();
            return [back, paused, watched].concat();
        }
        let origin =
            Origin { stage: self.stage().try_into().unwrap_or(0), ..self.offer.origin.clone() };
        let take = Order::Take(Offer { origin, ..self.offer.clone() });
        [
            back,
            each(&self.checking, Order::Check(self.offer.clone())),
            each(&self.replaying, Order::Replay(self.offer.clone())),
            each(&self.casting, Order::Shadow(self.offer.clone())),
            each(&self.taking, take),
            each(&self.accepting, Order::Accept { sha256: sha256() }),
            self.rollout.watched().map(watch).collect(),
        ]
        .concat()
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

    /// The evidence against the model so far.
    #[must_use]
    pub fn evidence(&self) -> Evidence {
        self.rollout.evidence()
    }

    /// What replays of recordings have shown so far.
    #[must_use]
    pub const fn replays(&self) -> Tally {
        self.rollout.replays()
    }

    /// Grasps of the shadow stage, and what they have shown so far.
    #[must_use]
    pub const fn shadow(&self) -> (usize, Tally) {
        self.rollout.shadow()
    }

    /// Grasps of a stage, once everybody has answered.
    #[must_use]
    pub const fn grasps(&self) -> Option<usize> {
        self.rollout.grasps()
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
    ) -> Option<Happening> {
        let report = match (order, answer) {
            (
                Order::Check(_) | Order::Replay(_) | Order::Shadow(_) | Order::Take(_),
                Err(error @ NetError::Declined { .. }),
            ) => Report::Refused(reason(&error)),
            // Its trial has ended.
            (
                Order::Watch { .. } | Order::Accept { .. },
                Err(error @ NetError::Declined { .. }),
            ) => Report::Left(reason(&error)),
            // It is asked again: what cannot be given back now can be later.
            (_, Err(error)) => {
                let reason = match error {
                    NetError::Silent { .. } => None,
                    error => Some(reason(&error)),
                };
                self.rollout.miss(&member, reason.clone(), now_us);
                return Some(Happening::Silent(member, reason));
            }
            // It takes nothing new in a pause, and shows whether that goes on.
            (Order::Notify, Ok(_)) => return None,
            (Order::Shadow(_) | Order::Take(_) | Order::Replay(_), Ok(standing))
                if standing.paused.is_some() && !self.is_there(&standing) =>
            {
                return None;
            }
            (Order::Check(_), Ok(standing)) => self.checked(standing),
            (Order::Replay(_), Ok(standing)) => match standing.replay {
                Some(replay) if !replay.running => Report::Replayed(replay.rehearsal),
                _ => Report::Replaying,
            },
            (Order::Shadow(_), Ok(_)) => Report::Beside,
            (Order::Take(_), Ok(standing)) if standing.trial.is_none() => Report::Had,
            (Order::Take(_), Ok(standing)) => Report::Taken(standing.grasps),
            (Order::Watch { from, sha256 }, Ok(standing)) => watched(*from, sha256, standing),
            (Order::Accept { .. }, Ok(_)) => Report::Kept,
            (_, Ok(_)) => Report::Back,
        };
        match order {
            Order::Check(_) => self.checking.remove(&member),
            Order::Replay(_) => report != Report::Replaying && self.replaying.remove(&member),
            Order::Shadow(_) => self.casting.remove(&member),
            Order::Take(_) => self.taking.remove(&member),
            Order::Accept { .. } => self.accepting.remove(&member),
            Order::Back { .. } => self.returning.remove(&member),
            _ => false,
        };
        self.rollout.receive(&member, report.clone(), now_us);
        Some(Happening::Reported(member, report))
    }

    /// Whether the model is in force there, or estimates beside the one in force.
    fn is_there(&self, standing: &Standing) -> bool {
        let shadow = standing.shadow.as_ref().map(|shadow| &shadow.model);
        [Some(&standing.in_force), shadow]
            .into_iter()
            .flatten()
            .any(|model| model.sha256 == self.offer.sha256)
    }

    /// The answer of one that would take the model.
    fn checked(&mut self, standing: Standing) -> Report {
        if let Some(entry) = standing.history.first() {
            self.offer.origin.rollout_ns = entry.origin.rollout_ns;
        }
        let is_ours = |model: &ModelId| model.sha256 == self.offer.sha256;
        if standing.trial.is_some() && is_ours(&standing.in_force) {
            Report::Trying(standing.grasps)
        } else if is_ours(&standing.in_force) {
            Report::Had
        } else if is_ours(&standing.configured) || standing.before.as_ref().is_some_and(is_ours) {
            Report::Known
        } else {
            Report::Fit(standing.grasps)
        }
    }
}

/// The answer to a look at a trial.
fn watched(from: usize, sha256: &str, standing: Standing) -> Report {
    let grasps = standing.grasps;
    match (standing.trial, standing.shadow) {
        (_, Some(shadow)) if shadow.model.sha256 == sha256 => Report::Compared { from, grasps },
        (Some(_), _) => Report::Grasps { from, grasps },
        (None, _) => Report::Kept,
    }
}

/// What a gripper reports of its models, once it has obeyed the order.
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
    let replayed = standing.replay.iter().flat_map(|replay| &replay.rehearsal.grasps);
    if standing.grasps.iter().chain(replayed).all(Grasp::is_sane) {
        Ok(standing)
    } else {
        Err(unusable("it cannot have measured such grasps".to_owned()))
    }
}

/// What a gripper said, without its name, which stands before it already.
fn reason(error: &NetError) -> String {
    match error {
        NetError::Declined { reason, .. } | NetError::Unusable { reason, .. } => reason.clone(),
        other => other.to_string(),
    }
}
