//! What one gripper's daemon tells in, publications, a sign of life and answers out.

use super::{NetError, refused};
use crate::{
    id::EventId,
    key::{Member, Part, Topic},
    log::EventLog,
};
use std::sync::mpsc::{Receiver, sync_channel};
use zenoh::{
    Session, Wait as _,
    bytes::Encoding,
    liveliness::LivelinessToken,
    pubsub::Publisher,
    qos::{CongestionControl, Priority},
    query::{Query, Queryable},
};

/// Questions that may wait; more are not answered, and asked again.
const MOST_QUESTIONS: usize = 64;

/// One gripper on the network.
#[derive(Debug)]
pub struct Announced {
    member: Member,
    events: Publisher<'static>,
    state: Publisher<'static>,
    health: Publisher<'static>,
    samples: Publisher<'static>,
    questions: Receiver<(Part, Query)>,
    refused: u64,
    _queryables: [Queryable<()>; 3],
    // The last one: whoever sees it can ask.
    _alive: LivelinessToken,
}

impl Announced {
    /// Puts a gripper on the network.
    ///
    /// # Errors
    /// [`NetError::Refused`].
    pub fn new(session: &Session, member: &Member) -> Result<Self, NetError> {
        let publisher = |topic| publisher(session, &member.key(Part::Topic(topic)), topic);
        let (asked, questions) = sync_channel(MOST_QUESTIONS);
        let queryable = |part: Part| {
            let (key, asked) = (member.key(part), asked.clone());
            session
                .declare_queryable(key.clone())
                .complete(true)
                .callback(move |query| {
                    // Where there is no room, the answer is empty, and asked for again.
                    let _full = asked.try_send((part, query));
                })
                .wait()
                .map_err(refused(&key))
        };
        let queryables = [
            queryable(Part::Topic(Topic::Events))?,
            queryable(Part::Status)?,
            queryable(Part::Config)?,
        ];
        let alive = member.key(Part::Alive);
        Ok(Self {
            member: member.clone(),
            events: publisher(Topic::Events)?,
            state: publisher(Topic::State)?,
            health: publisher(Topic::Health)?,
            samples: publisher(Topic::Samples)?,
            questions,
            refused: 0,
            _queryables: queryables,
            _alive: session.liveliness().declare_token(&alive).wait().map_err(refused(&alive))?,
        })
    }

    /// Publishes a frame. `id` is that of the event, or of the last event for what is none. Where the network does not take it, the
    /// log has the event still, and the rest is out of date soon; it is counted.
    pub fn publish(&mut self, topic: Topic, id: EventId, wire: &[u8]) {
        let publisher = match topic {
            Topic::Events => &self.events,
            Topic::State => &self.state,
            Topic::Health => &self.health,
            Topic::Samples => &self.samples,
        };
        let sent = publisher.put(wire).attachment(id.to_bytes()).wait();
        self.refused += u64::from(sent.is_err());
    }

    /// Answers what was asked meanwhile: events from the log, `status` with the frames given, `config` with that text.
    pub fn answer(&mut self, log: &EventLog, status: &[&[u8]], config: &str) {
        while let Ok((part, query)) = self.questions.try_recv() {
            // Questions may go to many grippers; each answers under its own name.
            let key = self.member.key(part);
            let mut reply = |id: EventId, bytes: &[u8], encoding: Encoding| {
                let reply = query.reply(key.clone(), bytes).attachment(id.to_bytes());
                self.refused += u64::from(reply.encoding(encoding).wait().is_err());
            };
            match part {
                Part::Topic(_) => {
                    let after = query.parameters().get("after").and_then(|id| id.parse().ok());
                    for event in log.after(after) {
                        reply(event.id, &event.wire, Encoding::APPLICATION_OCTET_STREAM);
                    }
                }
                Part::Config => reply(log.head(), config.as_bytes(), Encoding::TEXT_PLAIN),
                Part::Status | Part::Alive => {
                    for frame in status {
                        reply(log.head(), frame, Encoding::APPLICATION_OCTET_STREAM);
                    }
                }
            }
        }
    }

    /// What the session refused to send.
    #[must_use]
    pub const fn refused(&self) -> u64 {
        self.refused
    }
}

/// Events wait for room on the way, the rest does not.
fn publisher(session: &Session, key: &str, topic: Topic) -> Result<Publisher<'static>, NetError> {
    let (congestion, priority) = match topic {
        Topic::Events => (CongestionControl::Block, Priority::InteractiveHigh),
        Topic::State | Topic::Health => (CongestionControl::Drop, Priority::Data),
        Topic::Samples => (CongestionControl::Drop, Priority::DataLow),
    };
    session
        .declare_publisher(key.to_owned())
        .congestion_control(congestion)
        .priority(priority)
        .encoding(Encoding::APPLICATION_OCTET_STREAM)
        .wait()
        .map_err(refused(key))
}
