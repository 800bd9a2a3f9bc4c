//! State of the daemon right now, from items and counters: the one source of metrics, status and dumps.

use crate::{
    counters::HotCounters,
    live::Course,
    rings::{Item, LinkNote},
};
use grip_link::{
    host::{CloseReason, LinkState},
    message::{FaultCode, Firmware, Status as DeviceStatus},
};
use grip_session::report::Event;
use slip_core::{Phase, PipelineState, alarm::Method};
use std::{collections::VecDeque, path::PathBuf};

/// Events that are remembered.
const EVENTS: usize = 32;
/// Counts over which the rate is taken.
const COUNTS: usize = 5;

/// What does not change while the daemon runs, or only with a reload.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct About {
    /// Version of the program.
    pub version: String,
    /// The port as it was asked for.
    pub port: String,
    /// Configuration files in force, the strongest first.
    pub config_files: Vec<PathBuf>,
    /// Reloads that were taken over, and that were refused.
    pub reloads: (u64, u64),
    /// What was asked of the system for real time.
    pub grants: Vec<Grant>,
    /// Whether no force command is ever sent.
    pub dry_run: bool,
    /// Differs from start to start.
    pub run_id: u32,
}

/// Something that was asked of the system for real time.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Grant {
    /// What, for example `SCHED_FIFO 50`.
    pub what: String,
    /// Why not, where it was not granted.
    pub refused: Option<String>,
}

/// What the sockets report.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct ClientCounts {
    /// Clients connected now.
    pub connected: u64,
    /// Clients since the start.
    pub accepted: u64,
    /// Clients turned away because there were too many.
    pub refused: u64,
    /// Messages that slow clients did not get.
    pub dropped: u64,
    /// Commands that were not allowed or not understood.
    pub bad_commands: u64,
}

/// What the recorder reports.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct RecordingState {
    /// The file that is written; `None` where nothing is recorded.
    pub file: Option<PathBuf>,
    /// Bytes written since the start, over all files.
    pub bytes: u64,
    /// Files begun.
    pub files: u64,
    /// Items that were not recorded.
    pub dropped: u64,
    /// Why the recording stopped, where it did.
    pub failure: Option<String>,
}

/// Events seen, by kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct EventCounts {
    /// Slips noticed as incipient, by method: stylus, travel, pressure.
    pub incipient: [u64; 3],
    /// Slips noticed as, or turned, gross.
    pub gross: [u64; 3],
    /// Slips that ended.
    pub ended: u64,
    /// Changes of a sensor's health.
    pub health: u64,
}

/// What the link has shown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinkBoard {
    /// State of the host's side.
    pub state: LinkState,
    /// Whether a port is open.
    pub port_open: bool,
    /// Identity and number of starts of the gripper.
    pub gripper: Option<([u8; 16], u32)>,
    /// What runs on it.
    pub firmware: Option<Firmware>,
    /// The last word of the gripper on itself.
    pub device: Option<DeviceStatus>,
    /// Why the link closed last, and when (host us).
    pub closed: Option<(u64, CloseReason)>,
    /// Times it closed by error.
    pub failures: u64,
    /// Times the gripper has restarted.
    pub reboots: u64,
    /// Other grippers that answered and were left alone.
    pub strangers: u64,
    /// Requests that the gripper refused.
    pub refusals: u64,
    /// Faults that the gripper reported, and the last of them.
    pub faults: (u64, FaultCode),
}

impl Default for LinkBoard {
    fn default() -> Self {
        Self {
            state: LinkState::Closed,
            port_open: false,
            gripper: None,
            firmware: None,
            device: None,
            closed: None,
            failures: 0,
            reboots: 0,
            strangers: 0,
            refusals: 0,
            faults: (0, FaultCode::NONE),
        }
    }
}

/// All that is known.
#[derive(Clone, Debug, Default)]
pub struct Board {
    /// What does not change.
    pub about: About,
    /// Clients.
    pub clients: ClientCounts,
    /// The recording.
    pub recording: RecordingState,
    /// What is known of the object in hand or next; `None` where nothing is remembered.
    pub object: Option<String>,
    link: LinkBoard,
    counters: HotCounters,
    /// Host time (us) and samples of the last counts, the oldest first.
    counts: VecDeque<(u64, u64)>,
    state: Option<PipelineState>,
    course: Course,
    events: VecDeque<(u64, Event)>,
    event_counts: EventCounts,
    pipelines: u64,
    client_commands: u64,
}

impl Board {
    /// A board of a daemon that has just started.
    #[must_use]
    pub fn new(about: About) -> Self {
        Self { about, events: VecDeque::with_capacity(EVENTS), ..Self::default() }
    }

    /// Takes what happened.
    pub fn take(&mut self, item: &Item<'_>) {
        match *item {
            Item::Began { .. } => self.pipelines += 1,
            Item::State(state) => {
                self.course.take(state, self.fault().is_some());
                self.state = Some(*state);
            }
            Item::Event { host_us, event } => self.event(host_us, *event),
            Item::Client { .. } => self.client_commands += 1,
            Item::Link { host_us, note } => self.note(host_us, note),
            // Counted by the hot thread.
            Item::Sample { .. }
            | Item::Evidence { .. }
            | Item::Command { .. }
            | Item::Wire { .. } => {}
        }
    }

    /// Takes the counters of the hot thread.
    pub fn count(&mut self, counters: &HotCounters) {
        self.counters = *counters;
        if self.counts.back().is_some_and(|(_, samples)| *samples > counters.samples) {
            self.counts.clear();
        }
        if self.counts.len() == COUNTS {
            self.counts.pop_front();
        }
        self.counts.push_back((counters.host_us, counters.samples));
    }

    fn event(&mut self, host_us: u64, event: Event) {
        if self.events.len() == EVENTS {
            self.events.pop_front();
        }
        self.events.push_back((host_us, event));
        self.course.slipped |= matches!(event, Event::Slip(slip) if slip.phase != Phase::Ended);
        match event {
            Event::Slip(slip) if slip.phase == Phase::Ended => self.event_counts.ended += 1,
            Event::Slip(slip) => {
                let counts = &mut self.event_counts;
                let gross = slip.phase == Phase::Gross;
                let counts = if gross { &mut counts.gross } else { &mut counts.incipient };
                let mut counts = Method::ALL.into_iter().zip(counts);
                if let Some((_, count)) = counts.find(|(method, _)| *method == slip.method) {
                    *count += 1;
                }
            }
            Event::Health { .. } => self.event_counts.health += 1,
            Event::Grip { .. } => {}
        }
    }

    fn note(&mut self, host_us: u64, note: &LinkNote) {
        let link = &mut self.link;
        match *note {
            LinkNote::State(state) => link.state = state,
            LinkNote::Identified { uid, boot_id, firmware, .. } => {
                link.gripper = Some((uid, boot_id));
                link.firmware = Some(firmware);
            }
            LinkNote::OtherGripper { .. } => link.strangers += 1,
            LinkNote::Rebooted => link.reboots += 1,
            LinkNote::Status(status) => link.device = Some(status),
            LinkNote::Device(event) if event.fault.is_fault() => {
                link.faults = (link.faults.0 + 1, event.fault);
            }
            LinkNote::Refused(_) => link.refusals += 1,
            LinkNote::Closed(reason) => {
                link.state = LinkState::Closed;
                link.closed = Some((host_us, reason));
                link.failures += u64::from(reason != CloseReason::Requested);
            }
            LinkNote::PortOpened => link.port_open = true,
            LinkNote::PortLost => {
                link.port_open = false;
                link.state = LinkState::Closed;
            }
            LinkNote::Configured(_)
            | LinkNote::Device(_)
            | LinkNote::Late(_)
            | LinkNote::Steady => {}
        }
    }

    /// The link.
    #[must_use]
    pub fn link(&self) -> &LinkBoard {
        &self.link
    }

    /// The latched fault of the gripper, where it has one.
    pub(crate) fn fault(&self) -> Option<FaultCode> {
        self.link.device.map(|device| device.fault).filter(|fault| fault.is_fault())
    }

    /// The last counters.
    #[must_use]
    pub fn counters(&self) -> &HotCounters {
        &self.counters
    }

    /// The last state of the pipeline with its host time (us).
    #[must_use]
    pub fn state(&self) -> Option<&PipelineState> {
        self.state.as_ref()
    }

    pub(crate) fn course(&self) -> &Course {
        &self.course
    }

    /// The last events with their host times (us), the oldest first.
    #[must_use]
    pub fn events(&self) -> impl DoubleEndedIterator<Item = &(u64, Event)> {
        self.events.iter()
    }

    /// Events by kind.
    #[must_use]
    pub fn event_counts(&self) -> EventCounts {
        self.event_counts
    }

    /// Pipelines begun.
    #[must_use]
    pub fn pipelines(&self) -> u64 {
        self.pipelines
    }

    /// Commands of clients that were carried out.
    #[must_use]
    pub fn client_commands(&self) -> u64 {
        self.client_commands
    }

    /// Samples per second over the last five counts, which is about a second; `None` before there are two, and after the counters
    /// began anew.
    #[must_use]
    pub fn rate_hz(&self) -> Option<f64> {
        let ((first_us, first), (last_us, last)) = self.counts.front().zip(self.counts.back())?;
        let us = last_us.checked_sub(*first_us).filter(|us| *us > 0)?;
        let rate = (last - first) as f64 * 1e6 / us as f64;
        Some(rate)
    }

    /// Whether samples flow and can be used: what a health check wants to know.
    #[must_use]
    pub fn is_healthy(&self) -> bool {
        self.link.state.streams() && !self.counters.blind
    }
}
