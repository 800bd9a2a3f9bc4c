//! Bytes of the daemon in; events kept, and what is to be published on its way to the network. It waits for nothing but the daemon and the disk.

use super::{Answered, Common, Order, Outgoing};
use core::{mem, sync::atomic::Ordering};
use grip_daemon::log::LogLevel;
use grip_fleet::{Bridge, Heard, Publication, Spool, SpoolError, Topic, Uid};
use grip_link::message::NackReason;
use grip_session::{config::FleetConfig, exit::message};
use std::{
    collections::VecDeque,
    io::{self, Read as _, Write as _},
    os::unix::net::UnixStream,
    sync::mpsc::{Receiver, Sender, SyncSender},
};

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
}

pub(super) struct Keeper {
    bridge: Bridge,
    config: FleetConfig,
    run: u32,
    common: Common,
    sender: SyncSender<Outgoing>,
    orders: Receiver<Order>,
    answer: Sender<Answered>,
    /// Commands that the daemon has not answered yet: their numbers here and on the network.
    open: VecDeque<(u16, u64)>,
    /// Events cannot be put on disk now.
    troubled: bool,
    /// Another daemon keeps the events of this gripper.
    locked: bool,
}

impl Keeper {
    pub(super) fn new(bridge: Bridge, config: FleetConfig, run: u32, ends: KeeperEnds) -> Self {
        let KeeperEnds { common, sender, orders, answer } = ends;
        let open = VecDeque::new();
        Self {
            bridge,
            config,
            run,
            common,
            sender,
            orders,
            answer,
            open,
            troubled: false,
            locked: false,
        }
    }

    /// Runs until the daemon closes the connection.
    pub(super) fn run(mut self, mut stream: UnixStream) {
        let mut bytes = [0; CHUNK];
        loop {
            match stream.read(&mut bytes) {
                Ok(0) => break,
                Ok(count) => self.receive(bytes.get(..count).unwrap_or_default()),
                Err(error) if is_pause(&error) => {}
                Err(error) => {
                    let text = format!("cannot listen to the daemon: {error}");
                    self.common.tell(LogLevel::Error, &text);
                    break;
                }
            }
            if let Err(error) = self.order(&mut stream) {
                let text = format!("cannot hand commands to the daemon: {error}");
                self.common.tell(LogLevel::Error, &text);
                break;
            }
        }
        self.common.ended.store(true, Ordering::Relaxed);
    }

    /// Hands commands on, as any other client would.
    fn order(&mut self, stream: &mut UnixStream) -> io::Result<()> {
        while let Ok((number, command)) = self.orders.try_recv() {
            let (seq, wire) = self.bridge.command(&command);
            self.open.push_back((seq, number));
            stream.write_all(&wire)?;
        }
        Ok(())
    }

    /// The daemon answers in the order in which it is asked; what it had no room to answer is passed over.
    fn answer(&mut self, seq: u16, answer: Result<(), NackReason>) {
        while let Some((asked, number)) = self.open.pop_front() {
            if asked == seq {
                // Whoever asked may have gone.
                let _gone = self.answer.send((number, answer));
                break;
            }
        }
    }

    fn receive(&mut self, bytes: &[u8]) {
        let mut all = Vec::new();
        self.bridge.receive(bytes, &mut |heard| all.push(heard));
        for heard in all {
            match heard {
                Heard::Publication(publication) => self.keep(publication),
                Heard::Missed(count) => self.miss(count),
                Heard::Answer(seq, answer) => self.answer(seq, answer),
            }
        }
    }

    /// First kept, then told: what is told can be asked for again.
    fn keep(&mut self, Publication { topic, wire }: Publication) {
        let Some(uid) = self.bridge.uid() else { return };
        if self.common.kept().gripper.is_none() {
            // Whether the other one has ended is looked up once a second.
            if self.locked && topic != Topic::Health {
                return;
            }
            match self.open(uid) {
                Some(spool) => self.common.kept().gripper = Some((uid, spool)),
                None => return,
            }
        }
        let mut kept = self.common.kept();
        if topic != Topic::Samples {
            kept.status = self.bridge.status().map(<[u8]>::to_vec).collect();
        }
        let Some((_, spool)) = &mut kept.gripper else { return };
        let id = match topic {
            Topic::Events => spool.append(wire.clone()),
            Topic::State | Topic::Health | Topic::Samples => spool.log().head(),
        };
        let trouble = spool.trouble();
        drop(kept);
        if topic == Topic::Events {
            self.disk(trouble);
        }
        // What finds no room is asked for again, or out of date soon.
        let _full = self.sender.try_send((topic, id, wire));
    }

    /// The daemon had no room for events: whoever asks learns that they are missing.
    fn miss(&self, count: u32) {
        if let Some((_, spool)) = &mut self.common.kept().gripper {
            spool.skip(count.into());
        }
        let text = format!("{count} events are lost: the disk was too slow for them");
        self.common.tell(LogLevel::Warn, &text);
    }

    /// Tells when the disk begins to refuse events, and when it takes them again.
    fn disk(&mut self, trouble: Option<SpoolError>) {
        let was = mem::replace(&mut self.troubled, trouble.is_some());
        match trouble {
            Some(trouble) if !was => {
                let text = format!("events are kept in memory only: {}", message(&trouble));
                self.common.tell(LogLevel::Warn, &text);
            }
            None if was => self.common.tell(LogLevel::Info, "events are kept on disk again"),
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
            Err(error @ SpoolError::Locked { .. }) => {
                if !mem::replace(&mut self.locked, true) {
                    let text = format!(
                        "this gripper is told to nobody until that one ends: {}",
                        message(&error)
                    );
                    self.common.tell(LogLevel::Error, &text);
                }
                None
            }
            Err(error) => {
                let text = format!("events are kept in memory only: {}", message(&error));
                self.common.tell(LogLevel::Error, &text);
                Some(memory())
            }
        }
    }
}

fn is_pause(error: &io::Error) -> bool {
    let kinds = [io::ErrorKind::WouldBlock, io::ErrorKind::TimedOut, io::ErrorKind::Interrupted];
    kinds.contains(&error.kind())
}
