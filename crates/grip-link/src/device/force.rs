//! The force for the actuator, from GRIP commands and time: the rules R1 to R5 of the failsafe.
//!
//! Force rises only while a command is fresh (age <= ttl). Then it stays, falling to the hold cap where it
//! is above; after the loss delay the configured loss action follows. All changes of force keep the slew.

use core::num::NonZero;

use crate::message::{Config, ForceClamp, Grip, GripMode, Limits, LossAction};

/// Longest step of time in which the force moves: a firmware task that was late does not catch up with a jump.
const LONGEST_STEP_MS: u64 = 10;

/// What the actuator is to do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Drive {
    /// Torque off.
    Passive,
    /// Press with this force \[mN\].
    Force(i32),
    /// Open the fingers.
    Open,
}

impl Drive {
    /// Force \[mN\]; 0 when passive or opening.
    #[must_use]
    pub const fn force_mn(self) -> i32 {
        match self {
            Self::Force(force_mn) => force_mn,
            Self::Passive | Self::Open => 0,
        }
    }
}

/// How the last command stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Phase {
    /// No command is followed and nothing runs out.
    Rest,
    /// A fresh command is followed until this tick.
    Active { until: u64 },
    /// Nothing fresh since this tick.
    Hold { since: u64 },
    /// The loss action was taken.
    Lost,
}

/// What became of a GRIP.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Taken {
    Accepted,
    /// Older than or equal to the newest: ignored.
    Old,
    Rejected,
}

#[derive(Debug, Clone)]
pub(crate) struct ForceGuard {
    tick_hz: NonZero<u64>,
    config: Config,
    goal: Drive,
    phase: Phase,
    applied_mn: i32,
    slew_mn_s: u32,
    updated: u64,
    /// Change of force that time has allowed and not yet used, in mN * ticks / s.
    credit: u64,
    last: Option<(u32, u64)>,
    clamp: ForceClamp,
    at_travel_end: bool,
}

impl ForceGuard {
    pub(crate) const fn new(tick_hz: NonZero<u64>, limits: &Limits) -> Self {
        let config = Config {
            sample_rate_hz: limits.rate_max_hz,
            batch: 1,
            format: crate::message::SampleFormat::I16,
            ttl_ms: Config::TTL_MIN_MS,
            channel_mask: 0,
            force_max_mn: limits.force_max_mn,
            slew_mn_s: limits.slew_max_mn_s,
            hold_cap_mn: limits.hold_cap_mn,
            loss_after_ms: 1000,
            loss_action: LossAction::Hold,
        };
        Self {
            tick_hz,
            config,
            goal: Drive::Passive,
            phase: Phase::Rest,
            applied_mn: 0,
            slew_mn_s: limits.slew_max_mn_s,
            updated: 0,
            credit: 0,
            last: None,
            clamp: ForceClamp(0),
            at_travel_end: false,
        }
    }

    const fn ticks(&self, ms: u16) -> u64 {
        self.tick_hz.get() * ms as u64 / 1000
    }

    /// New limits; command numbers start afresh, the force stays as it is.
    pub(crate) fn arm(&mut self, config: &Config) {
        self.config = *config;
        self.last = None;
        self.clamp = ForceClamp(0);
        self.limit_goal(config.force_max_mn);
    }

    pub(crate) const fn phase(&self) -> Phase {
        self.phase
    }

    pub(crate) const fn goal(&self) -> Drive {
        self.goal
    }

    pub(crate) const fn applied_mn(&self) -> i32 {
        self.applied_mn
    }

    pub(crate) const fn clamp(&self) -> ForceClamp {
        self.clamp
    }

    /// Number and tick of the newest accepted command.
    pub(crate) const fn last(&self) -> Option<(u32, u64)> {
        self.last
    }

    pub(crate) const fn set_travel_end(&mut self, at_end: bool) {
        self.at_travel_end = at_end;
    }

    pub(crate) fn reject(&mut self) {
        self.clamp = self.clamp.with(ForceClamp::REJECTED, true);
    }

    pub(crate) fn command(&mut self, tick: u64, grip: &Grip) -> Taken {
        let newer = |(id, _): (u32, u64)| (1..1 << 31).contains(&grip.cmd_id.wrapping_sub(id));
        if !self.last.is_none_or(newer) {
            return Taken::Old;
        }
        let Some(mode) = GripMode::from_code(grip.mode).filter(|_| grip.force_mn >= 0) else {
            self.reject();
            return Taken::Rejected;
        };
        let ttl_ms = match grip.ttl_ms {
            0 => self.config.ttl_ms,
            ms => ms.clamp(Config::TTL_MIN_MS, Config::TTL_MAX_MS),
        };
        let force_mn = grip.force_mn.min(self.config.force_max_mn);
        self.slew_mn_s = match grip.slew_mn_s {
            0 => self.config.slew_mn_s,
            slew => slew.min(self.config.slew_mn_s),
        };
        self.clamp = ForceClamp(0)
            .with(ForceClamp::FORCE, force_mn < grip.force_mn)
            .with(ForceClamp::SLEW, self.slew_mn_s < grip.slew_mn_s)
            .with(ForceClamp::TTL, grip.ttl_ms != 0 && ttl_ms != grip.ttl_ms);
        self.goal = match mode {
            GripMode::Force => Drive::Force(force_mn),
            GripMode::Open => Drive::Open,
            GripMode::Passive => Drive::Passive,
        };
        self.last = Some((grip.cmd_id, tick));
        self.phase = Phase::Active { until: tick.saturating_add(self.ticks(ttl_ms)) };
        Taken::Accepted
    }

    fn limit_goal(&mut self, most_mn: i32) -> bool {
        match self.goal {
            Drive::Force(target) if target > most_mn => {
                self.goal = Drive::Force(most_mn);
                true
            }
            _ => false,
        }
    }

    /// Stops rising: the force stays, at most at the hold cap. The loss delay starts when a command was followed.
    pub(crate) fn hold(&mut self, since: u64) {
        if matches!(self.phase, Phase::Active { .. }) {
            self.phase = Phase::Hold { since };
        }
        self.stay();
    }

    /// Stops everything that moves, without a loss action later.
    pub(crate) fn freeze(&mut self) {
        self.phase = Phase::Rest;
        if self.goal == Drive::Open {
            self.goal = Drive::Passive;
        }
        self.stay();
    }

    fn stay(&mut self) {
        self.limit_goal(self.applied_mn);
        let capped = self.limit_goal(self.config.hold_cap_mn);
        self.clamp = self.clamp.with(ForceClamp::HOLD_CAP, capped);
    }

    /// The loss action is under way: nothing runs out any more.
    pub(crate) const fn settle(&mut self) {
        self.phase = Phase::Rest;
    }

    /// The fingers press with this force already.
    pub(crate) fn resume(&mut self, force_mn: i32) {
        self.applied_mn = force_mn.max(0);
        self.goal = Drive::Force(self.applied_mn);
    }

    /// Torque off.
    pub(crate) fn release(&mut self) {
        self.phase = Phase::Rest;
        self.goal = Drive::Passive;
        self.applied_mn = 0;
    }

    /// Lets commands run out and moves the force towards its goal.
    pub(crate) fn advance(&mut self, tick: u64) -> Drive {
        let step =
            tick.saturating_sub(self.updated).min(self.tick_hz.get() * LONGEST_STEP_MS / 1000);
        self.updated = self.updated.max(tick);
        self.expire(tick);
        let Drive::Force(target) = self.goal else {
            self.applied_mn = 0;
            self.credit = 0;
            return self.goal;
        };
        let blocked = self.at_travel_end && target > self.applied_mn;
        self.clamp =
            ForceClamp(self.clamp.0 & !ForceClamp::TRAVEL.0).with(ForceClamp::TRAVEL, blocked);
        if blocked || target == self.applied_mn {
            self.credit = 0;
            return Drive::Force(self.applied_mn);
        }
        self.credit = self.credit.saturating_add(step.saturating_mul(u64::from(self.slew_mn_s)));
        let allowed = i32::try_from(self.credit / self.tick_hz).unwrap_or(i32::MAX);
        self.credit %= self.tick_hz;
        let change = target.saturating_sub(self.applied_mn).clamp(-allowed, allowed);
        self.applied_mn = self.applied_mn.saturating_add(change);
        Drive::Force(self.applied_mn)
    }

    fn expire(&mut self, tick: u64) {
        if let Phase::Active { until } = self.phase
            && tick > until
        {
            self.hold(until);
        }
        if let Phase::Hold { since } = self.phase
            && tick.saturating_sub(since) >= self.ticks(self.config.loss_after_ms)
        {
            self.phase = Phase::Lost;
            if matches!(self.goal, Drive::Force(_)) {
                match self.config.loss_action {
                    LossAction::Hold => {}
                    LossAction::Open => self.goal = Drive::Open,
                    LossAction::Passive => self.goal = Drive::Passive,
                }
            }
        }
    }
}
