//! What a roll-out orders, what grippers report, where it is, and why it was stopped.

use super::{Grasp, MOST_GRASPS, Rehearsal, Tally, Worse, Wrong};
use crate::key::Member;

/// What a gripper is ordered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// Would you take the new model?
    Check,
    /// Replay your recordings with it.
    Replay,
    /// Let it estimate beside the model in force.
    Shadow,
    /// Take it and try it.
    Take,
    /// Keep it.
    Accept,
    /// Go back to the one before.
    GiveBack,
}

/// What a gripper reports.
#[derive(Clone, Debug, PartialEq)]
pub enum Report {
    /// It would take the model; its grasps with the one in force.
    Fit(Vec<Grasp>),
    /// It is on trial with this model already; its grasps before it.
    Trying(Vec<Grasp>),
    /// It replays its recordings; ask again.
    Replaying,
    /// It has replayed them.
    Replayed(Rehearsal),
    /// The model estimates beside the one in force.
    Beside,
    /// Grasps with both models asked.
    Compared {
        /// How many came before these.
        from: usize,
        /// In their order.
        grasps: Vec<Grasp>,
    },
    /// It would take the model without a trial: it is that of its configuration, or the one before.
    Known,
    /// The new model is on trial; the grasps before it.
    Taken(Vec<Grasp>),
    /// It was refused: hash, schema or self-test, in a sentence.
    Refused(String),
    /// Grasps with the new model.
    Grasps {
        /// How many came before these.
        from: usize,
        /// In their order.
        grasps: Vec<Grasp>,
    },
    /// It keeps the model.
    Kept,
    /// This model was in force there before the roll-out.
    Had,
    /// It has gone back by itself, for the reason in the sentence.
    Left(String),
    /// The one before is in force again, as it was ordered.
    Back,
}

/// Why a roll-out has stopped.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Stop {
    /// Somebody refused the model.
    #[error("{member} refused the model: {reason}")]
    Refused {
        /// Who.
        member: Member,
        /// Why.
        reason: String,
    },
    /// The model is worse.
    #[error("after {grasps} grasps with the new model: {}", what.sentence())]
    Worse {
        /// In what.
        what: Worse,
        /// Grasps that were compared.
        grasps: usize,
    },
    /// The model asks for the wrong force; no finger has moved by it.
    #[error("{}, as a shadow at the grippers ({tally})", what.sentence())]
    Wrong {
        /// How.
        what: Wrong,
        /// Grasps that were compared.
        tally: Tally,
    },
    /// The model asks for the wrong force in recordings.
    #[error("{}, in replays of the grippers' own recordings ({tally})", what.sentence())]
    Replayed {
        /// How.
        what: Wrong,
        /// Grasps that were compared.
        tally: Tally,
    },
    /// There is too little to compare with.
    #[error("{member} has made {has} grasps, and {wanted} are needed to compare with")]
    Few {
        /// Who.
        member: Member,
        /// Grasps with the model in force.
        has: usize,
        /// Grasps of a stage.
        wanted: usize,
    },
    /// No number of grasps is enough.
    #[error(
        "{MOST_GRASPS} grasps do not show such a difference: name a larger one, or the number of grasps"
    )]
    Blind,
    /// Somebody has gone back by itself.
    #[error("{member} has gone back to the model before: {reason}")]
    Left {
        /// Who.
        member: Member,
        /// Why.
        reason: String,
    },
    /// Somebody does not answer.
    #[error("{member} has not answered for too long{}", match reason { Some(reason) => format!(": {reason}"), None => String::new() })]
    Gone {
        /// Who.
        member: Member,
        /// What came instead of the last answer.
        reason: Option<String>,
    },
    /// Somebody tries the model and grasps nothing.
    #[error("{member} has grasped nothing for too long")]
    Idle {
        /// Who.
        member: Member,
    },
    /// Whoever began it.
    #[error("it was stopped from here")]
    Ordered,
}

/// Where a roll-out is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Progress {
    /// Everybody is asked; nobody has the model.
    Checking,
    /// The grippers replay their recordings; nobody has it.
    Replay,
    /// The model estimates beside those in force; nobody has it.
    Shadow,
    /// In this stage, from 1.
    Stage(usize),
    /// Everybody is ordered to keep the model.
    Accepting,
    /// Everybody has the model.
    Done,
    /// It was stopped; so many have not given the model back yet.
    Stopped(usize),
}
