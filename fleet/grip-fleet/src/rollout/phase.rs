//! Where each gripper of a roll-out is, and the grasps of those that are watched.

use super::{Bets, Grasp, Order};

/// One gripper in the roll-out.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Phase {
    /// It has not been asked anything.
    New,
    /// It was asked whether it would take the model.
    Checked,
    /// It replays its recordings with the model.
    Replaying,
    /// It was ordered to let the model estimate beside the one in force.
    Cast,
    /// The model estimates beside the one in force there.
    Beside(Watched),
    /// It would take the model.
    Waiting {
        /// It has tried it on its recordings.
        replayed: bool,
    },
    /// It would take the model without a trial.
    Known,
    /// It was ordered to take the model.
    Asked,
    /// It tries the model.
    Running(Box<Running>),
    /// It was ordered to keep the model.
    Accepting,
    Good,
    /// It had the model before, and keeps it.
    Had,
    /// It was ordered to give it back.
    Returning,
    /// It has the model of before, because it refused, gave back, or never answered.
    Back,
}

/// Grasps of a gripper that is watched.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Watched {
    /// How many are known.
    pub(super) now: usize,
    /// When it finished one last, and how long it had finished none when it answered last (us).
    pub(super) grasped_us: u64,
    pub(super) idle_us: u64,
}

impl Watched {
    pub(super) const fn new(now_us: u64) -> Self {
        Self { now: 0, grasped_us: now_us, idle_us: 0 }
    }

    /// None of its grasps is taken: it is not idle.
    pub(super) const fn rest(&mut self, now_us: u64) {
        (self.grasped_us, self.idle_us) = (now_us, 0);
    }

    /// Those that are not known yet; what is known already is skipped, and nothing is taken behind a gap.
    pub(super) fn take(
        &mut self,
        from: usize,
        grasps: &[Grasp],
        now_us: u64,
    ) -> Vec<(usize, Grasp)> {
        let known = self.now.checked_sub(from).unwrap_or(grasps.len());
        let new: Vec<Grasp> = grasps.iter().skip(known).copied().collect();
        let first = self.now;
        if !new.is_empty() {
            self.now += new.len();
            self.grasped_us = now_us;
        }
        self.idle_us = now_us.saturating_sub(self.grasped_us);
        (first..).zip(new).collect()
    }
}

/// A gripper that tries the model.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Running {
    pub(super) before: Vec<Grasp>,
    /// Earlier grasps that each new one is compared with.
    pub(super) per: usize,
    /// Grasps with the new model, and the bets on them.
    pub(super) watched: Watched,
    pub(super) bets: Bets,
}

impl Phase {
    pub(super) const WAITING: Self = Self::Waiting { replayed: false };

    /// The order that leads into this phase, as long as it is not answered.
    pub(super) const fn order(&self) -> Option<Order> {
        Some(match self {
            Self::Checked => Order::Check,
            Self::Replaying => Order::Replay,
            Self::Cast => Order::Shadow,
            Self::Asked => Order::Take,
            Self::Accepting => Order::Accept,
            Self::Returning => Order::GiveBack,
            _ => return None,
        })
    }

    pub(super) const fn is_open_question(&self) -> bool {
        matches!(self, Self::New | Self::Checked)
    }

    pub(super) const fn is_waiting(&self) -> bool {
        matches!(self, Self::Waiting { .. })
    }

    pub(super) const fn is_replaying(&self) -> bool {
        matches!(self, Self::Replaying)
    }

    pub(super) const fn is_shadow(&self) -> bool {
        matches!(self, Self::Cast | Self::Beside(_))
    }

    /// It has got the model by this roll-out, or is getting it.
    pub(super) const fn is_reached(&self) -> bool {
        matches!(self, Self::Asked | Self::Running(_) | Self::Accepting | Self::Good)
    }

    pub(super) const fn is_done(&self) -> bool {
        matches!(self, Self::Good | Self::Had)
    }
}
