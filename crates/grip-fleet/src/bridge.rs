//! Bytes of a daemon's socket in, what is to be published of them out. No socket and no clock.

use crate::{
    key::Topic,
    message::{self, Message},
};
use grip_link::{
    decoder::{Decoder, Role, Verdict},
    frame::{self, Direction, Header, MAX_PAYLOAD, MAX_WIRE},
    message::{
        Ack, Kind, Nack, NackReason, PayloadError, Versions,
        daemon::{Command, DroppedClass, Gripper, Notice, NoticeKind, Subscribe, Topics},
    },
};
use grip_session::config::Uid;

/// Milliseconds between two STATE.
const STATE_MS: u16 = 200;

/// Something to be published.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Publication {
    /// Under which name.
    pub topic: Topic,
    /// The frame.
    pub wire: Vec<u8>,
}

/// What is heard of a daemon.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Heard {
    /// Something to be published.
    Publication(Publication),
    /// The daemon had no room for so many events: this end has read too slowly.
    Missed(u32),
    /// The daemon answers the command of this number.
    Answer(u16, Result<(), NackReason>),
}

/// One connection to a daemon, as a client that hears everything but samples.
#[derive(Debug)]
pub struct Bridge {
    decoder: Decoder,
    session: u16,
    uid: Option<Uid>,
    /// The last GRIPPER, STATE and HEALTH.
    known: [Option<Vec<u8>>; 3],
    nameless: u64,
    /// Number of the last request.
    seq: u16,
}

impl Bridge {
    /// A session of this nonce; 0 becomes 1.
    #[must_use]
    pub fn new(nonce: u16) -> Self {
        let session = nonce.max(1);
        let mut decoder = Decoder::new(Role::Client);
        decoder.open_session(session, None);
        Self { decoder, session, uid: None, known: [None, None, None], nameless: 0, seq: 0 }
    }

    /// What the daemon is told first; every n-th sample is wanted, none for 0.
    #[must_use]
    pub fn subscribe(&self, every_nth: u16) -> Vec<u8> {
        let (versions, topics) = (Versions::OURS, Topics::ALL);
        let wanted = Subscribe { versions, topics, every_nth, state_ms: STATE_MS };
        self.request(Kind::SUBSCRIBE, 0, |out| wanted.write(out))
    }

    /// A command for the fingers, and its number in [`Heard::Answer`].
    pub fn command(&mut self, command: &Command) -> (u16, Vec<u8>) {
        self.seq = self.seq.wrapping_add(1);
        (self.seq, self.request(Kind::COMMAND, self.seq, |out| command.write(out)))
    }

    fn request(
        &self,
        kind: Kind,
        seq: u16,
        write: impl FnOnce(&mut [u8]) -> Result<usize, PayloadError>,
    ) -> Vec<u8> {
        let (mut payload, mut wire) = ([0; MAX_PAYLOAD], [0; MAX_WIRE]);
        let header = Header::new(Direction::ToDevice, kind, seq, self.session);
        let header = Header { ack_req: true, ..header };
        let payload = write(&mut payload).ok().and_then(|len| payload.get(..len));
        let len = frame::encode(&header, payload.unwrap_or_default(), &mut wire).unwrap_or(0);
        wire.get(..len).unwrap_or_default().to_vec()
    }

    /// Takes bytes and hands out what they complete; what the daemon says of this connection is for nobody else. News of a gripper that has not said who it is have no name and are counted.
    pub fn receive(&mut self, mut bytes: &[u8], on: &mut dyn FnMut(Heard)) {
        while let Some(verdict) = self.decoder.next(&mut bytes) {
            let Verdict::Frame(frame) = verdict else { continue };
            let (kind, payload) = (frame.header.kind, frame.payload);
            if let Some((seq, answer)) = answer(kind, payload) {
                on(Heard::Answer(seq, answer));
            }
            let Some(topic) = topic(kind) else { continue };
            if kind == Kind::GRIPPER
                && let Ok(gripper) = Gripper::parse(payload)
            {
                self.uid = Some(Uid(gripper.uid)).filter(|uid| uid.0 != [0; 16]);
            }
            match connection(kind, payload) {
                Some(0) => continue,
                Some(missed) => {
                    on(Heard::Missed(missed));
                    continue;
                }
                None => {}
            }
            // A frame that was received can be written.
            let Ok(wire) = message::wire(kind, payload) else { continue };
            if let Some(place) = place(kind).and_then(|place| self.known.get_mut(place)) {
                *place = Some(wire.clone());
            }
            if self.uid.is_some() {
                on(Heard::Publication(Publication { topic, wire }));
            } else {
                self.nameless = self.nameless.saturating_add(1);
            }
        }
    }

    /// Which gripper it is, as soon as it has said so.
    #[must_use]
    pub const fn uid(&self) -> Option<Uid> {
        self.uid
    }

    /// The last GRIPPER, STATE and HEALTH, as far as there were any.
    pub fn status(&self) -> impl Iterator<Item = &[u8]> {
        self.known.iter().flatten().map(Vec::as_slice)
    }

    /// Messages that came before the gripper had a name.
    #[must_use]
    pub const fn nameless(&self) -> u64 {
        self.nameless
    }
}

/// Which command is answered, and how.
fn answer(kind: Kind, payload: &[u8]) -> Option<(u16, Result<(), NackReason>)> {
    let (of, answer) = match kind {
        Kind::ACK => Ack::parse(payload).ok().map(|ack| (ack.kind, (ack.seq, Ok(()))))?,
        Kind::NACK => Nack::parse(payload).ok().map(|no| (no.kind, (no.seq, Err(no.reason))))?,
        _ => return None,
    };
    Some(answer).filter(|_| of == Kind::COMMAND)
}

/// How many events were dropped, of what the daemon says of this connection alone; `None` for everything else.
fn connection(kind: Kind, payload: &[u8]) -> Option<u32> {
    let notice = Notice::parse(payload).ok().filter(|_| kind == Kind::NOTICE)?;
    match notice.kind {
        NoticeKind::Dropped if notice.code == DroppedClass::News.code() => Some(notice.count),
        NoticeKind::Dropped | NoticeKind::Goodbye => Some(0),
        _ => None,
    }
}

/// Where a message is kept for those who ask later.
const fn place(kind: Kind) -> Option<usize> {
    match kind {
        Kind::GRIPPER => Some(0),
        Kind::STATE => Some(1),
        Kind::HEALTH => Some(2),
        _ => None,
    }
}

/// Under which name a message goes; greetings and answers are for this connection only.
const fn topic(kind: Kind) -> Option<Topic> {
    match kind {
        Kind::SLIP | Kind::GRIPPER | Kind::NOTICE => Some(Topic::Events),
        Kind::STATE => Some(Topic::State),
        Kind::HEALTH => Some(Topic::Health),
        Kind::ROWS => Some(Topic::Samples),
        _ => None,
    }
}

impl Publication {
    /// The message in it.
    ///
    /// # Errors
    /// As [`Message::from_wire`].
    pub fn message(&self) -> Result<Message, crate::MessageError> {
        Message::from_wire(&self.wire)
    }
}

#[cfg(test)]
mod tests {
    use super::{Bridge, Heard, Publication, Topic};
    use grip_link::{
        decoder::{Decoder, Role, Verdict},
        frame::{self, Direction, Header, MAX_PAYLOAD, MAX_WIRE},
        message::{
            Ack, Kind, Nack, NackReason,
            daemon::{
                Command, DroppedClass, Gripper, Health, Notice, NoticeKind, Operation, ToClient,
                ToDaemon,
            },
        },
    };
    use grip_session::config::Uid;

    /// A daemon's side of the connection.
    struct Daemon {
        session: u16,
        seq: u16,
        wire: Vec<u8>,
    }

    impl Daemon {
        fn say(&mut self, kind: Kind, write: impl FnOnce(&mut [u8]) -> usize) {
            let (mut payload, mut out) = ([0; MAX_PAYLOAD], [0; MAX_WIRE]);
            let len = write(&mut payload);
            let header = Header::new(Direction::ToHost, kind, self.seq, self.session);
            self.seq += 1;
            let len = frame::encode(&header, &payload[..len], &mut out).unwrap();
            self.wire.extend_from_slice(&out[..len]);
        }

        fn notice(&mut self, text: &str) {
            let (kind, text) = (NoticeKind::Link, text.as_bytes());
            let notice = Notice { kind, code: 0, value: 0, count: 0, host_us: 0, text };
            self.say(Kind::NOTICE, |out| notice.write(out).unwrap());
        }

        fn gripper(&mut self, uid: u8) {
            let gripper = Gripper { uid: [uid; 16], ..Gripper::NONE };
            self.say(Kind::GRIPPER, |out| gripper.write(out).unwrap());
        }

        fn health(&mut self, samples: u64) {
            let health = Health { samples, ..Health::default() };
            self.say(Kind::HEALTH, |out| health.write(out).unwrap());
        }
    }

    fn take(bridge: &mut Bridge, bytes: &[u8]) -> Vec<Publication> {
        let mut taken = Vec::new();
        bridge.receive(bytes, &mut |heard| match heard {
            Heard::Publication(publication) => taken.push(publication),
            other => panic!("{other:?}"),
        });
        taken
    }

    #[test]
    fn it_greets_as_a_client_that_hears_everything() {
        let bridge = Bridge::new(7);
        let mut decoder = Decoder::new(Role::Daemon);
        let wire = bridge.subscribe(3);
        let Some(Verdict::Frame(frame)) = decoder.next(&mut wire.as_slice()) else { panic!() };
        assert_eq!((frame.header.session, frame.header.ack_req), (7, true));
        let Ok(ToDaemon::Subscribe(wanted)) = ToDaemon::parse(&frame) else { panic!() };
        assert_eq!((wanted.every_nth, wanted.state_ms), (3, super::STATE_MS));
    }

    #[test]
    fn messages_get_the_name_of_their_gripper_in_any_chunks() {
        let mut daemon = Daemon { session: 7, seq: 0, wire: Vec::new() };
        daemon.notice("nobody answered");
        daemon.gripper(0);
        daemon.gripper(5);
        daemon.notice("gripper 5");
        daemon.health(1);
        daemon.health(2);
        let wanted = [Topic::Events, Topic::Events, Topic::Health, Topic::Health];
        for size in [1, 7, 64, 4096] {
            let mut bridge = Bridge::new(7);
            let chunks = daemon.wire.chunks(size);
            let taken: Vec<_> = chunks.flat_map(|chunk| take(&mut bridge, chunk)).collect();
            let topics: Vec<Topic> = taken.iter().map(|taken| taken.topic).collect();
            assert_eq!(topics, wanted);
            assert_eq!((bridge.uid(), bridge.nameless()), (Some(Uid([5; 16])), 2));
            let message = taken[1].message().unwrap();
            let Ok(ToClient::Notice(notice)) = message.read() else { panic!() };
            assert_eq!(notice.as_str(), "gripper 5");
            // Of each kind the last one.
            let status: Vec<&[u8]> = bridge.status().collect();
            assert_eq!(status.len(), 2);
            assert_eq!(status[1], taken[3].wire);
        }
    }

    #[test]
    fn what_the_daemon_says_of_the_connection_is_not_published_and_drops_are_counted() {
        let mut daemon = Daemon { session: 7, seq: 0, wire: Vec::new() };
        daemon.gripper(5);
        let dropped = |code: DroppedClass, count| Notice {
            kind: NoticeKind::Dropped,
            code: code.code(),
            value: 0,
            count,
            host_us: 0,
            text: b"you read too slowly",
        };
        daemon.say(Kind::NOTICE, |out| dropped(DroppedClass::Rows, 9).write(out).unwrap());
        daemon.say(Kind::NOTICE, |out| dropped(DroppedClass::News, 3).write(out).unwrap());
        let goodbye = Notice { kind: NoticeKind::Goodbye, ..dropped(DroppedClass::Rows, 0) };
        daemon.say(Kind::NOTICE, |out| goodbye.write(out).unwrap());
        let (mut bridge, mut heard) = (Bridge::new(7), Vec::new());
        bridge.receive(&daemon.wire, &mut |one| heard.push(one));
        assert_eq!(heard.len(), 2, "{heard:?}");
        assert_eq!(heard[1], Heard::Missed(3));
    }

    #[test]
    fn a_command_reaches_the_daemon_and_its_answer_comes_back() {
        let mut bridge = Bridge::new(7);
        let mut decoder = Decoder::new(Role::Daemon);
        let greeting = bridge.subscribe(0);
        assert!(decoder.next(&mut greeting.as_slice()).is_some());
        decoder.open_session(7, Some(0));
        let command = Command { force_mn: 1500, ..Command::new(Operation::AtLeast) };
        let mut daemon = Daemon { session: 7, seq: 0, wire: Vec::new() };
        for (number, reason) in [(1, None), (2, Some(NackReason::Forbidden))] {
            let (seq, wire) = bridge.command(&command);
            let Some(Verdict::Frame(frame)) = decoder.next(&mut wire.as_slice()) else { panic!() };
            assert_eq!((frame.header.seq, frame.header.ack_req, seq), (number, true, number));
            let Ok(ToDaemon::Command(got)) = ToDaemon::parse(&frame) else { panic!() };
            assert_eq!(got, command);
            let kind = Kind::COMMAND;
            match reason {
                None => daemon.say(Kind::ACK, |out| Ack { kind, seq }.write(out).unwrap()),
                Some(reason) => {
                    daemon.say(Kind::NACK, |out| Nack { kind, reason, seq }.write(out).unwrap());
                }
            }
        }
        // Answers to something else are for nobody.
        daemon.say(Kind::ACK, |out| Ack { kind: Kind::QUERY, seq: 3 }.write(out).unwrap());
        let mut heard = Vec::new();
        bridge.receive(&daemon.wire, &mut |one| heard.push(one));
        let refused = Heard::Answer(2, Err(NackReason::Forbidden));
        assert_eq!(heard, [Heard::Answer(1, Ok(())), refused]);
    }

    #[test]
    fn every_kind_has_its_topic_and_greetings_have_none() {
        for (kind, topic) in [
            (Kind::SLIP, Some(Topic::Events)),
            (Kind::NOTICE, Some(Topic::Events)),
            (Kind::GRIPPER, Some(Topic::Events)),
            (Kind::STATE, Some(Topic::State)),
            (Kind::HEALTH, Some(Topic::Health)),
            (Kind::ROWS, Some(Topic::Samples)),
            (Kind::WELCOME, None),
            (Kind::ACK, None),
            (Kind::NACK, None),
        ] {
            assert_eq!(super::topic(kind), topic, "{kind:?}");
        }
    }
}
