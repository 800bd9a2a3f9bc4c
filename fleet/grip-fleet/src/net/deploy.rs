//! [`Rollout`] over a network, with a session, a model and a clock: who has taken the model, how it does there and who gives it back.
//!
//! Nothing here reads a clock of its own. Many grippers are asked at once; one that does not answer is asked again with the next turn, since each order
//! may come twice.

use super::{Ask, NetError, ask};
use crate::{
    deploy::{ModelId, Offer, Order, Origin, Paused, Standing},
    key::{Member, Part},
    rollout::{self, Grasp, Progress, Report, Rollout, RolloutConfig},
};
use core::time::Duration;
use std::thread;
use zenoh::Session;

/// Grippers that are asked at once.
const AT_ONCE: usize = 32;

/// A model for many grippers.
#[derive(Debug)]
pub struct Deployer {
    session: Session,
    offer: Offer,
    rollout: Rollout,
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
        Self { session, offer, rollout: Rollout::new(config, members), patience }
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
        self.rollout.step();
        if self.rollout.stage() != before {
            happenings.push(Happening::Stage(self.rollout.stage()));
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
        let (offer, rollout) = (&self.offer, &self.rollout);
        let sha256 = || offer.sha256.clone();
        let waits = !rollout.paused().is_empty() && rollout.progress() != Progress::Checking;
        let why = rollout.stopped().map(ToString::to_string);
        let stage = rollout.stage().try_into().unwrap_or(0);
        let open = rollout.open().filter_map(|(who, order)| {
            if waits && order != rollout::Order::GiveBack {
                return None;
            }
            let order = match order {
                rollout::Order::GiveBack => {
                    Order::Back { sha256: Some(sha256()), why: why.clone() }
                }
                rollout::Order::Check => Order::Check(offer.clone()),
                rollout::Order::Replay => Order::Replay(offer.clone()),
                rollout::Order::Shadow => Order::Shadow(offer.clone()),
                rollout::Order::Take => {
                    let origin = Origin { stage, ..offer.origin.clone() };
                    Order::Take(Offer { origin, ..offer.clone() })
                }
                rollout::Order::Accept => Order::Accept { sha256: sha256() },
            };
            Some((who, order))
        });
        let watched = rollout.watched();
        let watch =
            |(who, from): (&Member, usize)| (who.clone(), Order::Watch { sha256: sha256(), from });
        let mut orders: Vec<_> = open.chain(watched.map(watch)).collect();
        if waits {
            // They show when that is over.
            let is_asked = |who: &Member| orders.iter().any(|(member, _)| member == who);
            let others: Vec<_> = rollout.paused().iter().filter(|who| !is_asked(who)).collect();
            orders.extend(others.into_iter().map(|who| (who.clone(), Order::Notify)));
        }
        orders
    }

    /// How the roll-out stands.
    #[must_use]
    pub const fn rollout(&self) -> &Rollout {
        &self.rollout
    }

    /// Stops it; the next turn asks for the model back.
    pub fn abort(&mut self) {
        self.rollout.abort();
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
    let (part, parameters, payload) = (Part::Model, &*parameters, order.payload());
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
