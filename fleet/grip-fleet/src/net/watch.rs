//! Subscriber to the events of many grippers, over a session: each once, those of one gripper in order, and who comes and goes.

use super::{NetError, refused};
use crate::{
    follower::{Follower, Since, Verdict},
    id::{EventId, Stamp, WallTime},
    key::{Member, Part, Selector},
    message::Message,
};
use core::{
    sync::atomic::{AtomicUsize, Ordering},
    time::Duration,
};
use std::{
    collections::{HashMap, VecDeque},
    sync::{
        Arc,
        mpsc::{Receiver, Sender, channel},
    },
};
use zenoh::{
    Session, Wait as _,
    pubsub::Subscriber,
    query::{ConsolidationMode, Reply},
    sample::{Sample, SampleKind},
};

/// With so much waiting for the receiver, what is published is dropped: events are asked for again.
const WAITING: usize = 4096;
/// Grippers that are asked for their events at once, and events of one answer: what a slow line carries within a second or two, and what may wait here
/// for a receiver that hangs. Who has more is asked again.
const QUESTIONS: usize = 32;
const PAGE: usize = 256;
/// Grippers that are known at a time.
const MOST: usize = 10_000;
/// Patience with an answer from a log.
const PATIENCE: Duration = Duration::from_secs(10);

/// What a receiver is sent.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Reported {
    /// A gripper is there.
    Came(Member),
    /// A gripper, or the way to it, is gone.
    Gone(Member),
    /// An event, once.
    Event {
        /// Whose.
        member: Member,
        /// Its number.
        id: EventId,
        /// When it happened.
        at: WallTime,
        /// What happened.
        message: Message,
        /// Events before it that nobody has any more.
        missing: u64,
    },
    /// Something else that was asked for, as it comes.
    Telemetry {
        /// Whose.
        member: Member,
        /// The last event before it, and its time.
        stamp: Stamp,
        /// What it reports.
        message: Message,
    },
    /// Something that cannot be read, under one of our names.
    Unreadable {
        /// The name.
        key: String,
    },
}

/// What comes from the network.
#[derive(Debug)]
enum Update {
    Life(Member, bool),
    Live(Member, Part, Stamp, Message),
    /// Of the question of that number.
    Answer(Member, u64, Stamp, Message),
    Answered(Member, u64),
    Unreadable(String),
}

/// What is known of one gripper.
#[derive(Debug)]
struct Watched {
    follower: Follower,
    alive: bool,
    /// Number of the last question; answers to earlier ones are not taken.
    asked: u64,
    /// An answer to it is on its way.
    open: bool,
    /// It is to be asked when others have answered.
    due: bool,
    /// Events that the answer had, and the last of them.
    came: usize,
    last: Option<EventId>,
    /// The answer was full: the next one goes on behind this event, whether it was new or not.
    turned: Option<EventId>,
}

impl Watched {
    fn new(since: Since) -> Self {
        let follower = Follower::new(since);
        let (alive, open, due) = (false, false, false);
        Self { follower, alive, asked: 0, open, due, came: 0, last: None, turned: None }
    }

    /// The answer has ended; whether there is more to ask for.
    fn turn_page(&mut self) -> bool {
        self.turned = self.last.filter(|_| self.came >= PAGE);
        self.follower.answered() || self.turned.is_some()
    }
}

/// The way from the threads of the session to the receiver.
#[derive(Clone, Debug)]
struct Way {
    sender: Sender<Update>,
    waiting: Arc<AtomicUsize>,
}

impl Way {
    fn send(&self, updates: Update) {
        self.waiting.fetch_add(1, Ordering::Relaxed);
        // A receiver that is gone wants nothing.
        let _gone = self.sender.send(updates);
    }

    /// A publication or an answer.
    fn sample(&self, sample: &Sample, answer: Option<u64>) {
        let key = sample.key_expr().as_str();
        let Some((member, part)) = Member::parse(key) else { return };
        if answer.is_none() && self.waiting.load(Ordering::Relaxed) > WAITING {
            return;
        }
        let stamp = sample.attachment().and_then(|bytes| Stamp::from_bytes(&bytes.to_bytes()));
        let message = Message::from_wire(&sample.payload().to_bytes());
        self.send(match (stamp, message) {
            (Some(stamp), Ok(message)) => match answer {
                Some(asked) => Update::Answer(member, asked, stamp, message),
                None => Update::Live(member, part, stamp, message),
            },
            _ => Update::Unreadable(key.to_owned()),
        });
    }

    fn life(&self, sample: &Sample) {
        if let Some((member, _)) = Member::parse(sample.key_expr().as_str()) {
            self.send(Update::Life(member, sample.kind() == SampleKind::Put));
        }
    }
}

/// Reports the end of an answer, however it ends.
struct End(Way, Member, u64);

impl Drop for End {
    fn drop(&mut self) {
        self.0.send(Update::Answered(self.1.clone(), self.2));
    }
}

/// The receiver of a selection of grippers.
#[derive(Debug)]
pub struct Watch {
    session: Session,
    since: Since,
    telemetry: Vec<Part>,
    updates: Receiver<Update>,
    way: Way,
    watched: HashMap<Member, Watched>,
    /// Answers that are on their way, and who is to be asked next.
    open: usize,
    due: VecDeque<Member>,
    _subscribers: Vec<Subscriber<()>>,
}

impl Watch {
    /// Watches grippers: events, and what is chosen of the rest.
    ///
    /// # Errors
    /// [`NetError::Refused`].
    pub fn new(
        session: Session,
        selector: &Selector,
        since: Since,
        telemetry: &[Part],
    ) -> Result<Self, NetError> {
        let (sender, updates) = channel();
        let way = Way { sender, waiting: Arc::default() };
        let mut subscribers = Vec::new();
        // HEALTH comes in any case: it reports every second which event was the last.
        let mut topics = vec![Part::Events, Part::Health];
        topics.extend(telemetry.iter().filter(|topic| **topic != Part::Health));
        for topic in topics {
            let (key, way) = (selector.key(topic), way.clone());
            let received = move |sample: Sample| way.sample(&sample, None);
            let subscriber = session.declare_subscriber(key.clone()).callback(received).wait();
            subscribers.push(subscriber.map_err(refused(&key))?);
        }
        let (key, life) = (selector.key(Part::Alive), way.clone());
        let received = move |sample: Sample| life.life(&sample);
        let liveliness = session.liveliness();
        let subscriber =
            liveliness.declare_subscriber(&key).history(true).callback(received).wait();
        subscribers.push(subscriber.map_err(refused(&key))?);
        let telemetry = telemetry.to_vec();
        let (watched, due, open) = (HashMap::new(), VecDeque::new(), 0);
        let _subscribers = subscribers;
        Ok(Self { session, since, telemetry, updates, way, watched, open, due, _subscribers })
    }

    /// These events were received before, by an earlier receiver: what came after them is wanted. Of grippers that have sent something already
    /// nothing changes.
    pub fn resume(&mut self, known: impl IntoIterator<Item = (Member, Vec<EventId>)>) {
        for (member, received) in known {
            let follower = Follower::resumed(Since::Start, received);
            let resumed = Watched { follower, ..Watched::new(self.since) };
            self.watched.entry(member).or_insert(resumed);
        }
    }

    /// What was received of each gripper, for [`Watch::resume`].
    pub fn received(&self) -> impl Iterator<Item = (&Member, Vec<EventId>)> {
        self.watched.iter().map(|(member, it)| (member, it.follower.received().collect()))
    }

    /// What happens next, waiting at most so long for it; `None` where nothing happened of which the receiver is informed.
    ///
    /// # Errors
    /// [`NetError::Refused`] where the session has ended.
    pub fn next(&mut self, patience: Duration) -> Result<Option<Reported>, NetError> {
        // The way holds a sender: it never ends.
        let Ok(updates) = self.updates.recv_timeout(patience) else { return Ok(None) };
        self.way.waiting.fetch_sub(1, Ordering::Relaxed);
        if let Update::Live(member, ..) | Update::Life(member, _) = &updates
            && !self.has_room(member)
        {
            return Ok(None);
        }
        match updates {
            Update::Life(member, alive) => self.life(member, alive),
            Update::Live(member, Part::Events, stamp, message) => {
                let verdict = self.watched(&member).follower.live(stamp.id);
                self.event(verdict, member, stamp, message)
            }
            Update::Live(member, part, stamp, message) => {
                if self.watched(&member).follower.head(stamp.id) {
                    self.ask(&member)?;
                }
                let wanted = self.telemetry.contains(&part);
                Ok(wanted.then_some(Reported::Telemetry { member, stamp, message }))
            }
            Update::Answer(member, asked, ..) | Update::Answered(member, asked)
                if self.watched(&member).asked != asked =>
            {
                Ok(None)
            }
            Update::Answer(member, _, stamp, message) => {
                let watched = self.watched(&member);
                watched.came += 1;
                watched.last = Some(stamp.id);
                let verdict = watched.follower.answer(stamp.id);
                self.event(verdict, member, stamp, message)
            }
            Update::Answered(member, _) => {
                let again = self.watched(&member).turn_page();
                self.close(&member);
                if again {
                    // Behind all who wait.
                    self.wait(&member);
                }
                self.ask_next().map(|()| None)
            }
            Update::Unreadable(key) => Ok(Some(Reported::Unreadable { key })),
        }
    }

    /// Whether a router is there now; the session looks for one that is gone by itself.
    #[must_use]
    pub fn is_connected(&self) -> bool {
        self.session.info().routers_zid().wait().next().is_some()
    }

    /// Grippers whose answer is on its way.
    #[must_use]
    pub const fn asking(&self) -> usize {
        self.open
    }

    /// What has come and was not taken yet.
    #[must_use]
    pub fn waiting(&self) -> usize {
        self.way.waiting.load(Ordering::Relaxed)
    }

    fn life(&mut self, member: Member, alive: bool) -> Result<Option<Reported>, NetError> {
        let changed = core::mem::replace(&mut self.watched(&member).alive, alive) != alive;
        // An answer that was under way when the gripper, or the way to it, went away may never end.
        self.watched(&member).follower.abandon();
        self.close(&member);
        if alive {
            self.ask(&member)?;
        }
        self.ask_next()?;
        Ok(changed.then_some(if alive { Reported::Came(member) } else { Reported::Gone(member) }))
    }

    fn event(
        &mut self,
        verdict: Verdict,
        member: Member,
        Stamp { id, at }: Stamp,
        message: Message,
    ) -> Result<Option<Reported>, NetError> {
        match verdict {
            Verdict::New { missing } => {
                Ok(Some(Reported::Event { member, id, at, message, missing }))
            }
            Verdict::Known => Ok(None),
            Verdict::Early => self.ask(&member).map(|()| None),
        }
    }

    /// Whether a gripper is known or can be. Anybody may invent names where the router lets him: those that are not there and of whom
    /// nothing came make room.
    fn has_room(&mut self, member: &Member) -> bool {
        if self.watched.len() >= MOST && !self.watched.contains_key(member) {
            self.watched.retain(|_, it| {
                it.alive || it.open || it.due || it.follower.received().next().is_some()
            });
        }
        self.watched.len() < MOST || self.watched.contains_key(member)
    }

    fn watched(&mut self, member: &Member) -> &mut Watched {
        let since = self.since;
        self.watched.entry(member.clone()).or_insert_with(|| Watched::new(since))
    }

    /// No answer of this gripper is waited for any more.
    fn close(&mut self, member: &Member) {
        let open = core::mem::take(&mut self.watched(member).open);
        self.open -= usize::from(open);
    }

    /// It is asked when all who wait already have been.
    fn wait(&mut self, member: &Member) {
        if !core::mem::replace(&mut self.watched(member).due, true) {
            self.due.push_back(member.clone());
        }
    }

    /// Asks who has waited for that, as long as there is room.
    fn ask_next(&mut self) -> Result<(), NetError> {
        while self.open < QUESTIONS
            && let Some(member) = self.due.pop_front()
        {
            self.watched(&member).due = false;
            self.ask(&member)?;
        }
        Ok(())
    }

    /// Asks for what is missing, unless an answer is on its way; later, where enough others have been asked.
    fn ask(&mut self, member: &Member) -> Result<(), NetError> {
        if self.open >= QUESTIONS && !self.watched(member).open {
            self.wait(member);
            return Ok(());
        }
        let Some(after) = self.watched(member).follower.ask() else { return Ok(()) };
        let part = Part::Events;
        let key = part.question(&member.key(part));
        let only_new = if self.since == Since::Now { ";since=now" } else { "" };
        let watched = self.watched(member);
        let after = watched.turned.take().into_iter().chain(after);
        let after: Vec<String> = after.map(|id| id.to_string()).collect();
        let after = match after.as_slice() {
            [] => String::new(),
            after => format!(";after={}{only_new}", after.join(",")),
        };
        let selector = format!("{key}?most={PAGE}{after}");
        (watched.came, watched.last) = (0, None);
        watched.asked += 1;
        watched.open = true;
        let asked = watched.asked;
        self.open += 1;
        let end = End(self.way.clone(), member.clone(), asked);
        let received = move |reply: Reply| {
            if let Ok(sample) = reply.result() {
                end.0.sample(sample, Some(end.2));
            }
        };
        let get = self.session.get(&selector).consolidation(ConsolidationMode::None);
        get.timeout(PATIENCE).callback(received).wait().map_err(refused(&key))
    }
}
