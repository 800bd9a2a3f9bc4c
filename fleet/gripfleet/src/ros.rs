//! What is published in, the topics of a ROS 2 node out, where the configuration names a domain.

use crate::clock::Clock;
use grip_fleet::{
    EventId, Member,
    net::{NetError, RosAnnounced, RosTimes, Session},
};

pub(super) struct Ros {
    domain: u16,
    clock: Clock,
}

impl Ros {
    /// Nothing where no domain is named.
    pub(super) fn new(domain: Option<u16>, clock: Clock) -> Option<Self> {
        domain.map(|domain| Self { domain, clock })
    }

    /// Puts the node on the network.
    pub(super) fn announce(
        &self,
        session: &Session,
        member: &Member,
    ) -> Result<RosAnnounced, NetError> {
        RosAnnounced::new(session, member, self.domain)
    }

    /// `start_ns` is what the wall clock showed at the start of gripd.
    pub(super) fn publish(&self, node: &mut RosAnnounced, id: EventId, wire: &[u8], start_ns: u64) {
        node.publish(id, wire, RosTimes { start_ns, now_ns: self.clock.wall_ns() });
    }
}
