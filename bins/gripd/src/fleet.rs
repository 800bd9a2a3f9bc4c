//! What every client of the daemon hears in, publications on a network of many grippers out: a thread of its own, which the service
//! thread serves as it serves any client. Nothing here reaches the hot thread, and a network that is gone stops nothing.

use crate::{clock::Clock, settings::Settings};
use anyhow::Context as _;
use core::{
    sync::atomic::{AtomicBool, Ordering},
    time::Duration,
};
use grip_daemon::{clients::Clients, log::LogLevel};
use grip_fleet::{
    Bridge, EventId, Member, Publication, Site, Spool, Topic, Uid,
    net::{Announced, NetError, Network, Session},
};
use grip_host::{config::FleetConfig, exit::message};
use std::{
    io::{self, Read as _, Write as _},
    os::unix::net::UnixStream,
    sync::{
        Arc,
        mpsc::{self, Receiver, Sender},
    },
    thread::{self, JoinHandle},
};

/// Pause between two looks at what was asked.
const PAUSE: Duration = Duration::from_millis(10);
/// Pause between two attempts to find the router.
const RETRY: Duration = Duration::from_secs(2);
/// Bytes read at once.
const CHUNK: usize = 16 * 1024;

/// A sentence for the console.
pub(crate) type Told = (LogLevel, String);

/// The thread, as seen from outside.
#[derive(Debug)]
pub(crate) struct Fleet {
    thread: JoinHandle<()>,
    /// What it has to say.
    told: Receiver<Told>,
}

impl Fleet {
    /// Begins to publish where the settings ask for it; there are clients then, if only this one.
    pub(crate) fn start(
        settings: &Settings,
        clients: Option<Clients>,
        clock: Clock,
    ) -> anyhow::Result<(Option<Clients>, Option<Self>)> {
        let config = &settings.config.fleet;
        let Some(site) = config.site.clone() else { return Ok((clients, None)) };
        let mut clients = clients.context("nothing can be told to the fleet without clients")?;
        let bridge = Bridge::new(1);
        let mut stream = clients.connect_inside(clock.now_us())?;
        stream.set_read_timeout(Some(PAUSE))?;
        // Before anything happens, so that nothing is missed.
        stream.write_all(&bridge.subscribe(config.samples_every))?;
        let (say, told) = mpsc::channel();
        let stopped = Arc::new(AtomicBool::new(false));
        let gateway = Gateway {
            bridge,
            site,
            config: config.clone(),
            shown: toml::to_string(&settings.config)
                .context("the configuration cannot be written")?,
            run: clock.run_id(),
            spool: None,
            session: open(network(config), say.clone(), Arc::clone(&stopped))?,
            announced: None,
            say,
        };
        let thread = thread::Builder::new().name("fleet".to_owned()).spawn(move || {
            gateway.run(stream);
            stopped.store(true, Ordering::Relaxed);
        })?;
        Ok((Some(clients), Some(Self { thread, told })))
    }

    /// What it has said meanwhile.
    pub(crate) fn told(&self) -> impl Iterator<Item = Told> {
        self.told.try_iter()
    }

    /// Waits for its end, which comes when the service thread has said goodbye to its clients; whether it was a good one.
    pub(crate) fn finish(self) -> bool {
        self.thread.join().is_ok()
    }
}

/// The network that the configuration names.
pub(crate) fn network(config: &FleetConfig) -> Network {
    Network { router: config.router.clone(), file: config.network.clone() }
}

/// Looks for the router until it answers; from then on the session does that by itself.
fn open(
    network: Network,
    say: Sender<Told>,
    stopped: Arc<AtomicBool>,
) -> io::Result<Receiver<Session>> {
    let (found, session) = mpsc::channel();
    thread::Builder::new().name("fleet-open".to_owned()).spawn(move || {
        let mut said = false;
        while !stopped.load(Ordering::Relaxed) {
            match network.open() {
                Ok(session) => {
                    // A gateway that has ended needs none.
                    let _ended = found.send(session);
                    return;
                }
                Err(error) if !core::mem::replace(&mut said, true) => {
                    let text =
                        format!("fleet: {}; events are kept and told later", message(&error));
                    let _ended = say.send((LogLevel::Warn, text));
                }
                Err(_) => {}
            }
            pause(RETRY);
        }
    })?;
    Ok(session)
}

#[expect(clippy::disallowed_methods, reason = "the driver may wait; nobody waits for this thread")]
fn pause(time: Duration) {
    thread::sleep(time);
}

/// What the thread works with.
struct Gateway {
    bridge: Bridge,
    site: Site,
    config: FleetConfig,
    /// The configuration in force, as text.
    shown: String,
    run: u32,
    /// The events, as soon as the gripper has a name.
    spool: Option<Spool>,
    session: Receiver<Session>,
    /// The session lives as long as what was announced in it.
    announced: Option<(Announced, Session)>,
    say: Sender<Told>,
}

impl Gateway {
    /// Runs until the daemon closes the connection.
    fn run(mut self, mut stream: UnixStream) {
        let mut bytes = [0; CHUNK];
        loop {
            match stream.read(&mut bytes) {
                Ok(0) => break,
                Ok(count) => self.receive(bytes.get(..count).unwrap_or_default()),
                Err(error) if is_pause(&error) => {}
                Err(error) => {
                    self.tell(LogLevel::Error, &format!("cannot listen to the daemon: {error}"));
                    break;
                }
            }
            self.announce();
            self.answer();
        }
    }

    fn receive(&mut self, bytes: &[u8]) {
        let mut publications = Vec::new();
        self.bridge.receive(bytes, &mut |publication| publications.push(publication));
        for publication in publications {
            self.publish(publication);
        }
    }

    fn publish(&mut self, Publication { topic, wire }: Publication) {
        let Some(uid) = self.bridge.uid() else { return };
        if self.spool.is_none() {
            self.spool = Some(self.keep(uid));
        }
        let Some(spool) = &mut self.spool else { return };
        // First kept, then told: what is told can be asked for again.
        let id: EventId = match topic {
            Topic::Events => spool.append(wire.clone()),
            Topic::State | Topic::Health | Topic::Samples => spool.log().head(),
        };
        let trouble = spool.trouble();
        if let Some((announced, _)) = &mut self.announced {
            announced.publish(topic, id, &wire);
        }
        if let Some(trouble) = trouble {
            let text = format!("events are kept in memory only: {}", message(&trouble));
            self.tell(LogLevel::Warn, &text);
        }
    }

    /// Where events are kept; in memory where the folder cannot be used.
    fn keep(&self, uid: Uid) -> Spool {
        let room = usize::from(self.config.spool_mib) << 20;
        let memory = || Spool::in_memory(self.run, room);
        let Some(folder) = &self.config.spool else { return memory() };
        Spool::open(folder, uid, self.run, room).unwrap_or_else(|error| {
            let text = format!("events are kept in memory only: {}", message(&error));
            self.tell(LogLevel::Error, &text);
            memory()
        })
    }

    /// Puts the gripper on the network, as soon as there are both.
    fn announce(&mut self) {
        let (None, Some(_), Some(uid)) = (&self.announced, &self.spool, self.bridge.uid()) else {
            return;
        };
        let Ok(session) = self.session.try_recv() else { return };
        let member = Member { site: self.site.clone(), uid };
        match Announced::new(&session, &member) {
            Ok(announced) => {
                self.tell(LogLevel::Info, &format!("this gripper is there as {member}"));
                self.announced = Some((announced, session));
            }
            Err(error) => self.tell(LogLevel::Error, &refusal(&error)),
        }
    }

    fn answer(&mut self) {
        if let (Some((announced, _)), Some(spool)) = (&mut self.announced, &self.spool) {
            let status: Vec<&[u8]> = self.bridge.status().collect();
            announced.answer(spool.log(), &status, &self.shown);
        }
    }

    fn tell(&self, level: LogLevel, text: &str) {
        // A console that is gone reads nothing.
        let _gone = self.say.send((level, format!("fleet: {text}")));
    }
}

fn refusal(error: &NetError) -> String {
    format!("this gripper is told to nobody: {}", message(error))
}

fn is_pause(error: &io::Error) -> bool {
    let kinds = [io::ErrorKind::WouldBlock, io::ErrorKind::TimedOut, io::ErrorKind::Interrupted];
    kinds.contains(&error.kind())
}
