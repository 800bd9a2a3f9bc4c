//! Bridge from the bytes of a daemon's socket to what is to be published of them. No socket and no clock.

use crate::{
    deploy::{ModelId, hex},
    key::Part,
    message,
};
use grip_link::{
    decoder::{Decoder, Role, Verdict},
    frame::{self, Direction, Header, MAX_PAYLOAD, MAX_WIRE},
    message::{
        Kind, NackReason, PayloadError, Versions,
        daemon::{
            Command, DroppedClass, Estimates, Load, NoticeKind, PipelineState, SlipReport,
            Subscribe, ToClient, Topics, WelcomeFlags,
        },
    },
};
use grip_session::config::Uid;

/// Milliseconds between two STATE.
const STATE_MS: u16 = 200;

/// Something to be published.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Publication {
    /// Under which name.
    pub topic: Part,
    /// The frame.
    pub wire: Vec<u8>,
}

/// What comes from a daemon.
#[derive(Clone, Debug, PartialEq)]
pub enum Incoming {
    /// Something to be published.
    Publication(Publication),
    /// The daemon had no room for so many events: this end has read too slowly.
    Missed(u32),
    /// The daemon answers the command or the model of this number.
    Answer(u16, Result<(), NackReason>),
    /// The daemon introduces itself.
    Welcome(Greeting),
    /// What the daemon works with.
    Setup(Setup),
    /// What the pipeline thinks; it is published too.
    State(PipelineState),
    /// A slip that was not received before; it is published too.
    Slip(SlipReport),
    /// What two models made of the last slip.
    Estimates(Estimates),
    /// The daemon closes this connection, for this reason.
    Goodbye(String),
}

/// What a daemon reports of itself.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Greeting {
    /// Name and version.
    pub program: String,
    /// Time since its start (us).
    pub host_us: u64,
    /// What a RELEASE must bear; none where commands are not allowed.
    pub token: Option<u32>,
    /// Whether it takes models of clients.
    pub takes_models: bool,
}

/// What a daemon works with.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Setup {
    /// Reloads since its start.
    pub settings: u32,
    /// Firmware of the gripper, as soon as one was seen.
    pub firmware: Option<String>,
    /// SHA-256 of the model in force, in hexadecimal digits.
    pub in_force: String,
    /// The model that the configuration names.
    pub configured: ModelId,
}

/// Where a daemon was when it was last received from: its start, and the number of its last slip. By default nothing was received yet.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LastReceived {
    run_id: u32,
    slip: u32,
}

/// One connection to a daemon, as a client that receives everything but samples.
#[derive(Debug)]
pub struct Bridge {
    decoder: Decoder,
    session: u16,
    uid: Option<Uid>,
    /// The last GRIPPER, STATE and HEALTH.
    known: [Option<Vec<u8>>; 3],
    /// Number of the last request.
    seq: u16,
    slips: Slips,
}

/// Which slips were received.
#[derive(Debug)]
struct Slips {
    /// Where the daemon was when it was last received from, before this connection and now.
    before: Option<LastReceived>,
    now: Option<LastReceived>,
    /// The slips that come were before this connection: QUERY reports the last ones again.
    old: bool,
}

impl Bridge {
    /// A session of this nonce; 0 becomes 1. Slips since `before` that the daemon still knows are received; without it, none that were before.
    #[must_use]
    pub fn new(nonce: u16, before: Option<LastReceived>) -> Self {
        let session = nonce.max(1);
        let mut decoder = Decoder::new(Role::Client);
        decoder.open_session(session, None);
        Self {
            decoder,
            session,
            uid: None,
            known: [None, None, None],
            seq: 0,
            slips: Slips { before, now: None, old: true },
        }
    }

    /// Where the daemon is now, for the next connection.
    #[must_use]
    pub fn last_received(&self) -> Option<LastReceived> {
        self.slips.now.or(self.slips.before)
    }

    /// The first request to the daemon; every n-th sample is wanted, none for 0. It answers with everything known.
    pub fn subscribe(&mut self, every_nth: u16) -> Vec<u8> {
        let (versions, topics) = (Versions::OURS, Topics::ALL);
        let wanted = Subscribe { versions, topics, every_nth, state_ms: STATE_MS };
        let subscribe = self.request(Kind::SUBSCRIBE, true, |out| wanted.write(out)).1;
        [subscribe, self.request(Kind::QUERY, true, |_| Ok(0)).1].concat()
    }

    /// A command for the fingers, and its number in [`Incoming::Answer`].
    pub fn command(&mut self, command: &Command) -> (u16, Vec<u8>) {
        self.request(Kind::COMMAND, true, |out| command.write(out))
    }

    /// A model file, or that of the configuration, to be put in force, and the number of its answer in [`Incoming::Answer`].
    pub fn load(&mut self, file: Option<(&[u8; 32], &[u8])>) -> (u16, Vec<u8>) {
        self.bring(Kind::LOAD, file)
    }

    /// A model file that is to estimate beside the one in force, or none any more, and the number of its answer.
    pub fn shadow(&mut self, file: Option<(&[u8; 32], &[u8])>) -> (u16, Vec<u8>) {
        self.bring(Kind::SHADOW, file)
    }

    fn bring(&mut self, kind: Kind, file: Option<(&[u8; 32], &[u8])>) -> (u16, Vec<u8>) {
        let (sha256, file) = file.unwrap_or((&[0; 32], &[]));
        let size = u32::try_from(file.len()).unwrap_or(u32::MAX);
        let mut wire = Vec::new();
        let mut pieces = file.chunks(Load::PIECE).peekable();
        let mut offset = 0;
        loop {
            let bytes = pieces.next().unwrap_or_default();
            let load = Load { sha256: *sha256, size, offset, bytes };
            let is_last = pieces.peek().is_none();
            let (seq, piece) = self.request(kind, is_last, |out| load.write(out));
            wire.extend_from_slice(&piece);
            if is_last {
                return (seq, wire);
            }
            offset += u32::try_from(bytes.len()).unwrap_or(0);
        }
    }

    fn request(
        &mut self,
        kind: Kind,
        ack_req: bool,
        write: impl FnOnce(&mut [u8]) -> Result<usize, PayloadError>,
    ) -> (u16, Vec<u8>) {
        let (mut payload, mut wire) = ([0; MAX_PAYLOAD], [0; MAX_WIRE]);
        self.seq = self.seq.wrapping_add(1);
        let header = Header::new(Direction::ToDevice, kind, self.seq, self.session);
        let header = Header { ack_req, ..header };
        let payload = write(&mut payload).ok().and_then(|len| payload.get(..len));
        let len = frame::encode(&header, payload.unwrap_or_default(), &mut wire).unwrap_or(0);
        (self.seq, wire.get(..len).unwrap_or_default().to_vec())
    }

    /// Takes bytes: what they complete. What the daemon reports of this connection is for nobody else. Updates of a gripper that has not said who it is have no name.
    pub fn receive(&mut self, mut bytes: &[u8]) -> Vec<Incoming> {
        let mut received = Vec::new();
        while let Some(verdict) = self.decoder.next(&mut bytes) {
            let Verdict::Frame(frame) = verdict else { continue };
            // What cannot be read, or is of a later daemon, is for nobody.
            let Ok(message) = ToClient::parse(&frame) else { continue };
            let topic = take(&message, &mut self.slips, &mut received);
            let place = match &message {
                ToClient::Gripper(gripper) => {
                    self.uid = Some(Uid(gripper.uid)).filter(|uid| uid.0 != [0; 16]);
                    Some(0)
                }
                ToClient::State(_) => Some(1),
                ToClient::Health(_) => Some(2),
                _ => None,
            };
            // A frame that was received can be written.
            let Some(topic) = topic else { continue };
            let Ok(wire) = message::encoded(frame.header.kind, frame.payload) else { continue };
            if let Some(place) = place.and_then(|place| self.known.get_mut(place)) {
                *place = Some(wire.clone());
            }
            if self.uid.is_some() {
                received.push(Incoming::Publication(Publication { topic, wire }));
            }
        }
        received
    }

    /// Which gripper it is, as soon as it is known.
    #[must_use]
    pub const fn uid(&self) -> Option<Uid> {
        self.uid
    }

    /// The last GRIPPER, STATE and HEALTH, as far as there were any.
    pub fn status(&self) -> impl Iterator<Item = &[u8]> {
        self.known.iter().flatten().map(Vec::as_slice)
    }
}

impl Slips {
    /// A daemon introduces itself.
    fn meet(&mut self, run_id: u32) {
        let same = self.before.filter(|before| before.run_id == run_id);
        self.now = Some(LastReceived { run_id, slip: same.map_or(0, |before| before.slip) });
    }

    /// How many slips before this one nobody knows any more; `None` for one that was received, or that nobody has missed.
    fn missed(&mut self, number: u32) -> Option<u32> {
        let Some(now) = &mut self.now else { return Some(0) };
        let last = now.slip;
        now.slip = last.max(number);
        let is_new = number > last && !(self.old && self.before.is_none());
        // What is dropped later gripd counts itself.
        let missed = if self.old { number.saturating_sub(last).saturating_sub(1) } else { 0 };
        is_new.then_some(missed)
    }
}

/// Hands out what is of use here; under which name the message is published, where it is not for this connection only.
fn take(message: &ToClient<'_>, slips: &mut Slips, out: &mut Vec<Incoming>) -> Option<Part> {
    let asked = |kind| [Kind::COMMAND, Kind::LOAD, Kind::SHADOW].contains(&kind);
    match message {
        ToClient::Welcome(welcome) => {
            slips.meet(welcome.run_id);
            out.push(Incoming::Welcome(Greeting {
                program: welcome.daemon().to_owned(),
                host_us: welcome.host_us,
                token: welcome.flags.has(WelcomeFlags::COMMANDS).then_some(welcome.token),
                takes_models: welcome.flags.has(WelcomeFlags::MODELS),
            }));
        }
        ToClient::Ack(ack) => {
            slips.old &= ack.kind != Kind::QUERY;
            if asked(ack.kind) {
                out.push(Incoming::Answer(ack.seq, Ok(())));
            }
        }
        ToClient::Nack(no) if asked(no.kind) => out.push(Incoming::Answer(no.seq, Err(no.reason))),
        ToClient::Nack(_) => {}
        ToClient::Setup(setup) => {
            let firmware = Some(setup.firmware.to_string()).filter(|text| text != "0.0.0");
            let (name, sha256) = (setup.configured_name().to_owned(), hex(&setup.configured));
            let (settings, in_force) = (setup.settings, hex(&setup.in_force));
            let configured = ModelId { name, sha256 };
            out.push(Incoming::Setup(Setup { settings, firmware, in_force, configured }));
        }
        ToClient::Estimates(made) => out.push(Incoming::Estimates(*made)),
        ToClient::State(state) => {
            out.push(Incoming::State(*state));
            return Some(Part::State);
        }
        ToClient::Slip(slip) => {
            let missed = slips.missed(slip.number)?;
            if missed > 0 {
                out.push(Incoming::Missed(missed));
            }
            out.push(Incoming::Slip(*slip));
            return Some(Part::Events);
        }
        ToClient::Notice(notice) => match notice.kind {
            NoticeKind::Dropped => {
                if notice.code == DroppedClass::News.code() && notice.count > 0 {
                    out.push(Incoming::Missed(notice.count));
                }
            }
            NoticeKind::Goodbye => out.push(Incoming::Goodbye(notice.as_str().to_owned())),
            _ => return Some(Part::Events),
        },
        ToClient::Gripper(_) => return Some(Part::Events),
        ToClient::Health(_) => return Some(Part::Health),
        ToClient::Rows(_) => return Some(Part::Samples),
    }
    None
}

#[cfg(test)]
mod tests {
    use super::{Bridge, Incoming, LastReceived, Part, Publication};
    use crate::message::Message;
    use grip_link::{
        decoder::{Decoder, Role, Verdict},
        frame::{self, Direction, Header, MAX_PAYLOAD, MAX_WIRE},
        message::{
            Ack, Kind, Nack, NackReason, Versions,
            daemon::{
                Command, DroppedClass, Gripper, Health, Notice, NoticeKind, Operation, RealTime,
                SlipReport, ToClient, ToDaemon, Welcome, WelcomeFlags,
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
        fn send(&mut self, kind: Kind, write: impl FnOnce(&mut [u8]) -> usize) {
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
            self.send(Kind::NOTICE, |out| notice.write(out).unwrap());
        }

        fn gripper(&mut self, uid: u8) {
            let gripper = Gripper { uid: [uid; 16], ..Gripper::NONE };
            self.send(Kind::GRIPPER, |out| gripper.write(out).unwrap());
        }

        fn health(&mut self, samples: u64) {
            let health = Health { samples, ..Health::default() };
            self.send(Kind::HEALTH, |out| health.write(out).unwrap());
        }
    }

    fn take(bridge: &mut Bridge, bytes: &[u8]) -> Vec<Publication> {
        let received = bridge.receive(bytes).into_iter();
        let taken = received.map(|incoming| match incoming {
            Incoming::Publication(publication) => publication,
            other => panic!("{other:?}"),
        });
        taken.collect()
    }

    #[test]
    fn it_greets_as_a_client_that_receives_everything() {
        let mut bridge = Bridge::new(7, None);
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
        let wanted = [Part::Events, Part::Events, Part::Health, Part::Health];
        for size in [1, 7, 64, 4096] {
            let mut bridge = Bridge::new(7, None);
            let chunks = daemon.wire.chunks(size);
            let taken: Vec<_> = chunks.flat_map(|chunk| take(&mut bridge, chunk)).collect();
            let topics: Vec<Part> = taken.iter().map(|taken| taken.topic).collect();
            assert_eq!(topics, wanted);
            assert_eq!(bridge.uid(), Some(Uid([5; 16])));
            let message = Message::from_wire(&taken[1].wire).unwrap();
            let Ok(ToClient::Notice(notice)) = message.read() else { panic!() };
            assert_eq!(notice.as_str(), "gripper 5");
            // Of each kind the last one.
            let status: Vec<&[u8]> = bridge.status().collect();
            assert_eq!(status.len(), 2);
            assert_eq!(status[1], taken[3].wire);
        }
    }

    #[test]
    fn what_the_daemon_states_of_the_connection_is_not_published_and_drops_are_counted() {
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
        daemon.send(Kind::NOTICE, |out| dropped(DroppedClass::Rows, 9).write(out).unwrap());
        daemon.send(Kind::NOTICE, |out| dropped(DroppedClass::News, 3).write(out).unwrap());
        let goodbye = Notice { kind: NoticeKind::Goodbye, ..dropped(DroppedClass::Rows, 0) };
        daemon.send(Kind::NOTICE, |out| goodbye.write(out).unwrap());
        let received = Bridge::new(7, None).receive(&daemon.wire);
        assert_eq!(received.len(), 3, "{received:?}");
        assert_eq!(received[1], Incoming::Missed(3));
        assert_eq!(received[2], Incoming::Goodbye("you read too slowly".to_owned()));
    }

    #[test]
    fn a_command_reaches_the_daemon_and_its_answer_comes_back() {
        let mut bridge = Bridge::new(7, None);
        let mut decoder = Decoder::new(Role::Daemon);
        let greeting = bridge.subscribe(0);
        assert!(decoder.next(&mut greeting.as_slice()).is_some());
        decoder.open_session(7, Some(2));
        let command = Command { force_mn: 1500, ..Command::new(Operation::AtLeast) };
        let mut daemon = Daemon { session: 7, seq: 0, wire: Vec::new() };
        for (number, reason) in [(3, None), (4, Some(NackReason::Forbidden))] {
            let (seq, wire) = bridge.command(&command);
            let Some(Verdict::Frame(frame)) = decoder.next(&mut wire.as_slice()) else { panic!() };
            assert_eq!((frame.header.seq, frame.header.ack_req, seq), (number, true, number));
            let Ok(ToDaemon::Command(got)) = ToDaemon::parse(&frame) else { panic!() };
            assert_eq!(got, command);
            let kind = Kind::COMMAND;
            match reason {
                None => daemon.send(Kind::ACK, |out| Ack { kind, seq }.write(out).unwrap()),
                Some(reason) => {
                    daemon.send(Kind::NACK, |out| Nack { kind, reason, seq }.write(out).unwrap());
                }
            }
        }
        // Answers to something else are for nobody.
        daemon.send(Kind::ACK, |out| Ack { kind: Kind::QUERY, seq: 3 }.write(out).unwrap());
        let refused = Incoming::Answer(4, Err(NackReason::Forbidden));
        assert_eq!(bridge.receive(&daemon.wire), [Incoming::Answer(3, Ok(())), refused]);
    }

    /// Which slips are received of a start of the daemon that still knows three, with one more that comes live; 100 stands for one that is missed.
    fn slips(bridge: &mut Bridge, run_id: u32) -> Vec<u32> {
        let mut daemon = Daemon { session: 7, seq: 0, wire: Vec::new() };
        let welcome = Welcome {
            versions: Versions::OURS,
            max_rx: 480,
            flags: WelcomeFlags::MODELS,
            token: 0,
            run_id,
            host_us: 5,
            real_time: RealTime::NotAsked,
            text: b"gripd x",
        };
        daemon.send(Kind::WELCOME, |out| welcome.write(out).unwrap());
        daemon.gripper(5);
        for number in [3, 4, 5, 6] {
            if number == 6 {
                daemon.send(Kind::ACK, |out| Ack { kind: Kind::QUERY, seq: 2 }.write(out).unwrap());
            }
            let slip = SlipReport { number, ..SlipReport::UNKNOWN };
            daemon.send(Kind::SLIP, |out| slip.write(out).unwrap());
        }
        let number = |incoming| match incoming {
            Incoming::Slip(slip) => Some(slip.number),
            Incoming::Missed(missed) => Some(100 * missed),
            Incoming::Welcome(greeting) => {
                assert!(greeting.takes_models && greeting.token.is_none());
                None
            }
            _ => None,
        };
        bridge.receive(&daemon.wire).into_iter().filter_map(number).collect()
    }

    #[test]
    fn slips_are_received_once_also_over_another_connection() {
        let mut first = Bridge::new(7, None);
        assert_eq!(slips(&mut first, 9), [6], "what was before it came");
        let mut second = Bridge::new(7, Some(LastReceived { run_id: 9, slip: 4 }));
        assert_eq!(slips(&mut second, 9), [5, 6]);
        let mut late = Bridge::new(7, Some(LastReceived { run_id: 9, slip: 1 }));
        assert_eq!(slips(&mut late, 9), [100, 3, 4, 5, 6]);
        let mut third = Bridge::new(7, second.last_received());
        assert_eq!(slips(&mut third, 9), [0; 0]);
        let mut restarted = Bridge::new(7, third.last_received());
        assert_eq!(slips(&mut restarted, 10), [200, 3, 4, 5, 6]);
        assert_eq!(
            Bridge::new(7, restarted.last_received()).last_received(),
            restarted.last_received()
        );
    }

    #[test]
    fn a_model_goes_in_pieces_and_asks_for_one_answer() {
        let file: Vec<u8> = (0..600_u32).map(|at| at.to_le_bytes()[0]).collect();
        for (file, pieces) in [(Some((&[7; 32], &file[..])), 3), (None, 1)] {
            let mut bridge = Bridge::new(7, None);
            let mut decoder = Decoder::new(Role::Daemon);
            decoder.open_session(7, Some(0));
            let (number, wire) = bridge.load(file);
            let (mut wire, mut came) = (wire.as_slice(), Vec::new());
            let mut asked = Vec::new();
            while let Some(Verdict::Frame(frame)) = decoder.next(&mut wire) {
                let Ok(ToDaemon::Load(load)) = ToDaemon::parse(&frame) else { panic!() };
                assert_eq!(usize::try_from(load.offset), Ok(came.len()));
                assert_eq!(usize::try_from(load.size), Ok(file.map_or(0, |file| file.1.len())));
                came.extend_from_slice(load.bytes);
                asked.push((frame.header.ack_req, frame.header.seq));
            }
            assert_eq!(
                (came.as_slice(), asked.len()),
                (file.map_or(&[][..], |file| file.1), pieces)
            );
            assert_eq!(asked.iter().filter(|(asks, _)| *asks).count(), 1);
            assert_eq!(asked.last(), Some(&(true, number)));
        }
    }
}
