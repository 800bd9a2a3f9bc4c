//! Publisher of what one gripper's daemon reports: publications, a sign of life and answers.

use super::{NetError, PATIENCE, refused};
use crate::{
    follower::Since,
    id::{EventId, Stamp},
    json,
    key::{Member, Part},
    log::{EventLog, Logged},
    message::Message,
};
use std::{
    collections::{HashMap, VecDeque},
    sync::mpsc::{Receiver, sync_channel},
};
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
/// Events that a question may name.
const MOST_NAMED: usize = 16;
/// Events of an answer between two looks at everything else.
const SLICE: usize = 64;

/// Hands out the log for a moment.
pub type WithLog<'a> = dyn Fn(&mut dyn FnMut(&EventLog)) + 'a;

/// One gripper on the network.
#[derive(Debug)]
pub struct Announced {
    member: Member,
    publishers: HashMap<Part, Publisher<'static>>,
    /// The last HEALTH as JSON.
    last_health: Option<(Stamp, String)>,
    asked: Receiver<(Part, Query)>,
    /// Answers that are under way.
    open: VecDeque<Open>,
    /// What somebody else has to answer.
    others: VecDeque<Question>,
    refused: u64,
    _queryables: Vec<Queryable<()>>,
    // The last one: whoever sees it can ask.
    _alive: LivelinessToken,
}

/// Events that somebody asked for, and how far the answer has come.
#[derive(Debug)]
struct Open {
    query: Query,
    /// Events as they are, or as JSON.
    part: Part,
    /// What whoever asks knows.
    after: Vec<EventId>,
    since: Since,
    /// Where it goes on in the log; not looked for yet, where absent.
    place: Option<u64>,
    /// Events that are still wanted.
    left: usize,
}

impl Open {
    /// Reads what is asked; a sentence where that is not clear: an answer with everything would be no answer to it.
    fn new(query: &Query, part: Part) -> Result<Self, String> {
        let parameters = query.parameters();
        let wrong = |name: &str, form: &str, got: &str| format!("{name}={got}: expected {form}");
        let after = parameters.get("after").unwrap_or_default();
        let named = after.split(',').filter(|id| !id.is_empty()).take(MOST_NAMED);
        let after = named
            .map(|id| {
                id.parse()
                    .map_err(|_| wrong("after", "RUN.NUMBER, RUN as eight hexadecimal digits", id))
            })
            .collect::<Result<Vec<EventId>, String>>()?;
        let since = match parameters.get("since") {
            None => Since::Start,
            Some("now") => Since::Now,
            Some(other) => return Err(wrong("since", "now", other)),
        };
        let left = match parameters.get("most") {
            None => usize::MAX,
            Some(most) => most.parse().map_err(|_| wrong("most", "a count", most))?,
        };
        Ok(Self { query: query.clone(), part, after, since, place: None, left })
    }
}

impl Announced {
    /// Puts a gripper on the network, unless one of its name is there already: what is asked of that name would reach only one of them.
    /// Beside events, status and configuration it is asked for those `parts`, which [`Announced::question`] hands out.
    ///
    /// # Errors
    /// [`NetError::Taken`] and [`NetError::Refused`].
    pub fn new(session: &Session, member: &Member, parts: &[Part]) -> Result<Self, NetError> {
        let alive = member.key(Part::Alive);
        let same = session.liveliness().get(&alive).timeout(PATIENCE).wait();
        if same.map_err(refused(&alive))?.iter().any(|reply| reply.result().is_ok()) {
            return Err(NetError::Taken { member: member.to_string() });
        }
        let publisher = |part: Part| Ok((part, publisher(session, &member.key(part), part)?));
        let publishers: Result<_, _> = PUBLISHED.into_iter().map(publisher).collect();
        let (ask, asked) = sync_channel(MOST_QUESTIONS);
        let queryable = |part: Part| {
            let (key, ask) = (part.question(&member.key(part)), ask.clone());
            session
                .declare_queryable(key.clone())
                .complete(true)
                .callback(move |query| {
                    // Where there is no room, the answer is empty, and asked for again.
                    let _full = ask.try_send((part, query));
                })
                .wait()
                .map_err(refused(&key))
        };
        let own = [Part::Events, Part::EventsJson, Part::HealthJson, Part::Status, Part::Config];
        let queryables: Result<_, _> =
            own.into_iter().chain(parts.iter().copied()).map(queryable).collect();
        Ok(Self {
            member: member.clone(),
            publishers: publishers?,
            last_health: None,
            asked,
            open: VecDeque::new(),
            others: VecDeque::new(),
            refused: 0,
            _queryables: queryables?,
            _alive: session.liveliness().declare_token(&alive).wait().map_err(refused(&alive))?,
        })
    }

    /// Publishes a frame, events and HEALTH as JSON too. The stamp is that of the event, or the number of the last event for what
    /// is none. Where the network does not take it, the log has the event still, and the rest is out of date soon; it is counted.
    pub fn publish(&mut self, topic: Part, stamp: impl Into<Stamp>, wire: &[u8]) {
        let stamp = stamp.into();
        self.put(topic, stamp, wire);
        let part = match topic {
            Part::Events => Part::EventsJson,
            Part::Health => Part::HealthJson,
            _ => return,
        };
        // What is no frame has none.
        let Some(json) = self.json(stamp, wire) else { return };
        self.put(part, stamp, json.as_bytes());
        if topic == Part::Health {
            self.last_health = Some((stamp, json));
        }
    }

    fn put(&mut self, part: Part, stamp: Stamp, bytes: &[u8]) {
        let publisher = self.publishers.get(&part);
        let sent = publisher.map(|to| to.put(bytes).attachment(stamp.to_bytes()).wait());
        self.refused += u64::from(!matches!(sent, Some(Ok(()))));
    }

    fn json(&self, stamp: Stamp, wire: &[u8]) -> Option<String> {
        let message = Message::from_wire(wire).ok()?;
        json::of_message(&self.member, stamp, &message).ok()
    }

    /// Answers what was asked meanwhile: `status` with the frames given, `config` with that text, and some of the events that are asked
    /// for, so that nothing else waits long. `with_log` hands out the log for a moment, in which nothing is sent.
    pub fn answer(&mut self, with_log: &WithLog<'_>, status: &[impl AsRef<[u8]>], config: &str) {
        let mut head = Stamp::default();
        with_log(&mut |log| head = log.head().into());
        while let Ok((part, query)) = self.asked.try_recv() {
            let key = self.member.key(part);
            if part.has_names_below() && query.key_expr().as_str().ends_with(part.name()) {
                let reason =
                    format!("ask {}: each answer has a name of its own", part.question(&key));
                self.refuse(&query, &reason);
                continue;
            }
            match part {
                Part::Events | Part::EventsJson if self.open.len() < MOST_QUESTIONS => {
                    match Open::new(&query, part) {
                        Ok(open) => self.open.push_back(open),
                        Err(reason) => self.refuse(&query, &reason),
                    }
                }
                Part::Events | Part::EventsJson => {}
                Part::HealthJson => {
                    if let Some((stamp, json)) = self.last_health.clone() {
                        self.reply(&query, &key, stamp, json.as_bytes(), JSON);
                    }
                }
                Part::Config => {
                    self.reply(&query, &key, head, config.as_bytes(), Encoding::TEXT_PLAIN);
                }
                Part::Status => {
                    for (number, frame) in status.iter().enumerate() {
                        let key = format!("{key}/{number}");
                        self.reply(&query, &key, head, frame.as_ref(), FRAME);
                    }
                }
                _ if self.others.len() < MOST_QUESTIONS => {
                    self.others.push_back(Question { part, key, query });
                }
                _ => {}
            }
        }
        if let Some(open) = self.open.pop_front() {
            self.go_on(open, with_log);
        }
    }

    /// The next events of an answer; it comes to the end of the queue where it is not complete.
    fn go_on(&mut self, mut open: Open, with_log: &WithLog<'_>) {
        let mut events: Vec<Logged> = Vec::new();
        let slice = SLICE.min(open.left);
        with_log(&mut |log| {
            let place =
                open.place.unwrap_or_else(|| log.place(&open.after, open.since)).max(log.dropped());
            events = log.from(place).take(slice).cloned().collect();
            open.place = Some(place + events.len() as u64);
        });
        let key = self.member.key(open.part);
        for event in &events {
            let key = format!("{key}/{:08x}/{}", event.id.run, event.id.seq);
            let stamp = Stamp { id: event.id, at: event.at };
            if open.part == Part::EventsJson {
                let Some(json) = self.json(stamp, &event.wire) else { continue };
                self.reply(&open.query, &key, stamp, json.as_bytes(), JSON);
            } else {
                self.reply(&open.query, &key, stamp, &event.wire, FRAME);
            }
        }
        open.left -= events.len();
        // A question that is dropped is answered.
        if events.len() == slice && open.left > 0 {
            self.open.push_back(open);
        }
    }

    /// Questions may go to many grippers; each answers under its own name.
    fn reply(&mut self, query: &Query, key: &str, stamp: Stamp, bytes: &[u8], form: Encoding) {
        let reply = query.reply(key, bytes).attachment(stamp.to_bytes());
        self.refused += u64::from(reply.encoding(form).wait().is_err());
    }

    /// A question that cannot be answered.
    fn refuse(&mut self, query: &Query, reason: &str) {
        self.refused += u64::from(query.reply_err(reason).wait().is_err());
    }

    /// The next question for one of the parts that were named at the start; [`Announced::answer`] finds it.
    pub fn question(&mut self) -> Option<Question> {
        self.others.pop_front()
    }

    /// Whether an answer is under way: then look again soon.
    #[must_use]
    pub fn is_answering(&self) -> bool {
        !self.open.is_empty()
    }

    /// What the session refused to send.
    #[must_use]
    pub const fn refused(&self) -> u64 {
        self.refused
    }
}

/// A question that somebody else has to answer. Dropped, its answer ends.
#[derive(Debug)]
pub struct Question {
    part: Part,
    key: String,
    query: Query,
}

impl Question {
    /// What is asked for.
    #[must_use]
    pub const fn part(&self) -> Part {
        self.part
    }

    /// A parameter of the question: what stands behind `name=`.
    #[must_use]
    pub fn parameter(&self, name: &str) -> Option<String> {
        self.query.parameters().get(name).map(str::to_owned)
    }

    /// Bytes that came with it.
    #[must_use]
    pub fn payload_len(&self) -> usize {
        self.query.payload().map_or(0, |bytes| bytes.len())
    }

    /// What came with it; nothing, where nothing did.
    #[must_use]
    pub fn payload(&self) -> Vec<u8> {
        self.query.payload().map_or_else(Vec::new, |bytes| bytes.to_bytes().into_owned())
    }

    /// One part of the answer.
    ///
    /// # Errors
    /// [`NetError::Refused`] where the session does not take it.
    pub fn reply(&self, bytes: &[u8]) -> Result<(), NetError> {
        self.query.reply(&self.key, bytes).wait().map_err(refused(&self.key))
    }

    /// Answers with the reason why there is no answer.
    ///
    /// # Errors
    /// As [`Question::reply`].
    pub fn refuse(&self, reason: &str) -> Result<(), NetError> {
        self.query.reply_err(reason).wait().map_err(refused(&self.key))
    }
}

/// How frames and JSON are marked.
const FRAME: Encoding = Encoding::APPLICATION_OCTET_STREAM;
const JSON: Encoding = Encoding::APPLICATION_JSON;

/// What is published.
const PUBLISHED: [Part; 6] =
    [Part::Events, Part::State, Part::Health, Part::Samples, Part::EventsJson, Part::HealthJson];

/// Nothing waits for room on the way: a receiver that hangs would delay all others. Events that are dropped are asked for again.
fn publisher(session: &Session, key: &str, part: Part) -> Result<Publisher<'static>, NetError> {
    let priority = match part {
        Part::Events | Part::EventsJson => Priority::InteractiveHigh,
        Part::Samples => Priority::DataLow,
        _ => Priority::Data,
    };
    let is_json = matches!(part, Part::EventsJson | Part::HealthJson);
    session
        .declare_publisher(key.to_owned())
        .congestion_control(CongestionControl::Drop)
        .priority(priority)
        .encoding(if is_json { JSON } else { FRAME })
        .wait()
        .map_err(refused(key))
}
