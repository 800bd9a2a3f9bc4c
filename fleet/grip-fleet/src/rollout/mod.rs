//! Plan of a roll-out, by what each gripper reports: who gets a new model next, and who gives it back. No network and no clock.
//!
//! Everybody is asked whether it would take the model, before anybody has it, and replays its own recordings with it. Then it estimates beside the
//! model in force at all of them, and moves nothing ([`ShadowConfig`]). Then one gripper tries it, then some, then all. A stage is over when each of
//! its grippers has made its share of the grasps of a stage. The grasps of all grippers that try the model are judged together ([`JudgeConfig`]).
//! After the last stage everybody is ordered to keep the model. Until then whoever tries it goes back by itself where nobody watches it any more. With the first refusal, the first evidence that the model is worse and the first gripper that gives no answer the
//! roll-out stops, and everybody who has taken the model gives it back.

mod grasp;
mod judge;
mod phase;
mod report;
mod shadow;

pub use grasp::{Finished, Grasp, GraspLog, Rehearsal};
pub use judge::{Bets, Difference, Draws, Evidence, JudgeConfig, MOST_GRASPS, Worse, per};
pub use report::{Order, Progress, Report, Stop};
pub use shadow::{Compared, ShadowConfig, Tally, Wrong};

use crate::key::Member;
use phase::{Phase, Running, Watched};
use std::collections::{BTreeMap, BTreeSet};

/// Each gripper of a stage makes at least so many grasps.
const LEAST_GRASPS: usize = 3;

/// How a roll-out goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RolloutConfig {
    /// Share of all grippers in the second stage, 0 to 1; one at least.
    pub some: f64,
    /// When a model is worse.
    pub judge: JudgeConfig,
    /// What is to be noticed; it sets how many grasps a stage takes.
    pub difference: Difference,
    /// Grasps of a stage, where that is not to be computed.
    pub grasps: Option<usize>,
    /// Whether the grippers replay their own recordings with the model first.
    pub replay: bool,
    /// Grasps of the shadow stage, where that is not to be computed; 0 leaves it out.
    pub shadow: Option<usize>,
    /// A gripper that has answered no question for so long, the first and the last of them, is gone (us).
    pub silence_us: u64,
    /// One that tries the model and finishes no grasp for so long shows nothing about it (us).
    pub idle_us: u64,
}

impl Default for RolloutConfig {
    /// A fifth of all, a minute, an hour.
    fn default() -> Self {
        let (judge, difference) = (JudgeConfig::default(), Difference::default());
        let (silence_us, idle_us) = (60_000_000, 3_600_000_000);
        Self {
            some: 0.2,
            judge,
            difference,
            grasps: None,
            replay: true,
            shadow: None,
            silence_us,
            idle_us,
        }
    }
}

impl RolloutConfig {
    /// When the model is stopped as a shadow.
    const fn shadow(&self) -> ShadowConfig {
        ShadowConfig { alpha: self.judge.alpha, most: self.difference.force }
    }
}

/// Questions to one gripper without an answer.
#[derive(Clone, Debug)]
struct Silence {
    /// When the first and the last of them ended (us).
    first_us: u64,
    last_us: u64,
    /// What came instead of the last answer.
    reason: Option<String>,
}

/// A roll-out to some grippers.
#[derive(Clone, Debug, Default)]
pub struct Rollout {
    config: RolloutConfig,
    members: BTreeMap<Member, Phase>,
    silent: BTreeMap<Member, Silence>,
    /// Grasps with the models of before, as of the first answers.
    before: BTreeMap<Member, Vec<Grasp>>,
    /// Grasps of a stage, once everybody has answered; and of each gripper of this stage.
    grasps: Option<usize>,
    share: usize,
    stage: usize,
    /// Grasps of the shadow stage, and what they showed.
    shadow: usize,
    tally: Tally,
    /// Whether recordings are to be replayed, and what they showed.
    replay: bool,
    replays: Tally,
    /// Those at which roll-outs pause.
    paused: BTreeSet<Member>,
    stop: Option<Stop>,
}

impl Rollout {
    /// A roll-out that begins with the next [`Rollout::step`].
    pub fn new(config: RolloutConfig, members: impl IntoIterator<Item = Member>) -> Self {
        let members = members.into_iter().map(|member| (member, Phase::New)).collect();
        let shadow = config.shadow.unwrap_or_else(|| config.shadow().needed());
        Self { config, members, shadow, replay: config.replay, ..Self::default() }
    }

    /// A gripper was asked and has not answered, or with something that is no answer; it is to be asked again.
    pub fn miss(&mut self, member: &Member, reason: Option<String>, now_us: u64) {
        if self.members.contains_key(member) {
            let first_us = self.silent.get(member).map_or(now_us, |silence| silence.first_us);
            self.silent.insert(member.clone(), Silence { first_us, last_us: now_us, reason });
        }
    }

    /// Roll-outs pause at a gripper, or do not any more. Where one pauses, nobody gets the model, and no grasp is judged. Whether that is new.
    pub fn pause(&mut self, member: &Member, is_paused: bool) -> bool {
        if is_paused && self.members.contains_key(member) {
            self.paused.insert(member.clone())
        } else {
            self.paused.remove(member)
        }
    }

    /// Those at which roll-outs pause.
    #[must_use]
    pub const fn paused(&self) -> &BTreeSet<Member> {
        &self.paused
    }

    /// Takes the report of a gripper; one that is not in this roll-out changes nothing.
    pub fn receive(&mut self, member: &Member, report: Report, now_us: u64) {
        let Some(phase) = self.members.get_mut(member) else { return };
        self.silent.remove(member);
        let is_paused = !self.paused.is_empty();
        match (report, phase) {
            // They are asked for again.
            (Report::Compared { .. }, Phase::Beside(watched)) if is_paused => watched.rest(now_us),
            (Report::Grasps { .. }, Phase::Running(running)) if is_paused => {
                running.watched.rest(now_us);
            }
            (Report::Fit(before), phase @ Phase::Checked) => {
                self.before.insert(member.clone(), before);
                *phase = Phase::WAITING;
            }
            (Report::Trying(before), phase @ Phase::Checked) => {
                self.before.insert(member.clone(), before);
                // Whoever began it has seen the replays and the end of the shadow stage.
                (self.replay, self.shadow) = (false, 0);
                *phase = Phase::WAITING;
            }
            (Report::Replayed(rehearsal), phase @ Phase::Replaying) => {
                *phase = Phase::Waiting { replayed: true };
                let shadow = self.config.shadow();
                for grasp in &rehearsal.grasps {
                    if let Some(what) = self.replays.take(grasp, &shadow) {
                        let tally = self.replays;
                        self.stop.get_or_insert(Stop::Replayed { what, tally });
                    }
                }
            }
            (Report::Beside, phase @ Phase::Cast) => *phase = Phase::Beside(Watched::new(now_us)),
            (Report::Compared { from, grasps }, Phase::Beside(watched)) => {
                let shadow = self.config.shadow();
                for (_, grasp) in watched.take(from, &grasps, now_us) {
                    if let Some(what) = self.tally.take(&grasp, &shadow) {
                        let tally = self.tally;
                        self.stop.get_or_insert(Stop::Wrong { what, tally });
                    }
                }
            }
            (Report::Known, phase @ Phase::Checked) => *phase = Phase::Known,
            (Report::Taken(before), phase @ Phase::Asked) => {
                let (per, bets) = (per(before.len(), self.share), Bets::default());
                let running = Running { before, per, watched: Watched::new(now_us), bets };
                *phase = Phase::Running(Box::new(running));
            }
            (Report::Had, phase @ (Phase::Checked | Phase::Asked)) => *phase = Phase::Had,
            (Report::Kept, phase @ (Phase::Asked | Phase::Running(_) | Phase::Accepting)) => {
                *phase = Phase::Good;
            }
            (
                Report::Refused(reason),
                phase @ (Phase::Checked | Phase::Replaying | Phase::Cast | Phase::Asked),
            ) => {
                *phase = Phase::Back;
                self.stop(Stop::Refused { member: member.clone(), reason });
            }
            (Report::Grasps { from, grasps }, Phase::Running(running)) => {
                let Running { before, per, watched, bets } = &mut **running;
                for (number, grasp) in watched.take(from, &grasps, now_us) {
                    if let Some(before) = before.chunks_exact((*per).max(1)).nth(number) {
                        bets.compare(&grasp, before, self.config.judge.margin);
                    }
                }
                self.judge();
            }
            // Its shadow has ended.
            (Report::Left(_), phase @ Phase::Beside(_)) => *phase = Phase::WAITING,
            (Report::Left(reason), phase) if phase.is_reached() => {
                *phase = Phase::Back;
                self.stop(Stop::Left { member: member.clone(), reason });
            }
            (Report::Back | Report::Left(_), phase @ Phase::Returning) => *phase = Phase::Back,
            _ => {}
        }
    }

    /// Stops it where the grasps of all who try the model show that it is worse.
    fn judge(&mut self) {
        let evidence = self.evidence();
        if let Some(what) = self.config.judge.judge(&evidence) {
            self.stop(Stop::Worse { what, grasps: evidence.grasps });
        }
    }

    /// The evidence against the model so far.
    #[must_use]
    pub fn evidence(&self) -> Evidence {
        let mut all = Bets::default();
        for phase in self.members.values() {
            if let Phase::Running(running) = phase {
                all.add(&running.bets);
            }
        }
        all.evidence()
    }

    /// Grasps of a stage, once everybody has answered.
    #[must_use]
    pub const fn grasps(&self) -> Option<usize> {
        self.grasps
    }

    /// What is to be ordered of whom, by what was reported until now.
    pub fn step(&mut self) -> Vec<(Member, Order)> {
        self.look();
        // Where somebody refuses it, all the others are still asked, so that all reasons are reported at once.
        if self.is_checking() {
            return self.order(usize::MAX, &Phase::Checked, |phase| *phase == Phase::New);
        }
        self.plan();
        if self.stop.is_some() {
            // Everybody who has the model, or may have it, also beside the one in force.
            let has = |phase: &Phase| phase.is_reached() || phase.is_shadow();
            return self.order(usize::MAX, &Phase::Returning, has);
        }
        if !self.paused.is_empty() {
            return Vec::new();
        }
        let known = self.order(usize::MAX, &Phase::Asked, |phase| *phase == Phase::Known);
        if !known.is_empty() {
            return known;
        }
        if self.replay {
            // Everybody who would take the model replays its recordings first, once.
            let new = |phase: &Phase| *phase == Phase::WAITING;
            let orders = self.order(usize::MAX, &Phase::Replaying, new);
            if !orders.is_empty() || self.members.values().any(Phase::is_replaying) {
                return orders;
            }
            self.replay = false;
        }
        if self.tally.grasps < self.shadow {
            return self.cast();
        }
        for phase in self.members.values_mut().filter(|phase| phase.is_shadow()) {
            *phase = Phase::WAITING;
        }
        let (reached, waiting) = (self.count(Phase::is_reached), self.count(Phase::is_waiting));
        let share = self.share;
        let is_open = |phase: &Phase| match phase {
            Phase::Asked => true,
            Phase::Running(running) => running.watched.now < share,
            _ => false,
        };
        if self.members.values().any(is_open) {
            return Vec::new();
        }
        if waiting == 0 {
            let tries = |phase: &Phase| matches!(phase, Phase::Running(_));
            return self.order(usize::MAX, &Phase::Accepting, tries);
        }
        // Where the first one to try it had it already, another one is the first.
        self.stage = if reached == 0 { 1 } else { self.stage + 1 };
        let more = self.goal(reached + waiting).saturating_sub(reached).max(1).min(waiting);
        self.share = self.grasps.unwrap_or_default().div_ceil(more).max(LEAST_GRASPS);
        self.order(more, &Phase::Asked, Phase::is_waiting)
    }

    /// The first `count` of those who are meant go on to the next phase, by an order.
    fn order(
        &mut self,
        count: usize,
        next: &Phase,
        is_meant: impl Fn(&Phase) -> bool,
    ) -> Vec<(Member, Order)> {
        let meant = self.members.iter_mut().filter(|(_, phase)| is_meant(phase)).take(count);
        let ordered = meant.filter_map(|(member, phase)| {
            *phase = next.clone();
            Some((member.clone(), next.order()?))
        });
        ordered.collect()
    }

    /// Orders that were given and not answered yet; each may be given again.
    pub fn open(&self) -> impl Iterator<Item = (Member, Order)> {
        let stops = self.stop.is_some();
        let counts =
            move |phase: &Phase| !stops || matches!(phase, Phase::Checked | Phase::Returning);
        let open = self.members.iter().filter(move |(_, phase)| counts(phase));
        open.filter_map(|(member, phase)| Some((member.clone(), phase.order()?)))
    }

    /// Everybody who would take the model lets it estimate first.
    fn cast(&mut self) -> Vec<(Member, Order)> {
        let orders = self.order(usize::MAX, &Phase::Cast, Phase::is_waiting);
        // Nobody is left to compare anything.
        if orders.is_empty() && !self.members.values().any(Phase::is_shadow) {
            self.shadow = 0;
        }
        orders
    }

    /// Computes how many grasps a stage takes, as soon as everybody has answered; each must have made as many before. Whether that is known
    /// now; [`Rollout::step`] does it where nobody has.
    pub fn plan(&mut self) -> bool {
        let over = self.is_checking() || self.stop.is_some() || self.before.is_empty();
        if over || self.grasps.is_some() {
            return false;
        }
        let RolloutConfig { judge, difference, grasps, .. } = &self.config;
        let all = self.before.values().flatten().copied().collect::<Vec<_>>();
        let least = self.before.iter().min_by_key(|(_, grasps)| grasps.len());
        let each = least.map_or(0, |(_, grasps)| grasps.len());
        let wanted = grasps.or_else(|| judge.needed(&all, each, difference));
        let few = least.filter(|(_, grasps)| grasps.len() < wanted.unwrap_or(LEAST_GRASPS));
        let few = few.map(|(member, grasps)| (member.clone(), grasps.len()));
        match (wanted, few) {
            (Some(wanted), None) => self.grasps = Some(wanted),
            (wanted, Some((member, has))) => {
                self.stop(Stop::Few { member, has, wanted: wanted.unwrap_or(LEAST_GRASPS) });
            }
            (None, None) => self.stop(Stop::Blind),
        }
        self.grasps.is_some()
    }

    /// Whether no stage has begun, and somebody would try the model.
    fn is_early(&self) -> bool {
        let would = |phase: &Phase| phase.is_waiting() || phase.is_replaying() || phase.is_shadow();
        self.stage == 0 && self.members.values().any(would)
    }

    /// Whether somebody has not answered yet whether it would take the model.
    fn is_checking(&self) -> bool {
        self.members.values().any(Phase::is_open_question)
    }

    fn count(&self, is: impl Fn(&Phase) -> bool) -> usize {
        self.members.values().filter(|phase| is(phase)).count()
    }

    /// Which stage it is in or was in; 0 before the first.
    #[must_use]
    pub const fn stage(&self) -> usize {
        self.stage
    }

    /// Where it is.
    #[must_use]
    pub fn progress(&self) -> Progress {
        if self.is_checking() {
            Progress::Checking
        } else if self.stop.is_some() {
            Progress::Stopped(self.holding().count())
        } else if self.members.values().all(Phase::is_done) {
            Progress::Done
        } else if self.replay && self.is_early() {
            Progress::Replay
        } else if self.tally.grasps < self.shadow && self.is_early() {
            Progress::Shadow
        } else if self.members.values().any(|phase| *phase == Phase::Accepting) {
            Progress::Accepting
        } else {
            Progress::Stage(self.stage.max(1))
        }
    }

    /// Why it was stopped.
    #[must_use]
    pub const fn stopped(&self) -> Option<&Stop> {
        self.stop.as_ref()
    }

    /// Who was ordered to take the model, or may have it by this roll-out, and has not given it back.
    pub fn holding(&self) -> impl Iterator<Item = &Member> {
        let stops = self.stop.is_some();
        let holding = move |phase: &Phase| {
            phase.is_reached() || *phase == Phase::Returning || stops && phase.is_shadow()
        };
        self.members.iter().filter(move |(_, phase)| holding(phase)).map(|(member, _)| member)
    }

    /// How many grasps of a gripper that has the model are known; `None` for one that is not to be watched.
    #[must_use]
    pub fn known(&self, member: &Member) -> Option<usize> {
        match self.members.get(member)? {
            Phase::Running(running) => Some(running.watched.now),
            Phase::Beside(watched) => Some(watched.now),
            // None of these is wanted any more.
            Phase::Good => Some(usize::MAX),
            _ => None,
        }
    }

    /// Who is to be watched: it has the model, or lets it estimate beside the one in force.
    pub fn watched(&self) -> impl Iterator<Item = (&Member, usize)> {
        self.members.keys().filter_map(|member| Some((member, self.known(member)?)))
    }

    /// What replays of recordings have shown so far.
    #[must_use]
    pub const fn replays(&self) -> Tally {
        self.replays
    }

    /// Grasps of the shadow stage, and what they have shown so far.
    #[must_use]
    pub const fn shadow(&self) -> (usize, Tally) {
        (self.shadow, self.tally)
    }

    /// Stops it; the next step asks for the model back.
    pub fn abort(&mut self) {
        let ignored = self.members.values_mut().filter(|phase| phase.is_open_question());
        ignored.for_each(|phase| *phase = Phase::Back);
        self.stop(Stop::Ordered);
    }

    /// How many have got the model, of all who did not have it before, when the stage is over.
    fn goal(&self, all: usize) -> usize {
        match self.stage {
            1 => 1,
            2 => self.share(all) + 1,
            _ => all,
        }
    }

    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a share of a small count; the cast saturates"
    )]
    fn share(&self, all: usize) -> usize {
        (self.config.some.clamp(0.0, 1.0) * all as f64).ceil() as usize
    }

    /// The first reason counts.
    fn stop(&mut self, reason: Stop) {
        self.stop.get_or_insert(reason);
    }

    /// Who has been silent, or idle, for too long.
    fn look(&mut self) {
        let RolloutConfig { silence_us, idle_us, .. } = self.config;
        let late = |silence: &&Silence| silence.last_us - silence.first_us > silence_us;
        let awake =
            |phase: &Phase| matches!(phase, Phase::Beside(watched) if watched.idle_us <= idle_us);
        let all_idle = !self.members.values().any(awake);
        let mut why = None;
        for (member, phase) in &mut self.members {
            let stop = match (&*phase, self.silent.get(member).filter(late)) {
                (
                    Phase::Checked
                    | Phase::Replaying
                    | Phase::Cast
                    | Phase::Beside(_)
                    | Phase::Asked
                    | Phase::Running(_)
                    | Phase::Accepting,
                    Some(silence),
                ) => Stop::Gone { member: member.clone(), reason: silence.reason.clone() },
                (Phase::Running(running), None) if running.watched.idle_us > idle_us => {
                    Stop::Idle { member: member.clone() }
                }
                // Others may grasp meanwhile.
                (Phase::Beside(_), None) if all_idle => Stop::Idle { member: member.clone() },
                _ => continue,
            };
            if *phase == Phase::Checked {
                *phase = Phase::Back;
            }
            why.get_or_insert(stop);
        }
        if let Some(stop) = why {
            self.stop(stop);
        }
    }
}

#[cfg(test)]
mod tests;
