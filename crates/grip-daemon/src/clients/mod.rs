//! Server for clients at their connections: frames for each from items of the hot thread, and the commands of those that may.
//!
//! [`ClientSession`] is one client without a socket. [`Clients`] are all of them at their sockets: nothing here ever waits for a
//! client. What a slow one does not fetch in time is dropped for it, samples first and frame by frame, and it is reported how
//! much; one that takes nothing at all, sends rubbish or never subscribes is sent away. `protocol/CLIENTS.md` states what
//! goes over the socket.

mod batch;
mod figures;
mod least;
mod listen;
mod outbox;
mod roster;
mod session;

pub use figures::{health, latency};
pub use grip_session::config::Listen;
pub use listen::{ListenError, REMOTE_WARNING, Stream};
pub use outbox::Class;
pub use roster::{About, Setup};
pub use session::{
    Asked, Brought, ClientSession, MOST_BAD_FRAMES, MOST_COMMANDS_A_SECOND, MOST_GARBAGE_BYTES,
    SILENCE_US, Terms,
};

use crate::Item;
use batch::Row;
use core::time::Duration;
use grip_link::message::daemon::{Estimates, Goodbye, Health};
use grip_link::message::{Kind, NackReason};
use least::Least;
pub(crate) use listen::Listener;
use roster::{Known, Roster};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::Errno;
use slip_core::ClientCommand;
use std::collections::VecDeque;
use std::io::{self, Read as _, Write as _};

/// Commands that may wait for the hot thread, and how many of them of one client, so that none takes the place of another.
const MOST_COMMANDS: usize = 1024;
const MOST_OF_ONE: usize = 16;
/// Bytes read of one client in one turn, so that one that floods does not keep the others waiting.
const MOST_READ: usize = 16 * 1024;
/// Connections taken in one turn.
const MOST_ACCEPTED: usize = 64;
/// The listening socket rests so long after an error (us): with no file descriptor left it would be ready for ever.
const REST_US: u64 = 100_000;

/// How clients are served.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ClientsConfig {
    /// Where they connect.
    pub listen: Listen,
    /// Whether `listen` may be an address that other computers reach.
    pub allow_remote: bool,
    /// Whether they may command the gripper.
    pub allow_commands: bool,
    /// Whether they may bring a model.
    pub allow_models: bool,
    /// Most clients at one time.
    pub most: usize,
    /// Bytes that may wait for a client.
    pub buffer_bytes: usize,
    /// A client that takes nothing for so long is sent away (us).
    pub stall_us: u64,
}

impl Default for ClientsConfig {
    /// Loopback, read only, 32 clients, 256 KiB each, 10 s.
    fn default() -> Self {
        Self {
            listen: Listen::default(),
            allow_remote: false,
            allow_commands: false,
            allow_models: false,
            most: 32,
            buffer_bytes: 256 * 1024,
            stall_us: 10_000_000,
        }
    }
}

/// What happened to clients since the daemon's start; all saturate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ClientCounters {
    /// Connections taken.
    pub accepted: u64,
    /// Connections refused because there were too many.
    pub refused: u64,
    /// Clients sent away: silent, stalled, garbage, versions.
    pub sent_away: u64,
    /// Frames dropped because their client was too slow.
    pub dropped: u64,
    /// Commands taken.
    pub commands: u64,
    /// Commands not allowed or not understood.
    pub bad_commands: u64,
    /// Errors of the listening socket.
    pub accept_errors: u64,
}

/// A connection and its session.
#[derive(Debug)]
struct Client {
    stream: Stream,
    session: ClientSession,
    gone: bool,
    /// No other client has had it.
    id: u64,
}

/// A model that a client wants in force, or as a shadow; it is answered when that is so.
#[derive(Clone, Debug)]
pub struct Loading {
    kind: Kind,
    /// The client, and the number of its request where it wants an answer.
    client: u64,
    ack: Option<u16>,
    /// The whole file; none is the model of the configuration, or no shadow.
    pub model: Option<Brought>,
}

impl Loading {
    /// Whether the model is only asked beside the one in force.
    #[must_use]
    pub fn is_shadow(&self) -> bool {
        self.kind == Kind::SHADOW
    }
}

/// A name that a client gives to the next object.
#[derive(Clone, Debug)]
pub struct Naming {
    client: u64,
    ack: Option<u16>,
    /// The name.
    pub name: String,
}

impl Client {
    /// Writes what the socket takes.
    fn write(&mut self, now_us: u64) {
        while !self.gone && !self.session.outgoing().is_empty() {
            match self.stream.write(self.session.outgoing()) {
                Ok(0) => self.gone = true,
                Ok(count) => self.session.written(now_us, count),
                Err(error) if error.kind() == io::ErrorKind::WouldBlock => break,
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(_) => self.gone = true,
            }
        }
    }
}

/// All clients at their sockets.
#[derive(Debug)]
pub struct Clients {
    config: ClientsConfig,
    about: About,
    listener: Option<Listener>,
    resting_until_us: u64,
    roster: Roster,
    known: Known,
    /// Each with its client; the least force has none.
    commands: VecDeque<(Option<u64>, ClientCommand)>,
    least: Least,
    /// Connections that did not begin with SUBSCRIBE and were not reported yet.
    strangers: u32,
    /// A model that waits to be fetched, and the clients whose model is in force, and is the shadow.
    load: Option<Loading>,
    bearer: Option<u64>,
    shadow_bearer: Option<u64>,
    /// The name of the next object that waits to be fetched.
    naming: Option<Naming>,
    counters: ClientCounters,
    of_gone: Blame,
}

/// What is counted with each client.
#[derive(Clone, Copy, Debug, Default)]
struct Blame {
    dropped: u64,
    bad_commands: u64,
}

impl Blame {
    fn and(self, session: &ClientSession) -> Self {
        Self {
            dropped: self.dropped.saturating_add(session.dropped().into()),
            bad_commands: self.bad_commands.saturating_add(session.bad_commands().into()),
        }
    }
}

impl Clients {
    /// Listens as configured.
    ///
    /// # Errors
    /// [`ListenError`], also where other computers could connect and `allow_remote` is not set.
    pub fn listen(config: ClientsConfig, about: About) -> Result<Self, ListenError> {
        if config.listen.is_remote() && !config.allow_remote {
            return Err(ListenError::Remote { listen: config.listen });
        }
        let listener = Listener::open(&config.listen)?;
        Ok(Self {
            config,
            about,
            listener,
            resting_until_us: 0,
            roster: Roster::default(),
            known: Known::default(),
            commands: VecDeque::new(),
            least: Least::default(),
            strangers: 0,
            load: None,
            bearer: None,
            shadow_bearer: None,
            naming: None,
            counters: ClientCounters::default(),
            of_gone: Blame::default(),
        })
    }

    /// Where it really listens: with the port that the system chose for port 0.
    ///
    /// # Errors
    /// What the system states.
    pub fn place(&self) -> io::Result<Listen> {
        self.listener.as_ref().map_or(Ok(Listen::Off), Listener::place)
    }

    /// What people should know of how it listens; `None` where nobody but programs of this computer can connect.
    #[must_use]
    pub fn warning(&self) -> Option<&'static str> {
        self.config.listen.is_remote().then_some(REMOTE_WARNING)
    }

    /// Clients connected, subscribed or not.
    #[must_use]
    pub fn count(&self) -> usize {
        self.roster.clients.len()
    }

    /// Clients that have a session.
    #[must_use]
    pub fn subscribed(&self) -> usize {
        self.roster.clients.iter().filter(|client| client.session.is_subscribed()).count()
    }

    /// Whether somebody wants samples.
    #[must_use]
    pub fn wants_samples(&self) -> bool {
        !self.roster.batches.is_empty()
    }

    /// Connections since the last call that were refused because they did not begin with SUBSCRIBE.
    pub const fn take_strangers(&mut self) -> u32 {
        core::mem::replace(&mut self.strangers, 0)
    }

    /// The next command of a client, oldest first. They are checked: only where commands are allowed, forces not negative.
    pub fn next_command(&mut self) -> Option<ClientCommand> {
        self.commands.pop_front().map(|(_, command)| command)
    }

    /// The model that a client wants in force or as a shadow, if one does; that of the configuration, or no shadow, once the client that
    /// brought another has gone. [`Clients::loaded`] answers it.
    pub fn next_load(&mut self) -> Option<Loading> {
        let gone = |id: &mut u64| self.roster.clients.iter().all(|client| client.id != *id);
        self.load.take().or_else(|| {
            let (kind, client) = match self.bearer.take_if(gone) {
                Some(client) => (Kind::LOAD, client),
                None => (Kind::SHADOW, self.shadow_bearer.take_if(gone)?),
            };
            Some(Loading { kind, client, ack: None, model: None })
        })
    }

    /// Answers [`Clients::next_load`], unless the client has gone: whether a model of its own is in force now, or why nothing has changed.
    pub fn loaded(&mut self, load: &Loading, outcome: Result<bool, NackReason>) {
        match outcome {
            Ok(own) if load.is_shadow() => self.shadow_bearer = own.then_some(load.client),
            Ok(own) => self.bearer = own.then_some(load.client),
            // The last one stays.
            Err(_) if load.is_shadow() => {}
            // A slip goes on: asked for again. What fails otherwise fails again.
            Err(NackReason::WrongState) => self.bearer = self.bearer.or(Some(load.client)),
            Err(_) => {}
        }
        let client = self.roster.clients.iter_mut().find(|client| client.id == load.client);
        let Some(Client { session, .. }) = client else { return };
        match outcome {
            Ok(_) => session.accept(load.ack, load.kind),
            Err(reason) => session.decline(load.ack, load.kind, reason),
        }
    }

    /// What two models made of the last slip, for those who subscribed to it; its number and `host_us` are filled in.
    pub fn estimates(&mut self, host_us: u64, estimates: &Estimates) {
        self.known.estimates(host_us, estimates, &mut self.roster);
    }

    /// The name of the next object that a client has given, if one has; [`Clients::named`] answers it.
    pub fn next_name(&mut self) -> Option<Naming> {
        self.naming.take()
    }

    /// Answers [`Clients::next_name`], unless the client has gone.
    pub fn named(&mut self, naming: &Naming, outcome: Result<(), NackReason>) {
        let client = self.roster.clients.iter_mut().find(|client| client.id == naming.client);
        let Some(Client { session, .. }) = client else { return };
        match outcome {
            Ok(()) => session.accept(naming.ack, Kind::OBJECT),
            Err(reason) => session.decline(naming.ack, Kind::OBJECT, reason),
        }
    }

    /// What is known of the object in hand or next, for those who subscribed to it, and for QUERY; `grasps` have shown it.
    pub fn object(&mut self, host_us: u64, text: &str, grasps: u32) {
        self.known.object(host_us, text, grasps, &mut self.roster);
    }

    /// What SETUP states from now on.
    pub fn set_setup(&mut self, setup: Setup) {
        self.known.set_setup(setup, &mut self.roster);
    }

    /// What happened so far.
    #[must_use]
    pub fn counters(&self) -> ClientCounters {
        let here = self.roster.clients.iter();
        let Blame { dropped, bad_commands } =
            here.fold(self.of_gone, |sum, client| sum.and(&client.session));
        ClientCounters { dropped, bad_commands, ..self.counters }
    }

    /// WELCOME reports it from now on; clients that are here already are not informed.
    pub fn set_about(&mut self, about: About) {
        self.about = About { run_id: self.about.run_id, ..about };
    }

    /// Sends it to those who subscribed to it.
    pub fn take(&mut self, item: &Item<'_>) {
        match *item {
            Item::Sample { host_us, index, sample, taxels } => {
                self.roster.row(&Row { host_us, index, sample, taxels });
            }
            Item::State(state) => self.known.state(state, &mut self.roster),
            Item::Event { host_us, event } => self.known.event(host_us, event, &mut self.roster),
            Item::Began { host_us, beginning } => {
                self.roster.begin();
                self.known.began(host_us, beginning, &mut self.roster);
            }
            Item::Client { host_us, command } => {
                Known::client(host_us, command, &mut self.roster);
            }
            Item::Link { host_us, note } => self.known.link(host_us, note, &mut self.roster),
            Item::Evidence { .. } | Item::Command { .. } | Item::Wire { .. } => {}
        }
    }

    /// Figures of the daemon, for those who want to receive them and for QUERY; call it every second. What is known here (clients, frames
    /// dropped for them, state of the link, slips) is filled in.
    pub fn health(&mut self, health: &Health) {
        let clients = u16::try_from(self.count()).unwrap_or(u16::MAX);
        let dropped = u32::try_from(self.counters().dropped).unwrap_or(u32::MAX);
        self.known.health(health, clients, dropped, &mut self.roster);
    }

    /// Waits for the sockets at most so long, then reads, answers and writes as far as that goes without waiting.
    ///
    /// # Errors
    /// What the system states to `poll`; trouble with a client is never one.
    pub fn poll(&mut self, now_us: u64, timeout: Duration) -> io::Result<()> {
        self.tick(now_us);
        self.write(now_us);
        let (accept, readable) = self.ready(now_us, timeout)?;
        if accept {
            self.accept(now_us);
        }
        for at in readable {
            self.read(at, now_us);
        }
        self.write(now_us);
        self.sweep();
        Ok(())
    }

    /// Takes leave of everybody, as far as that goes without waiting, and listens no more.
    pub fn close(&mut self, now_us: u64) {
        for client in &mut self.roster.clients {
            client.session.part(now_us, Goodbye::Ending);
            client.write(now_us);
        }
        self.roster.clients.clear();
        self.roster.batches.clear();
        self.listener = None;
    }

    fn tick(&mut self, now_us: u64) {
        pass_least(&mut self.least, &mut self.commands, now_us);
        self.roster.flush_old(now_us);
        for client in &mut self.roster.clients {
            client.session.tick(now_us, self.config.stall_us);
        }
    }

    fn write(&mut self, now_us: u64) {
        for client in &mut self.roster.clients {
            client.write(now_us);
        }
    }

    /// Whether somebody wants to connect, and which clients have sent something or are gone.
    fn ready(&self, now_us: u64, timeout: Duration) -> io::Result<(bool, Vec<usize>)> {
        let clients = self.roster.clients.len();
        let mut fds = Vec::with_capacity(clients + 1);
        for client in &self.roster.clients {
            let waits = !client.session.outgoing().is_empty();
            let also = if waits { PollFlags::OUT } else { PollFlags::empty() };
            fds.push(PollFd::from_borrowed_fd(client.stream.fd(), PollFlags::IN | also));
        }
        let listener = self.listener.as_ref().filter(|_| now_us >= self.resting_until_us);
        fds.extend(listener.map(|listener| PollFd::from_borrowed_fd(listener.fd(), PollFlags::IN)));
        let limit = Timespec {
            tv_sec: i64::try_from(timeout.as_secs()).unwrap_or(i64::MAX),
            tv_nsec: timeout.subsec_nanos().into(),
        };
        match poll(&mut fds, Some(&limit)) {
            Ok(_) | Err(Errno::INTR) => {}
            Err(error) => return Err(error.into()),
        }
        let of_clients = fds.get(..clients).unwrap_or_default();
        let input = PollFlags::IN | PollFlags::HUP | PollFlags::ERR | PollFlags::NVAL;
        let spoke = |fd: &PollFd<'_>| fd.revents().intersects(input);
        let readable =
            of_clients.iter().enumerate().filter(|(_, fd)| spoke(fd)).map(|(at, _)| at).collect();
        Ok((fds.get(clients).is_some_and(spoke), readable))
    }

    fn accept(&mut self, now_us: u64) {
        for _ in 0..MOST_ACCEPTED {
            let Some(listener) = &self.listener else { return };
            match listener.accept() {
                Ok(stream) => self.admit(stream, now_us),
                Err(error) if error.kind() == io::ErrorKind::WouldBlock => return,
                Err(error) if error.kind() == io::ErrorKind::ConnectionAborted => {}
                Err(_) => {
                    self.counters.accept_errors = self.counters.accept_errors.saturating_add(1);
                    self.resting_until_us = now_us.saturating_add(REST_US);
                    return;
                }
            }
        }
    }

    fn admit(&mut self, stream: Stream, now_us: u64) {
        let session = ClientSession::new(now_us, self.config.buffer_bytes);
        let id = self.counters.accepted;
        let mut client = Client { stream, session, gone: false, id };
        if self.count() < self.config.most {
            self.counters.accepted = self.counters.accepted.saturating_add(1);
            self.roster.clients.push(client);
        } else {
            self.counters.refused = self.counters.refused.saturating_add(1);
            client.session.part(now_us, Goodbye::Full);
            client.write(now_us);
        }
    }

    fn read(&mut self, at: usize, now_us: u64) {
        let Some(client) = self.roster.clients.get_mut(at) else { return };
        let mut bytes = [0; MOST_READ];
        let count = match client.stream.read(&mut bytes) {
            Ok(0) => {
                client.gone = true;
                return;
            }
            Ok(count) => count,
            Err(error) if error.kind() == io::ErrorKind::WouldBlock => return,
            Err(error) if error.kind() == io::ErrorKind::Interrupted => return,
            Err(_) => {
                client.gone = true;
                return;
            }
        };
        let own = self.commands.iter().filter(|(id, _)| *id == Some(client.id)).count();
        let room = MOST_COMMANDS.saturating_sub(self.commands.len());
        let terms = Terms {
            welcome: self.about.welcome(&self.config),
            allow_commands: self.config.allow_commands,
            allow_models: self.config.allow_models,
            token: self.about.token(),
            room: room.min(MOST_OF_ONE.saturating_sub(own)),
            immovable: self.known.immovable(),
            force_max_n: self.known.force_max_n(),
        };
        let mut asked = Vec::new();
        let bytes = bytes.get(..count).unwrap_or_default();
        client.session.receive(now_us, bytes, &terms, &mut |request| asked.push(request));
        let mut subscribed = false;
        for request in asked {
            match request {
                Asked::Subscribed => subscribed = true,
                Asked::Query { ack } => self.known.answer(&mut client.session, ack),
                Asked::Command(command) => {
                    self.counters.commands = self.counters.commands.saturating_add(1);
                    match command {
                        ClientCommand::AtLeast(force_n) => self.least.ask(client.id, force_n),
                        // Behind what it must undo; one that is the newest already says it all.
                        ClientCommand::Stop
                            if matches!(self.commands.back(), Some((_, ClientCommand::Stop))) => {}
                        command => {
                            if command == ClientCommand::Release {
                                self.least.let_go();
                            }
                            self.commands.push_back((Some(client.id), command));
                        }
                    }
                    pass_least(&mut self.least, &mut self.commands, now_us);
                }
                Asked::Object { ack, .. } if self.naming.is_some() => {
                    client.session.decline(ack, Kind::OBJECT, NackReason::Busy);
                }
                Asked::Object { ack, name } => {
                    self.naming = Some(Naming { client: client.id, ack, name });
                }
                Asked::Load { kind: Kind::SHADOW, ack, model }
                    if self.shadow_bearer.is_some_and(|bearer| bearer != client.id) =>
                {
                    match model {
                        Some(_) => client.session.decline(ack, Kind::SHADOW, NackReason::Busy),
                        None => client.session.accept(ack, Kind::SHADOW),
                    }
                }
                Asked::Load { kind, ack, .. } if self.load.is_some() => {
                    client.session.decline(ack, kind, NackReason::Busy);
                }
                Asked::Load { kind, ack, model } => {
                    self.load = Some(Loading { kind, client: client.id, ack, model });
                }
            }
        }
        if subscribed {
            self.roster.regroup();
        }
    }

    /// Closes the connections that have ended.
    fn sweep(&mut self) {
        let before = self.roster.clients.len();
        let (mut sent_away, mut of_gone) = (0_u64, self.of_gone);
        let Self { least, strangers, .. } = self;
        self.roster.clients.retain(|client| {
            let ends = client.session.goodbye().is_some();
            sent_away += u64::from(ends);
            if client.gone || ends {
                of_gone = of_gone.and(&client.session);
                least.leave(client.id);
                let stranger = client.session.is_stranger();
                *strangers = strangers.saturating_add(u32::from(stranger));
            }
            !client.gone && !ends
        });
        self.counters.sent_away = self.counters.sent_away.saturating_add(sent_away);
        self.of_gone = of_gone;
        if self.roster.clients.len() < before {
            self.roster.regroup();
        }
    }
}

/// The least force that stands, once its turn has come. It was answered before, and has room beyond that of the others.
fn pass_least(
    least: &mut Least,
    commands: &mut VecDeque<(Option<u64>, ClientCommand)>,
    now_us: u64,
) {
    if commands.len() <= MOST_COMMANDS {
        commands.extend(least.due(now_us).map(|force_n| (None, ClientCommand::AtLeast(force_n))));
    }
}
