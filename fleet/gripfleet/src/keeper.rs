//! Bytes of gripd in; events kept, and what is to be published on its way to the network. It waits for nothing but gripd and the disk.

use crate::{
    clock::{Clock, utc_ns},
    common::{Answered, Common, Order, Outgoing},
    curator::{Desk, Wanted},
};
use core::{mem, sync::atomic::Ordering};
use grip_daemon::{clients::Stream, log::LogLevel};
use grip_fleet::{
    About, Bridge, Greeting, Incoming, Part, Publication, Setup, Spool, Stamp, StoreError, Uid,
    WallTime, deploy::Examined, rollout::GraspLog,
};
use grip_link::message::NackReason;
use grip_session::{config::FleetConfig, exit::message, model::digest};
use std::{
    collections::VecDeque,
    io::{self, Read as _, Write as _},
    sync::mpsc::{Receiver, Sender, SyncSender},
};

/// What lies between an event in gripd and the clock that is read here: gripd serves its clients, and this thread its commands and models (us).
const READ_US: u32 = 50_000;
/// Bytes read at once.
const CHUNK: usize = 16 * 1024;

/// What leads to the other threads.
pub(super) struct KeeperEnds {
    pub(super) common: Common,
    /// What is to be published.
    pub(super) sender: SyncSender<Outgoing>,
    /// Commands from the network, and what became of them.
    pub(super) orders: Receiver<Order>,
    pub(super) answer: Sender<Answered>,
    /// What leads to the models.
    pub(super) desk: Desk,
    pub(super) clock: Clock,
}

pub(super) struct Keeper {
    bridge: Bridge,
    config: FleetConfig,
    run: u32,
    ends: KeeperEnds,
    /// Commands that gripd has not answered yet: their numbers here and on the network.
    open: VecDeque<(u16, u64)>,
    grasps: GraspLog,
    /// The wall clock at the start of gripd, and at the slip that is published next (ns since 1970).
    start_ns: u64,
    slipped_ns: Option<u64>,
    /// A model on its way: the number of its answer.
    loading: Option<(u16, Wanted)>,
    /// The last model that came over the network.
    loaded: Option<Examined>,
    greeting: Option<Greeting>,
    /// Events cannot be put on disk now.
    troubled: bool,
    /// Another daemon keeps the events of this gripper.
    locked: bool,
}

impl Keeper {
    pub(super) fn new(bridge: Bridge, config: FleetConfig, run: u32, ends: KeeperEnds) -> Self {
        Self {
            bridge,
            config,
            run,
            ends,
            open: VecDeque::new(),
            grasps: GraspLog::default(),
            start_ns: 0,
            slipped_ns: None,
            loading: None,
            loaded: None,
            greeting: None,
            troubled: false,
            locked: false,
        }
    }

    /// Runs until gripd closes the connection, or the program ends.
    pub(super) fn run(mut self, mut stream: Stream) {
        let mut bytes = [0; CHUNK];
        while !self.ends.common.has_ended() {
            match stream.read(&mut bytes) {
                Ok(0) => break,
                Ok(count) => self.receive(bytes.get(..count).unwrap_or_default()),
                Err(error) if is_pause(&error) => {}
                Err(error) => {
                    self.ends
                        .common
                        .report(LogLevel::Error, format!("cannot listen to gripd: {error}"));
                    break;
                }
            }
            if let Err(error) = self.order(&mut stream).and_then(|()| self.load(&mut stream)) {
                self.ends.common.report(
                    LogLevel::Error,
                    format!("cannot hand commands and models to gripd: {error}"),
                );
                break;
            }
        }
        self.ends.common.end();
    }

    /// Hands commands on, as any other client would.
    fn order(&mut self, stream: &mut Stream) -> io::Result<()> {
        while let Ok((number, command)) = self.ends.orders.try_recv() {
            let (seq, wire) = self.bridge.command(&command);
            self.open.push_back((seq, number));
            stream.write_all(&wire)?;
        }
        Ok(())
    }

    /// Hands the next model on, when the last one was answered.
    fn load(&mut self, stream: &mut Stream) -> io::Result<()> {
        if self.loading.is_some() {
            return Ok(());
        }
        let Ok(wanted) = self.ends.desk.wanted.try_recv() else { return Ok(()) };
        let text = wanted.model.as_ref().map(|model| model.text.as_bytes());
        let sha256 = text.map(digest);
        let file = sha256.as_ref().zip(text);
        let (seq, wire) =
            if wanted.beside { self.bridge.shadow(file) } else { self.bridge.load(file) };
        self.loading = Some((seq, wanted));
        stream.write_all(&wire)
    }

    /// gripd answers in the order in which it is asked, but for models; what it had no room to answer is passed over.
    fn answer(&mut self, seq: u16, answer: Result<(), NackReason>) {
        if let Some((_, wanted)) = self.loading.take_if(|(asked, _)| *asked == seq) {
            let begun = match answer {
                Ok(()) if wanted.beside => Ok(self.grasps.cast()),
                Ok(()) => {
                    self.loaded = wanted.model;
                    Ok(self.grasps.swapped())
                }
                Err(reason) => Err(format!("gripd has refused it: {reason}")),
            };
            // A thread that is gone waits for nothing.
            let _gone = self.ends.desk.swapped.send(begun);
            return;
        }
        while let Some((asked, number)) = self.open.pop_front() {
            if asked == seq {
                // Whoever asked may have gone.
                let _gone = self.ends.answer.send((number, answer));
                break;
            }
        }
    }

    fn receive(&mut self, bytes: &[u8]) {
        for received in self.bridge.receive(bytes) {
            match received {
                Incoming::Publication(publication) => self.keep(publication),
                Incoming::Missed(count) => self.miss(count),
                Incoming::Answer(seq, answer) => self.answer(seq, answer),
                Incoming::Welcome(greeting) => {
                    let since_ns = greeting.host_us.saturating_mul(1000);
                    let mut kept = self.ends.common.kept();
                    kept.start_ns = self.ends.clock.wall_ns().saturating_sub(since_ns);
                    self.start_ns = utc_ns().saturating_sub(since_ns);
                    kept.token = greeting.token;
                    drop(kept);
                    self.greeting = Some(greeting);
                }
                Incoming::Setup(setup) => self.meet(setup),
                Incoming::State(state) => {
                    self.began_by(state.host.0);
                    self.start_ns = utc_ns().saturating_sub(1000 * state.host.0);
                    self.ends.desk.fault.store(state.fault.0, Ordering::Relaxed);
                    self.ends.common.kept().fault = state.fault.0;
                    if let Some(finished) = self.grasps.state(&state) {
                        // A thread that is gone counts nothing.
                        let _gone = self.ends.desk.grasped.send(finished);
                    }
                }
                Incoming::Slip(slip) => {
                    // One that comes after an outage was earlier.
                    self.began_by(slip.host.0);
                    self.slipped_ns = Some(self.start_ns + 1000 * slip.host.0);
                    self.grasps.slip(&slip);
                }
                Incoming::Estimates(made) => self.grasps.estimates(&made),
                Incoming::Goodbye(text) => {
                    self.ends.common.report(LogLevel::Warn, format!("gripd says goodbye: {text}"));
                }
            }
        }
        self.ends.common.kept().received = self.bridge.last_received();
    }

    /// Nothing arrives before it was sent at `host_us` (us): the start of gripd is no later than that states. A greeting may have been read late.
    fn began_by(&self, host_us: u64) {
        let start_ns = self.ends.clock.wall_ns().saturating_sub(host_us.saturating_mul(1000));
        let mut kept = self.ends.common.kept();
        kept.start_ns = kept.start_ns.min(start_ns);
    }

    /// What the gripper is made of, for those who ask.
    fn meet(&mut self, setup: Setup) {
        let Some(greeting) = &self.greeting else { return };
        let coming = self.loading.as_ref().and_then(|(_, wanted)| wanted.model.as_ref());
        let ours = coming.into_iter().chain(&self.loaded);
        let ours = ours.map(|model| &model.id).find(|id| id.sha256 == setup.in_force);
        let model = if setup.in_force == setup.configured.sha256 {
            setup.configured.name.clone()
        } else {
            let name = ours.map_or(setup.in_force.get(..12), |id| Some(id.name.as_str()));
            format!("{} of the fleet", name.unwrap_or_default())
        };
        let about = About {
            program: greeting.program.clone(),
            firmware: setup.firmware.clone(),
            model: Some(model),
        };
        // What cannot be written, which no value makes, is left out.
        self.ends.common.kept().about = serde_json::to_string(&about).unwrap_or_default();
        let _gone = self.ends.desk.setups.send((setup, greeting.takes_models));
    }

    /// First kept, then published: what is published can be asked for again.
    fn keep(&mut self, Publication { topic, wire }: Publication) {
        let Some(uid) = self.bridge.uid() else { return };
        if self.ends.common.kept().gripper.is_none() {
            // Whether the other one has ended is looked up once a second.
            if self.locked && topic != Part::Health {
                return;
            }
            match self.open(uid) {
                Some(spool) => self.ends.common.kept().gripper = Some((uid, spool)),
                None => return,
            }
        }
        let mut kept = self.ends.common.kept();
        if topic != Part::Samples {
            kept.status = self.bridge.status().map(<[u8]>::to_vec).collect();
        }
        let Some((_, spool)) = &mut kept.gripper else { return };
        let stamp = match topic {
            Part::Events => {
                let ns = self.slipped_ns.take().unwrap_or_else(utc_ns);
                let at = WallTime { ns, error_us: READ_US };
                Stamp { id: spool.append_at(wire.clone(), at), at }
            }
            Part::State | Part::Health => {
                let at = WallTime { ns: utc_ns(), error_us: READ_US };
                Stamp { id: spool.log().head(), at }
            }
            // They are of a while.
            _ => spool.log().head().into(),
        };
        let trouble = spool.trouble();
        drop(kept);
        if topic == Part::Events {
            self.disk(trouble);
        }
        // What finds no room is asked for again, or out of date soon.
        let _full = self.ends.sender.try_send((topic, stamp, wire));
    }

    /// gripd had no room for events: whoever asks learns that they are missing.
    fn miss(&self, count: u32) {
        if let Some((_, spool)) = &mut self.ends.common.kept().gripper {
            spool.skip(count.into());
        }
        self.ends
            .common
            .report(LogLevel::Warn, format!("{count} events are lost: gripd no longer had them"));
    }

    /// Reports when the disk begins to refuse events, and when it takes them again.
    fn disk(&mut self, trouble: Option<StoreError>) {
        let was = mem::replace(&mut self.troubled, trouble.is_some());
        match trouble {
            Some(trouble) if !was => {
                self.ends.common.report(
                    LogLevel::Warn,
                    format!("events are kept in memory only: {}", message(&trouble)),
                );
            }
            None if was => self.ends.common.report(LogLevel::Info, "events are kept on disk again"),
            _ => {}
        }
    }

    /// Where events are kept; in memory where the folder cannot be used, and nowhere where somebody else does it.
    fn open(&mut self, uid: Uid) -> Option<Spool> {
        let room = usize::from(self.config.spool_mib) << 20;
        let memory = || Spool::in_memory(self.run, room);
        let Some(folder) = &self.config.spool else { return Some(memory()) };
        match Spool::open(folder, uid, self.run, room) {
            Ok(spool) => Some(spool),
            Err(error @ StoreError::Locked { .. }) => {
                if !mem::replace(&mut self.locked, true) {
                    self.ends.common.report(
                        LogLevel::Error,
                        format!(
                            "this gripper is not published until that one ends: {}",
                            message(&error)
                        ),
                    );
                }
                None
            }
            Err(error) => {
                self.ends.common.report(
                    LogLevel::Error,
                    format!("events are kept in memory only: {}", message(&error)),
                );
                Some(memory())
            }
        }
    }
}

fn is_pause(error: &io::Error) -> bool {
    let kinds = [io::ErrorKind::WouldBlock, io::ErrorKind::TimedOut, io::ErrorKind::Interrupted];
    kinds.contains(&error.kind())
}
