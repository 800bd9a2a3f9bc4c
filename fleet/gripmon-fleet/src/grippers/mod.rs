//! Table of what many grippers report, with a row for each of them, in fixed memory a gripper. No network and no clock.
//!
//! ```text
//! thread of the network -> FleetFeed -> Roster -> rows in the order of a Sorting
//! ```

mod column;
mod order;
mod roster;
mod row;
mod spark;

pub use column::Column;
pub use grip_fleet::{About, Member, Message, Site, Uid};
pub use order::{Sorting, order};
pub use roster::{MOST, Roster, Summary};
pub use row::{Figures, Presence, Row, Trouble};
pub use spark::{COLUMN_S, COLUMNS, Spark};

use grip_scope::feed::SourceStatus;

/// One item of the network: the only thing that passes from its thread to the roster. All times are seconds of one clock that never goes back.
#[derive(Clone, Debug, PartialEq)]
pub enum FleetFeed {
    /// How the way to the router is; reported on every change.
    Status(SourceStatus),
    /// Something of a gripper.
    Of {
        /// Whose.
        member: Member,
        /// When it came (s).
        at_s: f64,
        /// What.
        what: Received,
    },
    /// Time goes on (s); reported once a second.
    Now(f64),
    /// Something came under one of our names that no gripd sends.
    Unreadable,
}

/// What is received of a gripper.
#[derive(Clone, Debug, PartialEq)]
pub enum Received {
    /// It is there.
    Came,
    /// It, or the way to it, is gone.
    Gone,
    /// So many of its events are missing: nobody has them any more.
    Missing(u64),
    /// What it is made of.
    About(About),
    /// One of its messages.
    Message(Message),
}
