//! Publisher of what one gripper's daemon reports as the topics of a ROS 2 node, on a session that is there anyway.

use super::{NetError, refused};
use crate::{
    id::EventId,
    key::Member,
    message::Message,
    ros::{Attachment, Gid, RosNode, RosTopic, messages},
};
use zenoh::{
    Session, Wait as _,
    liveliness::LivelinessToken,
    pubsub::Publisher,
    qos::{CongestionControl, Priority},
};

/// What clocks show; libraries read none (ns since 1970).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RosTimes {
    /// At the daemon's start.
    pub start_ns: u64,
    /// Now.
    pub now_ns: u64,
}

/// One gripper as a node that ROS 2 computers on the same network see.
#[derive(Debug)]
pub struct RosAnnounced {
    node: RosNode,
    /// In the order of [`RosTopic::ALL`].
    topics: [Topic; 3],
    refused: u64,
    _alive: LivelinessToken,
}

#[derive(Debug)]
struct Topic {
    publisher: Publisher<'static>,
    gid: Gid,
    /// Publications so far.
    sent: i64,
    _alive: LivelinessToken,
}

impl RosAnnounced {
    /// Puts the node of a gripper on the network, in a domain (`ROS_DOMAIN_ID`).
    ///
    /// # Errors
    /// [`NetError::Refused`].
    pub fn new(session: &Session, member: &Member, domain: u16) -> Result<Self, NetError> {
        let node = RosNode::new(member, domain);
        let token = node.token(&session.zid().to_string());
        let topic = |topic| Topic::new(session, &node, topic);
        Ok(Self {
            topics: [
                topic(RosTopic::JointStates)?,
                topic(RosTopic::State)?,
                topic(RosTopic::Slip)?,
            ],
            _alive: session.liveliness().declare_token(&token).wait().map_err(refused(&token))?,
            node,
            refused: 0,
        })
    }

    /// The full name of the node.
    #[must_use]
    pub fn name(&self) -> String {
        self.node.name()
    }

    /// Publishes what a frame of the daemon is in ROS; `id` is the number of the event. What the network does not take is counted: it is not reported
    /// again, since ROS 2 has no way to ask for it.
    pub fn publish(&mut self, id: EventId, wire: &[u8], times: RosTimes) {
        let Ok(message) = Message::from_wire(wire) else {
            self.refused += 1;
            return;
        };
        for (topic, bytes) in messages(&message, id, times.start_ns) {
            if let Some(topic) = self.topics.get_mut(topic as usize) {
                self.refused += u64::from(!topic.put(bytes, times.now_ns));
            }
        }
    }

    /// What the session refused to send.
    #[must_use]
    pub const fn refused(&self) -> u64 {
        self.refused
    }
}

impl Topic {
    /// As rmw_zenoh does for a reliable publisher that keeps the last few: nothing waits for room on the way.
    fn new(session: &Session, node: &RosNode, topic: RosTopic) -> Result<Self, NetError> {
        let priority = match topic {
            RosTopic::Slip => Priority::InteractiveHigh,
            RosTopic::JointStates | RosTopic::State => Priority::Data,
        };
        let (key, token) =
            (node.key(topic), node.publisher_token(&session.zid().to_string(), topic));
        let publisher = session
            .declare_publisher(key.clone())
            .congestion_control(CongestionControl::Drop)
            .priority(priority)
            .wait()
            .map_err(refused(&key))?;
        let alive = session.liveliness().declare_token(&token).wait().map_err(refused(&token))?;
        Ok(Self { publisher, gid: Gid::of(&token), sent: 0, _alive: alive })
    }

    /// Whether the session took it.
    fn put(&mut self, bytes: Vec<u8>, now_ns: u64) -> bool {
        self.sent = self.sent.wrapping_add(1);
        let source_ns = i64::try_from(now_ns).unwrap_or(i64::MAX);
        let attachment = Attachment { sequence: self.sent, source_ns, gid: self.gid };
        self.publisher.put(bytes).attachment(attachment.to_bytes()).wait().is_ok()
    }
}
