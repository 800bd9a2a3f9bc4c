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
/// Room for their taxels, 16 with each sample: 2 MB, of which memory is taken only where it is written.
const TAXELS: usize = 16 * SAMPLES;
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

/// A sample on its way to the file.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Recorded {
    pub(crate) sample: Sample,
    /// Values of its frame, which stand in the ring of the taxels; 0 where no frame came.
    pub(crate) frame: usize,
    /// Taxels of the gripper's array.
    pub(crate) columns: usize,
}

/// Where samples and their frames go in.
#[derive(Debug)]
struct SamplesIn {
    samples: Producer<Recorded>,
    taxels: Producer<f32>,
    columns: usize,
}

/// Where they come out.
#[derive(Debug)]
pub(crate) struct SamplesOut {
    samples: Consumer<Recorded>,
    taxels: Consumer<f32>,
}

impl SamplesIn {
    /// Whether sample and frame found room.
    fn push(&mut self, sample: &Sample, frame: &[f32]) -> bool {
        if self.samples.is_full() || self.taxels.slots() < frame.len() {
            return false;
        }
        // The frame first: the sample tells the other end that it is there.
        for value in frame {
            if self.taxels.push(*value).is_err() {
                return false;
            }
        }
        let recorded = Recorded { sample: *sample, frame: frame.len(), columns: self.columns };
        self.samples.push(recorded).is_ok()
    }
}

impl SamplesOut {
    /// The next sample; its frame is written to `frame`.
    pub(crate) fn pop(&mut self, frame: &mut Vec<f32>) -> Option<Recorded> {
        let recorded = self.samples.pop().ok()?;
        frame.clear();
        frame.extend((0..recorded.frame).map_while(|_| self.taxels.pop().ok()));
        Some(recorded)
    }
}

/// The hot end.
#[derive(Debug)]
pub(crate) struct Outbox {
    notes: Producer<Note>,
    samples: Option<SamplesIn>,
    dropped: Arc<Dropped>,
}

/// The service end.
#[derive(Debug)]
pub(crate) struct Inbox {
    pub(crate) notes: Consumer<Note>,
    pub(crate) samples: Option<SamplesOut>,
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
    let (sample_in, sample_out) = record
        .then(|| {
            let (samples, samples_out) = RingBuffer::new(SAMPLES);
            let (taxels, taxels_out) = RingBuffer::new(TAXELS);
            let out = SamplesOut { samples: samples_out, taxels: taxels_out };
            (SamplesIn { samples, taxels, columns: 0 }, out)
        })
        .unzip();
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

    /// The gripper has an array of `count` taxels.
    pub(crate) fn set_taxels(&mut self, count: usize) {
        if let Some(samples) = &mut self.samples {
            samples.columns = count;
        }
    }

    /// A sample and the frame of the taxel array that came with it.
    pub(crate) fn sample(&mut self, sample: &Sample, frame: &[f32]) {
        if let Some(samples) = &mut self.samples
            && !samples.push(sample, frame)
        {
            self.dropped.samples.fetch_add(1, Ordering::Relaxed);
        }
    }
}
