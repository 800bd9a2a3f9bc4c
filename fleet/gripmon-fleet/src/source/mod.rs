//! Sources at a router's address: what many grippers report, for a [`Roster`](crate::grippers::Roster), or one of them as a source.

mod life;
mod member;
mod overview;

pub use grip_fleet::net::{NetError, Network};
pub use overview::{FleetHandle, FleetPlace};

use core::fmt;
use core::time::Duration;
use grip_fleet::Member;

/// Pauses between attempts grow from the one to the other.
const FIRST: Duration = Duration::from_millis(250);
const LONGEST: Duration = Duration::from_secs(5);
/// Time between two looks at whether the router is there.
const LOOK: Duration = Duration::from_secs(1);

/// One gripper of a network.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct GripperAt {
    /// Where its router is.
    pub network: Network,
    /// Which.
    pub member: Member,
}

impl fmt::Display for GripperAt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.member.fmt(f)
    }
}

/// Whether trying again may help.
const fn may_mend(error: &NetError) -> bool {
    matches!(error, NetError::NoRouter { .. } | NetError::Refused { .. })
}
