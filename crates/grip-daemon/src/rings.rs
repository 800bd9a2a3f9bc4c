//! Items in at the hot end, the same items in the same order out at the other: bounded, never waiting; what does not fit is dropped
//! and counted by kind.
//!
//! A ring of small tokens keeps the order; what belongs to a token stands in the ring of its kind, so that a rare large item does not
//! make every place large. Nothing is allocated after [`rings`].

use core::sync::atomic::{AtomicU64, Ordering};
use grip_link::{
    host::{CloseReason, LinkState},
    message::{
        Clamped, Event as DeviceEvent, EventKind, Firmware, Grip, MAX_ELEMENTS, Nack, Status,
    },
};
use grip_session::{
    config::Uid,
    report::Event,
    session::{Beginning, explain},
    shadow::SlipEvidence,
    steady::STEADY,
};
use rtrb::{Consumer, Producer, RingBuffer};
use slip_core::{ClientCommand, PipelineState, Sample};
use std::sync::Arc;

/// How many items of each kind fit.
#[derive(Clone, Copy, Debug)]
pub struct Sizes {
    /// Samples.
    pub samples: usize,
    /// States and commands, one of each a frame.
    pub frames: usize,
    /// Bytes of the line.
    pub wire: usize,
}

impl Sizes {
    /// For a thread that writes files: 1.6 s of samples at 20 kHz.
    pub const RECORDER: Self = Self { samples: 32_768, frames: 4096, wire: 1 << 20 };
    /// For a thread that looks every few milliseconds.
    pub const SERVICE: Self = Self { samples: 8192, frames: 1024, wire: 1 << 16 };
}

/// Room for events, notes of the link and commands of clients.
const RARE: usize = 512;
/// Room for what slips showed: the other end looks every few milliseconds.
const EVIDENCE: usize = 16;
/// Room for beginnings of pipelines.
const BEGINNINGS: usize = 8;
/// Taxels with each sample for which there is room.
const TAXELS: usize = 8;

#[derive(Clone, Copy, Debug)]
enum Token {
    Began,
    Sample,
    State,
    Event,
    Evidence,
    Command,
    Client,
    Link,
    Wire,
}

#[derive(Clone, Copy, Debug)]
struct Taken {
    host_us: u64,
    sample: Sample,
    index: u32,
    taxels: u16,
}

#[derive(Clone, Copy, Debug)]
struct Chunk {
    host_us: u64,
    to_device: bool,
    len: u32,
}

/// Both ends of every ring, under the same names.
macro_rules! ends {
    ($(#[$doc:meta])* $name:ident, $end:ident) => {
        $(#[$doc])*
        #[derive(Debug)]
        pub struct $name {
            tokens: $end<Token>,
            began: $end<(u64, Beginning)>,
            samples: $end<Taken>,
            taxels: $end<f32>,
            states: $end<PipelineState>,
            events: $end<(u64, Event)>,
            evidence: $end<(u64, SlipEvidence)>,
            commands: $end<(u64, Grip)>,
            clients: $end<(u64, ClientCommand)>,
            links: $end<(u64, LinkNote)>,
            chunks: $end<Chunk>,
            bytes: $end<u8>,
            drops: Arc<Drops>,
        }
    };
}

ends!(
    /// Where items go in.
    Outbox,
    Producer
);
ends!(
    /// Where items come out.
    Inbox,
    Consumer
);

/// Items that did not fit, by kind.
#[derive(Debug, Default)]
pub struct Drops {
    samples: AtomicU64,
    states: AtomicU64,
    wire: AtomicU64,
    others: AtomicU64,
}

/// [`Drops`] as of now.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Dropped {
    /// Samples.
    pub samples: u64,
    /// States.
    pub states: u64,
    /// Reads from and writes to the line.
    pub wire: u64,
    /// Events and what slips showed, commands, notes of the link and beginnings of pipelines.
    pub others: u64,
}

impl Dropped {
    /// All of them.
    #[must_use]
    pub fn total(&self) -> u64 {
        self.samples + self.states + self.wire + self.others
    }
}

impl Drops {
    /// The counts as of now.
    #[must_use]
    pub fn now(&self) -> Dropped {
        Dropped {
            samples: self.samples.load(Ordering::Relaxed),
            states: self.states.load(Ordering::Relaxed),
            wire: self.wire.load(Ordering::Relaxed),
            others: self.others.load(Ordering::Relaxed),
        }
    }
}

/// The two ends of a set of rings.
#[must_use]
pub fn rings(sizes: Sizes) -> (Outbox, Inbox) {
    let tokens = RingBuffer::new(sizes.samples + 5 * sizes.frames + 4 * RARE);
    let began = RingBuffer::new(BEGINNINGS);
    let samples = RingBuffer::new(sizes.samples);
    let taxels = RingBuffer::new(TAXELS * sizes.samples);
    let states = RingBuffer::new(sizes.frames);
    let events = RingBuffer::new(RARE);
    let evidence = RingBuffer::new(EVIDENCE);
    let commands = RingBuffer::new(sizes.frames);
    let clients = RingBuffer::new(RARE);
    // The gripper reports its state with every frame.
    let links = RingBuffer::new(RARE + sizes.frames);
    let chunks = RingBuffer::new(2 * sizes.frames);
    let bytes = RingBuffer::new(sizes.wire);
    let drops = Arc::new(Drops::default());
    let outbox = Outbox {
        tokens: tokens.0,
        began: began.0,
        samples: samples.0,
        taxels: taxels.0,
        states: states.0,
        events: events.0,
        evidence: evidence.0,
        commands: commands.0,
        clients: clients.0,
        links: links.0,
        chunks: chunks.0,
        bytes: bytes.0,
        drops: Arc::clone(&drops),
    };
    let inbox = Inbox {
        tokens: tokens.1,
        began: began.1,
        samples: samples.1,
        taxels: taxels.1,
        states: states.1,
        events: events.1,
        evidence: evidence.1,
        commands: commands.1,
        clients: clients.1,
        links: links.1,
        chunks: chunks.1,
        bytes: bytes.1,
        drops,
    };
    (outbox, inbox)
}

/// Copies `values` into a ring where all of them fit.
fn put_all<T: Copy + Default>(ring: &mut Producer<T>, values: &[T]) -> bool {
    let Ok(mut chunk) = ring.write_chunk(values.len()) else { return false };
    let (first, second) = chunk.as_mut_slices();
    // Slice by slice, so that bytes are copied as blocks.
    let Some((head, tail)) = values.split_at_checked(first.len()) else { return false };
    first.copy_from_slice(head);
    second.copy_from_slice(tail);
    chunk.commit_all();
    true
}

impl Outbox {
    /// Puts an item in, or counts it.
    #[inline]
    pub fn put(&mut self, item: &Item<'_>) {
        let (token, fits) =
            if self.tokens.is_full() { (Self::token(item), false) } else { self.put_value(item) };
        // The token last: it shows the other end that the rest is there.
        if fits && self.tokens.push(token).is_ok() {
            return;
        }
        let drops = &self.drops;
        let count = match token {
            Token::Sample => &drops.samples,
            Token::State => &drops.states,
            Token::Wire => &drops.wire,
            _ => &drops.others,
        };
        count.fetch_add(1, Ordering::Relaxed);
    }

    fn token(item: &Item<'_>) -> Token {
        match item {
            Item::Began { .. } => Token::Began,
            Item::Sample { .. } => Token::Sample,
            Item::State(_) => Token::State,
            Item::Event { .. } => Token::Event,
            Item::Evidence { .. } => Token::Evidence,
            Item::Command { .. } => Token::Command,
            Item::Client { .. } => Token::Client,
            Item::Link { .. } => Token::Link,
            Item::Wire { .. } => Token::Wire,
        }
    }

    /// Puts what belongs to the token of an item into the ring of its kind; whether it fits.
    #[inline]
    fn put_value(&mut self, item: &Item<'_>) -> (Token, bool) {
        let fits = match *item {
            Item::Began { host_us, beginning } => self.began.push((host_us, *beginning)).is_ok(),
            Item::Sample { host_us, index, sample, taxels } => {
                self.put_sample(host_us, index, sample, taxels)
            }
            Item::State(state) => self.states.push(*state).is_ok(),
            Item::Event { host_us, event } => self.events.push((host_us, *event)).is_ok(),
            Item::Evidence { host_us, evidence } => {
                self.evidence.push((host_us, *evidence)).is_ok()
            }
            Item::Command { host_us, grip } => self.commands.push((host_us, *grip)).is_ok(),
            Item::Client { host_us, command } => self.clients.push((host_us, command)).is_ok(),
            Item::Link { host_us, note } => self.links.push((host_us, *note)).is_ok(),
            Item::Wire { host_us, to_device, bytes } => {
                let Ok(len) = u32::try_from(bytes.len()) else { return (Token::Wire, false) };
                !self.chunks.is_full()
                    && put_all(&mut self.bytes, bytes)
                    && self.chunks.push(Chunk { host_us, to_device, len }).is_ok()
            }
        };
        (Self::token(item), fits)
    }

    #[inline]
    fn put_sample(&mut self, host_us: u64, index: u32, sample: &Sample, taxels: &[f32]) -> bool {
        let taxels = taxels.get(..usize::from(MAX_ELEMENTS)).unwrap_or(taxels);
        let Ok(len) = u16::try_from(taxels.len()) else { return false };
        !self.samples.is_full()
            && put_all(&mut self.taxels, taxels)
            && self.samples.push(Taken { host_us, sample: *sample, index, taxels: len }).is_ok()
    }

    /// What was dropped.
    #[must_use]
    pub fn drops(&self) -> Arc<Drops> {
        Arc::clone(&self.drops)
    }
}

impl Inbox {
    /// Hands out every item that is there now, in order; how many.
    pub fn drain(&mut self, report: &mut dyn FnMut(Item<'_>)) -> usize {
        let count = self.tokens.slots();
        (0..count).map_while(|_| self.next(report)).count()
    }

    /// Hands out the next item.
    fn next(&mut self, report: &mut dyn FnMut(Item<'_>)) -> Option<()> {
        match self.tokens.pop().ok()? {
            Token::Began => {
                let (host_us, beginning) = self.began.pop().ok()?;
                report(Item::Began { host_us, beginning: &beginning });
            }
            Token::Sample => {
                let Taken { host_us, sample, index, taxels } = self.samples.pop().ok()?;
                let mut frame = [0.0; MAX_ELEMENTS as usize];
                let taxels = frame.get_mut(..usize::from(taxels))?;
                for place in taxels.iter_mut() {
                    *place = self.taxels.pop().ok()?;
                }
                report(Item::Sample { host_us, index, sample: &sample, taxels });
            }
            Token::State => {
                let state = self.states.pop().ok()?;
                report(Item::State(&state));
            }
            Token::Event => {
                let (host_us, event) = self.events.pop().ok()?;
                report(Item::Event { host_us, event: &event });
            }
            Token::Evidence => {
                let (host_us, evidence) = self.evidence.pop().ok()?;
                report(Item::Evidence { host_us, evidence: &evidence });
            }
            Token::Command => {
                let (host_us, grip) = self.commands.pop().ok()?;
                report(Item::Command { host_us, grip: &grip });
            }
            Token::Client => {
                let (host_us, command) = self.clients.pop().ok()?;
                report(Item::Client { host_us, command });
            }
            Token::Link => {
                let (host_us, note) = self.links.pop().ok()?;
                report(Item::Link { host_us, note: &note });
            }
            Token::Wire => self.wire(report)?,
        }
        Some(())
    }

    fn wire(&mut self, report: &mut dyn FnMut(Item<'_>)) -> Option<()> {
        let Chunk { host_us, to_device, len } = self.chunks.pop().ok()?;
        let chunk = self.bytes.read_chunk(usize::try_from(len).ok()?).ok()?;
        let (first, second) = chunk.as_slices();
        for bytes in [first, second] {
            if !bytes.is_empty() || len == 0 {
                report(Item::Wire { host_us, to_device, bytes });
            }
        }
        chunk.commit_all();
        Some(())
    }

    /// Whether nothing more can come: the other end is gone and everything was handed out.
    #[must_use]
    pub fn is_finished(&self) -> bool {
        self.tokens.is_abandoned() && self.tokens.is_empty()
    }

    /// What was dropped.
    #[must_use]
    pub fn drops(&self) -> Arc<Drops> {
        Arc::clone(&self.drops)
    }
}

// The nouns that leave the hot thread, in the order in which things happened.

/// One thing that happened. Host times are monotonic microseconds since the start of the daemon.
#[derive(Clone, Copy, Debug)]
pub enum Item<'a> {
    /// A pipeline begins, at the start of sampling, after a restart of the gripper and with a new configuration: the next samples go through it.
    Began {
        /// Host time (us).
        host_us: u64,
        /// What it begins with.
        beginning: &'a Beginning,
    },
    /// A sample went through the pipeline.
    Sample {
        /// Host time at which its frame was complete (us).
        host_us: u64,
        /// Number of the row on the device; wraps.
        index: u32,
        /// The sample.
        sample: &'a Sample,
        /// The frame of the taxel array that came with it, empty where none did.
        taxels: &'a [f32],
    },
    /// What the pipeline thinks after the last sample of a frame.
    State(&'a PipelineState),
    /// Something worth a line.
    Event {
        /// Host time (us).
        host_us: u64,
        /// What.
        event: &'a Event,
    },
    /// What a slip that has ended showed, where there is a shadow model to be asked about it.
    Evidence {
        /// Host time (us).
        host_us: u64,
        /// What.
        evidence: &'a SlipEvidence,
    },
    /// A force command was written to the gripper.
    Command {
        /// Host time (us).
        host_us: u64,
        /// The command as sent.
        grip: &'a Grip,
    },
    /// A client's command was carried out.
    Client {
        /// Host time (us).
        host_us: u64,
        /// What it asked for.
        command: ClientCommand,
    },
    /// Something about the link.
    Link {
        /// Host time (us).
        host_us: u64,
        /// What.
        note: &'a LinkNote,
    },
    /// Bytes as they were read from or written to the line.
    Wire {
        /// Host time (us).
        host_us: u64,
        /// Whether they went to the gripper.
        to_device: bool,
        /// The bytes.
        bytes: &'a [u8],
    },
}

/// What the link reports, as far as people and programs want to know it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LinkNote {
    /// The state of the host's side changed.
    State(LinkState),
    /// A gripper answered.
    Identified {
        /// Its identity.
        uid: [u8; 16],
        /// Its number of starts.
        boot_id: u32,
        /// What runs on it.
        firmware: Firmware,
        /// Whether it has restarted since it was seen last.
        rebooted: bool,
    },
    /// Another gripper than the one before answered, and was left alone.
    OtherGripper {
        /// Its identity.
        uid: [u8; 16],
    },
    /// The gripper's limits are in force.
    Configured(Clamped),
    /// The gripper has restarted.
    Rebooted,
    /// State of the gripper as it reports it.
    Status(Status),
    /// The gripper reports a fault or a change of state.
    Device(DeviceEvent),
    /// The gripper refused a request.
    Refused(Nack),
    /// The link closed.
    Closed(CloseReason),
    /// The newest row was so old (us) at a command that the force was not raised; noted once an episode.
    Late(u64),
    /// An alarm has the steady level of a machine; noted once an alarm.
    Steady,
    /// The port is open.
    PortOpened,
    /// The port is gone, or cannot be opened.
    PortLost,
}

impl LinkNote {
    /// A sentence for people; `None` for what STATE and GRIPPER hold.
    #[must_use]
    pub fn text(&self) -> Option<String> {
        Some(match self {
            LinkNote::State(_) | LinkNote::Status(_) | LinkNote::Configured(_) => return None,
            LinkNote::Identified { uid, rebooted, .. } => {
                let again = if *rebooted { ", restarted" } else { "" };
                format!("gripper {}{again}", Uid(*uid))
            }
            LinkNote::OtherGripper { uid } => format!("another gripper answered: {}", Uid(*uid)),
            LinkNote::Rebooted => "the gripper has restarted".to_owned(),
            LinkNote::Device(event) => {
                let fault = event.fault.0;
                match event.kind {
                    EventKind::Fault => format!("the gripper has stopped with fault {fault:04x}"),
                    EventKind::FaultCleared => format!("the gripper is free of fault {fault:04x}"),
                    EventKind::CommandRejected => {
                        format!("the gripper takes no command because of fault {fault:04x}")
                    }
                    _ => format!("gripper: {} -> {}", event.before, event.after),
                }
            }
            LinkNote::Refused(nack) => {
                format!("the gripper refused type {:02x}: {}", nack.kind.0, nack.reason)
            }
            LinkNote::Closed(reason) => format!("link closed: {}", explain(reason)),
            LinkNote::Late(late_us) => {
                format!("readings were {} ms late, the force was not raised", late_us / 1000)
            }
            LinkNote::Steady => format!("the slip is {STEADY}"),
            LinkNote::PortOpened => "the port is open".to_owned(),
            LinkNote::PortLost => "the port is gone".to_owned(),
        })
    }
}
