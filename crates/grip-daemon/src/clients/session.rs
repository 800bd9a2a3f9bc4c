//! Session of one client: what it asks for, from its bytes, and messages as bytes for it. No socket and no clock.

use super::outbox::{Class, Outbox, REPORTED};
use core::cmp::Ordering;
use grip_link::decoder::{Counters, Decoder, Fault, Role, Verdict};
use grip_link::frame::{Direction, Frame, Header, MAX_PAYLOAD};
use grip_link::message::daemon::{
    Command, Goodbye, Load, Notice, NoticeKind, Operation, Subscribe, ToDaemon, Topics, Welcome,
};
use grip_link::message::{Ack, Kind, Nack, NackReason, PayloadError, Versions};
use slip_core::{ClientCommand, units::Newtons};

/// A client that has not said SUBSCRIBE after this time is sent away (us).
pub const SILENCE_US: u64 = 5_000_000;
/// Bytes that are no frames, after which a client is sent away.
pub const MOST_GARBAGE_BYTES: u32 = 65_536;
/// Frames that are of no use, after which a client is sent away.
pub const MOST_BAD_FRAMES: u32 = 256;
/// Commands of one client in a second, STOP and those of the least force left out: of several that wait only one is carried out.
pub const MOST_COMMANDS_A_SECOND: u32 = 100;
/// Bytes from here on begin no SUBSCRIBE, but text: HTTP of a page in a browser, or a terminal.
const PRINTABLE: u8 = b' ';
/// Least time between two NOTICE of one class of drops while a client stays slow (us).
const REPORT_US: u64 = 1_000_000;

/// What a client may and is sent at its greeting; the same for all.
#[derive(Clone, Copy, Debug)]
pub struct Terms<'a> {
    /// WELCOME, without the token.
    pub welcome: Welcome<'a>,
    /// Whether commands are carried out.
    pub allow_commands: bool,
    /// Whether models are taken.
    pub allow_models: bool,
    /// What RELEASE must bear.
    pub token: u32,
    /// Commands of it that may still wait for the hot thread; STOP and the least force always may.
    pub room: usize,
    /// Why fingers would not move now: the link is away, or a fault is latched.
    pub immovable: Option<NackReason>,
    /// Largest force of the controller (N), where it is known.
    pub force_max_n: Option<f32>,
}

/// The file of a model that a client has brought.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Brought {
    /// What it should be.
    pub sha256: [u8; 32],
    /// What came.
    pub bytes: Vec<u8>,
}

/// What a client asked for, as far as others must act on it.
#[derive(Clone, Debug, PartialEq)]
pub enum Asked {
    /// It opened a session or changed what it receives.
    Subscribed,
    /// It wants everything known, then the answer to the request of this number.
    Query {
        /// Number of the request, where it wants an ACK.
        ack: Option<u16>,
    },
    /// It wants the gripper to do something, and may.
    Command(ClientCommand),
    /// It wants this model in force, or as a shadow, and may; none is that of the configuration, or no shadow.
    Load {
        /// [`Kind::LOAD`] or [`Kind::SHADOW`].
        kind: Kind,
        /// Number of the request, where it wants an answer.
        ack: Option<u16>,
        /// The whole file.
        model: Option<Brought>,
    },
    /// It names the next object, and may.
    Object {
        /// Number of the request, where it wants an answer.
        ack: Option<u16>,
        /// The name.
        name: String,
    },
}

/// One client.
#[derive(Debug)]
pub struct ClientSession {
    decoder: Decoder,
    outbox: Outbox,
    session: u16,
    seq: u16,
    subscription: Option<Subscribe>,
    /// First byte that is no delimiter.
    first: Option<u8>,
    /// When this second of commands began (us), and how many came in it.
    second: (u64, u32),
    malformed: u32,
    bad_commands: u32,
    goodbye: Option<Goodbye>,
    since_us: u64,
    progress_us: u64,
    reported_us: u64,
    next_state_us: u64,
    dropped: u32,
    loading: Pieces,
    shadowing: Pieces,
}

/// A model of which pieces have come, and the bytes that it will have.
#[derive(Debug, Default)]
struct Pieces(Option<(Brought, u32)>);

impl Pieces {
    /// Takes a piece; the whole file with the last one, and at once the request for the model of the configuration.
    fn take(&mut self, load: &Load<'_>, terms: &Terms<'_>) -> Result<Whole, NackReason> {
        let begun = self.0.take();
        if load.size == 0 {
            return Ok(Some(None));
        }
        if !terms.allow_models {
            return Err(NackReason::Forbidden);
        }
        let first = || Some((Brought { sha256: load.sha256, bytes: Vec::new() }, load.size));
        let begun = if load.offset == 0 { first() } else { begun };
        let (mut model, size) = begun.ok_or(NackReason::Malformed)?;
        let here = (model.sha256, size, model.bytes.len());
        let at = usize::try_from(load.offset).unwrap_or(usize::MAX);
        model.bytes.extend_from_slice(load.bytes);
        if here != (load.sha256, load.size, at) || load.bytes.is_empty() {
            return Err(NackReason::Malformed);
        }
        match model.bytes.len().cmp(&usize::try_from(size).unwrap_or(usize::MAX)) {
            Ordering::Less => self.0 = Some((model, size)),
            Ordering::Equal => return Ok(Some(Some(model))),
            Ordering::Greater => return Err(NackReason::Malformed),
        }
        Ok(None)
    }
}

/// A model, or that of the configuration, where nothing of it is missing.
type Whole = Option<Option<Brought>>;

/// What a frame asks for.
enum Request {
    Subscribe(Subscribe),
    Command(Command),
    Query,
    Load(Result<Whole, NackReason>),
    Object(String),
}

impl ClientSession {
    /// A connection that was just opened; `limit` bytes may wait for it.
    #[must_use]
    pub fn new(now_us: u64, limit: usize) -> Self {
        Self {
            decoder: Decoder::new(Role::Daemon),
            outbox: Outbox::new(limit),
            session: 0,
            seq: 0,
            subscription: None,
            first: None,
            second: (now_us, 0),
            malformed: 0,
            bad_commands: 0,
            goodbye: None,
            since_us: now_us,
            progress_us: now_us,
            reported_us: now_us,
            next_state_us: 0,
            dropped: 0,
            loading: Pieces::default(),
            shadowing: Pieces::default(),
        }
    }

    /// Takes bytes of the client. What it asks for is handed to `asked`; everything else is answered or counted here.
    pub fn receive(
        &mut self,
        now_us: u64,
        mut bytes: &[u8],
        terms: &Terms<'_>,
        asked: &mut dyn FnMut(Asked),
    ) {
        let mut room = terms.room;
        self.first = self.first.or_else(|| bytes.iter().copied().find(|byte| *byte != 0));
        if self.subscription.is_none() && self.first.is_some_and(|byte| byte >= PRINTABLE) {
            self.part(now_us, Goodbye::Garbage);
        }
        while self.goodbye.is_none() {
            let (header, parsed) = match self.decoder.next(&mut bytes) {
                None => break,
                Some(Verdict::Bad(fault)) => {
                    if let Fault::UnknownKind(header) = fault {
                        self.refuse(&header, NackReason::UnknownType);
                    }
                    self.judge(now_us);
                    continue;
                }
                Some(Verdict::Frame(frame)) => {
                    let Self { loading, shadowing, .. } = self;
                    let request = read(&frame).map(|message| match message {
                        ToDaemon::Subscribe(subscribe) => Request::Subscribe(subscribe),
                        ToDaemon::Command(command) => Request::Command(command),
                        ToDaemon::Query => Request::Query,
                        ToDaemon::Load(load) => Request::Load(loading.take(&load, terms)),
                        ToDaemon::Shadow(load) => Request::Load(shadowing.take(&load, terms)),
                        ToDaemon::Object(object) => Request::Object(object.name().to_owned()),
                    });
                    (frame.header, request)
                }
            };
            let Some(request) = self.request(now_us, &header, parsed, &Terms { room, ..*terms })
            else {
                self.judge(now_us);
                continue;
            };
            if let Asked::Command(command) = &request {
                room = room.saturating_sub(usize::from(!always(command)));
            }
            asked(request);
        }
    }

    fn request(
        &mut self,
        now_us: u64,
        header: &Header,
        parsed: Result<Request, PayloadError>,
        terms: &Terms<'_>,
    ) -> Option<Asked> {
        match parsed {
            Err(_) => {
                self.malformed = self.malformed.saturating_add(1);
                self.blame(header);
                if header.session != 0 {
                    self.refuse(header, NackReason::Malformed);
                }
                None
            }
            Ok(Request::Subscribe(subscribe)) => {
                self.subscribe(now_us, header, subscribe, terms).then_some(Asked::Subscribed)
            }
            Ok(Request::Query) => Some(Asked::Query { ack: header.ack_req.then_some(header.seq) }),
            Ok(Request::Command(command)) => match self.judge_command(now_us, &command, terms) {
                Ok(command) => {
                    self.accept(header.ack_req.then_some(header.seq), header.kind);
                    Some(Asked::Command(command))
                }
                Err(reason) => {
                    self.blame(header);
                    self.refuse(header, reason);
                    None
                }
            },
            Ok(Request::Object(name)) if terms.allow_commands => {
                Some(Asked::Object { ack: header.ack_req.then_some(header.seq), name })
            }
            Ok(Request::Object(_)) => {
                self.refuse(header, NackReason::Forbidden);
                None
            }
            Ok(Request::Load(piece)) => {
                let ack = header.ack_req.then_some(header.seq);
                match piece {
                    Ok(Some(model)) => return Some(Asked::Load { kind: header.kind, ack, model }),
                    Ok(None) => self.accept(ack, header.kind),
                    Err(reason) => self.refuse(header, reason),
                }
                None
            }
        }
    }

    fn judge_command(
        &mut self,
        now_us: u64,
        command: &Command,
        terms: &Terms<'_>,
    ) -> Result<ClientCommand, NackReason> {
        let judged = judge(command, terms)?;
        if always(&judged) {
            return Ok(judged);
        }
        if terms.room == 0 {
            return Err(NackReason::Busy);
        }
        let (since_us, count) = self.second;
        let fresh = now_us.saturating_sub(since_us) >= 1_000_000;
        self.second = if fresh { (now_us, 1) } else { (since_us, count.saturating_add(1)) };
        if self.second.1 > MOST_COMMANDS_A_SECOND { Err(NackReason::Busy) } else { Ok(judged) }
    }

    fn subscribe(
        &mut self,
        now_us: u64,
        header: &Header,
        subscribe: Subscribe,
        terms: &Terms<'_>,
    ) -> bool {
        self.session = header.session;
        let token = if terms.allow_commands { terms.token } else { 0 };
        let welcome = Welcome { token, host_us: now_us, ..terms.welcome };
        self.message(Class::Answers, Kind::WELCOME, |out| welcome.write(out));
        if Versions::OURS.common(subscribe.versions).is_none() {
            self.part(now_us, Goodbye::Version);
            return false;
        }
        self.decoder.open_session(header.session, Some(header.seq));
        self.subscription = Some(subscribe);
        self.next_state_us = 0;
        true
    }

    /// Answers a request with ACK; `None` for one that wants no answer.
    pub fn accept(&mut self, request: Option<u16>, kind: Kind) {
        if let Some(seq) = request {
            let ack = Ack { kind, seq };
            self.message(Class::Answers, Kind::ACK, |out| ack.write(out));
        }
    }

    fn blame(&mut self, header: &Header) {
        let bad = u32::from(header.kind == Kind::COMMAND);
        self.bad_commands = self.bad_commands.saturating_add(bad);
    }

    fn refuse(&mut self, header: &Header, reason: NackReason) {
        self.decline(header.ack_req.then_some(header.seq), header.kind, reason);
    }

    /// Answers a request with NACK; nothing for one that wants no answer.
    pub fn decline(&mut self, request: Option<u16>, kind: Kind, reason: NackReason) {
        if let Some(seq) = request {
            let nack = Nack { kind, reason, seq };
            self.message(Class::Answers, Kind::NACK, |out| nack.write(out));
        }
    }

    /// Puts a payload behind the others; `false`, and counted, where it finds no room.
    pub fn send(&mut self, class: Class, kind: Kind, payload: &[u8]) -> bool {
        let header = Header::new(Direction::ToHost, kind, self.seq, self.session);
        let sent = self.outbox.push(class, &header, payload);
        if sent {
            self.seq = self.seq.wrapping_add(1);
        } else {
            self.dropped = self.dropped.saturating_add(1);
        }
        sent
    }

    /// As [`ClientSession::send`], with a message that writes its own payload.
    pub fn message(
        &mut self,
        class: Class,
        kind: Kind,
        write: impl FnOnce(&mut [u8]) -> Result<usize, PayloadError>,
    ) -> bool {
        let mut payload = [0; MAX_PAYLOAD];
        let len = write(&mut payload).unwrap_or(0);
        payload.get(..len).is_some_and(|payload| self.send(class, kind, payload))
    }

    /// Whether it wants to receive a topic.
    #[must_use]
    pub fn receives(&self, topic: Topics) -> bool {
        self.subscription.is_some_and(|wanted| wanted.topics.has(topic))
    }

    /// It wants every n-th sample; `None` for no samples.
    #[must_use]
    pub fn every_nth(&self) -> Option<u16> {
        self.subscription.map(|wanted| wanted.every_nth).filter(|n| *n > 0)
    }

    /// Whether it has opened a session.
    #[must_use]
    pub const fn is_subscribed(&self) -> bool {
        self.subscription.is_some()
    }

    /// Whether a STATE of this host time is due for it; the next one is due after its interval.
    pub fn state_is_due(&mut self, host_us: u64) -> bool {
        let Some(wanted) = self.subscription.filter(|wanted| wanted.topics.has(Topics::STATE))
        else {
            return false;
        };
        if host_us < self.next_state_us {
            return false;
        }
        self.next_state_us = host_us.saturating_add(1000 * u64::from(wanted.state_ms));
        true
    }

    /// Bytes to be written, oldest first.
    #[must_use]
    pub fn outgoing(&self) -> &[u8] {
        self.outbox.waiting()
    }

    /// The client took `count` bytes.
    pub fn written(&mut self, now_us: u64, count: usize) {
        self.outbox.taken(count);
        if count > 0 {
            self.progress_us = now_us;
        }
    }

    /// Time has passed: drops are reported once there is room, and who is silent or takes nothing is sent away.
    pub fn tick(&mut self, now_us: u64, stall_us: u64) {
        if self.outgoing().is_empty() {
            self.progress_us = now_us;
        }
        if now_us.saturating_sub(self.progress_us) > stall_us {
            self.part(now_us, Goodbye::Stalled);
        } else if self.subscription.is_none() && now_us.saturating_sub(self.since_us) > SILENCE_US {
            self.part(now_us, Goodbye::Silent);
        }
        if self.outbox.is_calm() || now_us.saturating_sub(self.reported_us) > REPORT_US {
            self.report_drops(now_us);
        }
    }

    fn report_drops(&mut self, now_us: u64) {
        for (class, code) in REPORTED {
            let count = self.outbox.dropped(class);
            if count == 0 {
                continue;
            }
            self.reported_us = now_us;
            let text = format!("{count} frames of {} dropped: you read too slowly", code.name());
            let notice = Notice {
                kind: NoticeKind::Dropped,
                code: code.code(),
                value: 0,
                count,
                host_us: now_us,
                text: text.as_bytes(),
            };
            if self.message(Class::Answers, Kind::NOTICE, |out| notice.write(out)) {
                self.outbox.reported(class, count);
            }
        }
    }

    fn judge(&mut self, now_us: u64) {
        let counters = self.decoder.counters();
        let useless = [counters.echo, counters.version, counters.stale, counters.duplicate];
        let bad = useless.iter().fold(counters.bad_blocks(), |sum, n| sum.saturating_add(*n));
        let bad = bad.saturating_add(counters.unknown).saturating_add(self.malformed);
        let first = self.subscription.is_none() && bad > 0;
        if first || counters.garbage_bytes > MOST_GARBAGE_BYTES || bad > MOST_BAD_FRAMES {
            self.part(now_us, Goodbye::Garbage);
        }
    }

    /// Reports why the connection ends. Nothing is received any more; the caller closes it after one more write.
    pub fn part(&mut self, now_us: u64, reason: Goodbye) {
        if self.goodbye.is_some() {
            return;
        }
        self.goodbye = Some(reason);
        let notice = Notice {
            kind: NoticeKind::Goodbye,
            code: reason.code(),
            value: 0,
            count: 0,
            host_us: now_us,
            text: farewell(reason).as_bytes(),
        };
        self.message(Class::Answers, Kind::NOTICE, |out| notice.write(out));
    }

    /// Why the connection ends; `None` while it goes on.
    #[must_use]
    pub const fn goodbye(&self) -> Option<Goodbye> {
        self.goodbye
    }

    /// Whether it was sent away because it did not begin with SUBSCRIBE.
    #[must_use]
    pub const fn is_stranger(&self) -> bool {
        self.subscription.is_none() && matches!(self.goodbye, Some(Goodbye::Garbage))
    }

    /// What was received so far.
    #[must_use]
    pub const fn counters(&self) -> &Counters {
        self.decoder.counters()
    }

    /// Frames that could not be read although they were good.
    #[must_use]
    pub const fn malformed(&self) -> u32 {
        self.malformed
    }

    /// Commands that were not allowed or could not be read.
    #[must_use]
    pub const fn bad_commands(&self) -> u32 {
        self.bad_commands
    }

    /// Frames dropped because it was too slow.
    #[must_use]
    pub const fn dropped(&self) -> u32 {
        self.dropped
    }
}

/// The session must have a nonce, whatever the payload states.
fn read<'a>(frame: &Frame<'a>) -> Result<ToDaemon<'a>, PayloadError> {
    if frame.header.session == 0 {
        return Err(PayloadError::Kind { kind: frame.header.kind.0 });
    }
    ToDaemon::parse(frame)
}

/// Whether it is taken however many came or wait: of several that wait, one is carried out.
const fn always(command: &ClientCommand) -> bool {
    matches!(command, ClientCommand::Stop | ClientCommand::AtLeast(_))
}

/// What a command means, where it may be carried out.
fn judge(command: &Command, terms: &Terms<'_>) -> Result<ClientCommand, NackReason> {
    if !terms.allow_commands {
        return Err(NackReason::Forbidden);
    }
    // An order that nobody can carry out now must not move fingers later, when power is back or a fault cleared.
    let moves = matches!(command.operation, Operation::Release | Operation::Grasp);
    if let Some(reason) = terms.immovable.filter(|_| moves) {
        return Err(reason);
    }
    let force_n = Newtons::from_mn(command.force_mn).0;
    let forces = matches!(command.operation, Operation::AtLeast | Operation::Expect);
    // A millinewton is the step of the protocol.
    if forces && terms.force_max_n.is_some_and(|most_n| force_n > most_n + 1e-3) {
        return Err(NackReason::Malformed);
    }
    Ok(match command.operation {
        Operation::AtLeast => ClientCommand::AtLeast(force_n),
        Operation::Release if command.token == terms.token => ClientCommand::Release,
        Operation::Release => return Err(NackReason::Token),
        Operation::Expect => ClientCommand::Expect(force_n),
        Operation::Grasp => ClientCommand::Grasp,
        Operation::Stop => ClientCommand::Stop,
        Operation::ClearFault => ClientCommand::ClearFault(command.fault),
    })
}

const fn farewell(reason: Goodbye) -> &'static str {
    match reason {
        Goodbye::Version => "no protocol version in common",
        Goodbye::Silent => "no SUBSCRIBE came within 5 s",
        Goodbye::Stalled => "you took nothing for too long",
        Goodbye::Garbage => "you send what is no frame, or not SUBSCRIBE first",
        Goodbye::Full => "too many clients are connected",
        Goodbye::Ending => "the daemon ends",
        _ => "",
    }
}
