//! From the hot thread to the service thread: bounded rings that drop and count, and never wait.

use core::sync::atomic::{AtomicU64, Ordering};
use grip_host::report::EventLine;
use grip_link::{
    host::{HostEvent, HostState},
    message::{Clamped, Event as DeviceEvent, EventKind, Nack},
};
use rtrb::{Consumer, Producer, RingBuffer};
use slip_core::{
    Sample,
    esc::Esc,
    estimate::ForceEstimate,
    health::Health,
    scene::Scene,
    units::{Micros, Newtons},
};
use std::sync::Arc;

/// Room for 1.6 s of samples at 20 kHz.
const SAMPLES: usize = 32_768;
const NOTES: usize = 1024;

/// Something for the service thread to tell.
#[derive(Debug)]
pub(crate) enum Note {
    Event(EventLine),
    State(HostState),
    Identified { rebooted: bool },
    Configured(Clamped),
    Rebooted,
    Device(DeviceEvent),
    Refused(Nack),
    Status(Status),
}

/// What the status line shows.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Status {
    pub(crate) t: Micros,
    pub(crate) scene: Scene,
    pub(crate) statistic: f32,
    pub(crate) health: Health,
    pub(crate) command: Option<Newtons>,
    pub(crate) esc: Option<Esc>,
    pub(crate) estimate: Option<ForceEstimate>,
    pub(crate) lost: u64,
    pub(crate) rate_hz: u32,
}

/// The hot end.
#[derive(Debug)]
pub(crate) struct Outbox {
    notes: Producer<Note>,
    samples: Option<Producer<Sample>>,
    dropped: Arc<Dropped>,
}

/// The service end.
#[derive(Debug)]
pub(crate) struct Inbox {
    pub(crate) notes: Consumer<Note>,
    pub(crate) samples: Option<Consumer<Sample>>,
    pub(crate) dropped: Arc<Dropped>,
}

/// What did not fit into the rings.
#[derive(Debug, Default)]
pub(crate) struct Dropped {
    notes: AtomicU64,
    samples: AtomicU64,
}

impl Dropped {
    pub(crate) fn notes(&self) -> u64 {
        self.notes.load(Ordering::Relaxed)
    }

    pub(crate) fn samples(&self) -> u64 {
        self.samples.load(Ordering::Relaxed)
    }
}

pub(crate) fn channel(record: bool) -> (Outbox, Inbox) {
    let (note_in, note_out) = RingBuffer::new(NOTES);
    let (sample_in, sample_out) = record.then(|| RingBuffer::new(SAMPLES)).unzip();
    let dropped = Arc::new(Dropped::default());
    let outbox = Outbox { notes: note_in, samples: sample_in, dropped: Arc::clone(&dropped) };
    (outbox, Inbox { notes: note_out, samples: sample_out, dropped })
}

impl Outbox {
    pub(crate) fn note(&mut self, note: Note) {
        if self.notes.push(note).is_err() {
            self.dropped.notes.fetch_add(1, Ordering::Relaxed);
        }
    }

    /// What the link tells, as far as a person wants to know it.
    pub(crate) fn link(&mut self, event: &HostEvent<'_>) {
        self.note(match *event {
            HostEvent::State { to, .. } => Note::State(to),
            HostEvent::Identified { rebooted } => Note::Identified { rebooted },
            HostEvent::Configured { clamped } => Note::Configured(clamped),
            HostEvent::Rebooted { .. } => Note::Rebooted,
            HostEvent::Event(event) if event.kind != EventKind::State => Note::Device(event),
            HostEvent::Refused(nack) => Note::Refused(nack),
            _ => return,
        });
    }

    /// A status line may be skipped; it takes no room that an event could need.
    pub(crate) fn status(&mut self, status: Status) {
        if self.notes.slots() > NOTES / 2 {
            self.note(Note::Status(status));
        }
    }

    pub(crate) fn sample(&mut self, sample: &Sample) {
        if let Some(samples) = &mut self.samples
            && samples.push(*sample).is_err()
        {
            self.dropped.samples.fetch_add(1, Ordering::Relaxed);
        }
    }
}
