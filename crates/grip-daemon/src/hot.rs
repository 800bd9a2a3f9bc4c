//! The hot thread: read -> decode -> pipeline -> write, paced by the data.
//!
//! Once a gripper is attached nothing here allocates, locks, logs or waits for anything but bytes; what there is to report goes into rings.
//! Lines come from another thread, which finds and opens them, and go back to it when they are lost.

use crate::{
    counters::HotCounters,
    rhythm::Rhythm,
    rings::{Item, LinkNote, Outbox},
};
use core::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use core::time::Duration;
use grip_link::{
    frame::{MAX_WIRE, OVERHEAD},
    host::{CloseReason, HostEvent, LinkState},
    message::{EventKind, Grip},
};
use grip_port::{Line, PortError, READ_TIMEOUT, nonce};
use grip_session::{
    HostConfig, HostEstimator, Session, SessionError, Update, report::Event, session::explain,
    shadow::SlipEvidence,
};
use rtrb::{Consumer, Producer};
use rustix::event::{Timespec, poll};
use slip_core::ClientCommand;
use slip_core::{Phase, PipelineState, SlipReport, units::Micros};
use std::sync::Arc;

/// Counters are copied this often (us).
const PULSE_EVERY_US: u64 = 250_000;
/// Without clients and recording, states are reported this often (us).
const STATE_EVERY_US: u64 = 20_000;
/// Late commands closer together than this (us) are one episode.
const LATE_EPISODE_US: u64 = 1_000_000;
/// Bytes of a force command on the wire, at most.
const COMMAND: usize = Grip::SIZE + OVERHEAD + 4;
/// Bytes read at once.
const INPUT: usize = 4096;

/// Why the loop cannot go on.
#[derive(Debug, thiserror::Error)]
pub enum HotError {
    /// The link closed before a gripper was ever attached, and the loop was not asked to be patient.
    #[error("{}", explain(.0))]
    Closed(CloseReason),
    /// The settings do not fit the gripper.
    #[error(transparent)]
    Session(#[from] SessionError),
}

/// Why a turn ended early.
#[derive(Debug)]
enum Break {
    /// The line is of no use any more.
    Line,
    /// The session cannot go on.
    Session(SessionError),
}

impl From<PortError> for Break {
    /// What the system states of a line that is gone helps nobody: it is looked for again, and the search states why it is not found.
    fn from(_: PortError) -> Self {
        Self::Line
    }
}

impl From<SessionError> for Break {
    fn from(error: SessionError) -> Self {
        Self::Session(error)
    }
}

/// What other threads see and state; none of it is waited for.
#[derive(Debug, Default)]
pub struct Shared {
    /// Set to end the loop.
    pub stop: Arc<AtomicBool>,
    /// Turns of the loop so far: it lives while this advances.
    pub beat: AtomicU64,
    /// Whether somebody wants every sample and state beside the recorder.
    pub wants_samples: AtomicBool,
    /// Whether there is a shadow model to be asked about slips.
    pub wants_evidence: AtomicBool,
}

/// Settings on their way in, and what they replaced on its way back.
#[derive(Debug)]
pub struct Settings {
    /// The configuration.
    pub config: HostConfig,
    /// The network.
    pub estimator: HostEstimator,
    /// Why they were refused; the settings are then those that came in.
    pub refused: Option<SessionError>,
}

/// A line that was lost: it is closed by the thread that opened it.
#[derive(Debug)]
pub struct Lost {
    /// The line.
    pub line: Line,
    /// Whether a gripper was attached over it.
    pub attached: bool,
    /// Whether another gripper than the right one answered on it.
    pub other: bool,
}

/// The ends of the rings that lead to and from the loop.
#[derive(Debug)]
pub struct Ends {
    /// Open lines.
    pub lines: Consumer<Line>,
    /// Lines that were lost.
    pub lost: Producer<Lost>,
    /// Settings to put in force.
    pub settings: Consumer<Box<Settings>>,
    /// Settings that were replaced.
    pub replaced: Producer<Box<Settings>>,
    /// Commands of clients.
    pub commands: Consumer<ClientCommand>,
    /// To the service thread.
    pub service: Outbox,
    /// To the recorder.
    pub recorder: Option<Outbox>,
    /// Copies of the counters.
    pub pulses: Producer<HotCounters>,
    /// What is shared.
    pub shared: Arc<Shared>,
}

/// How the loop behaves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HotOptions {
    /// Time at which it ends (us).
    pub end_us: u64,
    /// Waits for a gripper that is not there yet, instead of giving up.
    pub patient: bool,
    /// Does not sleep so long (us) before and after the next frame is due; 0: sleeps until it is there.
    pub spin_us: u16,
}

/// The loop and its memory. `C` gives monotonic nanoseconds since the start of the daemon.
#[derive(Debug)]
pub struct Hot<C> {
    session: Session,
    clock: C,
    options: HotOptions,
    ends: Ends,
    counters: HotCounters,
    pulse_us: u64,
    state_us: u64,
    /// Since when settings have waited to be put in force (us).
    asked_us: Option<u64>,
    attached: bool,
    other: bool,
    /// Age of the newest usable row at the last command (us).
    late_us: Option<u64>,
    /// Host time (us) until which a late command belongs to the present episode.
    episode_us: u64,
    rhythm: Rhythm,
}

/// What a turn found out.
#[derive(Clone, Copy, Debug, Default)]
struct Turn {
    closed: Option<CloseReason>,
    degraded: bool,
    /// A pipeline has begun with the settings that a gripper took.
    configured: bool,
    other: bool,
    stepped: bool,
    /// When a slip has ended.
    slip_ended: Option<Micros>,
}

impl<C: Fn() -> u64> Hot<C> {
    /// A loop that has no line yet.
    #[must_use]
    pub fn new(session: Session, clock: C, options: HotOptions, ends: Ends) -> Self {
        Self {
            session,
            clock,
            options,
            ends,
            counters: HotCounters::default(),
            pulse_us: 0,
            state_us: 0,
            asked_us: None,
            attached: false,
            other: false,
            late_us: None,
            episode_us: 0,
            rhythm: Rhythm::default(),
        }
    }

    fn now_us(&self) -> u64 {
        (self.clock)() / 1000
    }

    /// Runs until it is asked to stop or its time is over. A lost line is given back and the next one waited for.
    ///
    /// # Errors
    /// Where a gripper cannot be worked with, or never answered and the loop is not patient.
    pub fn run(&mut self) -> Result<(), HotError> {
        let mut line: Option<Line> = None;
        while !self.ends.shared.stop.load(Ordering::Relaxed) && self.now_us() < self.options.end_us
        {
            match &mut line {
                None => line = self.next_line()?,
                Some(open) => match self.turn(open) {
                    Ok(None) => {}
                    Ok(Some(reason)) => self.lose(line.take(), Some(reason))?,
                    Err(Break::Line) => self.lose(line.take(), None)?,
                    Err(Break::Session(error)) => return Err(error.into()),
                },
            }
            self.between_frames();
        }
        // The last counts are what a summary is made of.
        self.pulse(self.now_us());
        Ok(())
    }

    /// The next line, opened for the session; waits a little where there is none.
    fn next_line(&mut self) -> Result<Option<Line>, HotError> {
        let Ok(line) = self.ends.lines.pop() else {
            pause();
            self.turned(self.now_us());
            return Ok(None);
        };
        let now_us = self.now_us();
        self.session.open(now_us, nonce())?;
        self.note(now_us, LinkNote::PortOpened);
        self.counters.reconnects += u64::from(self.attached);
        self.session.set_least_interval(line.least_interval_us(COMMAND));
        self.rhythm = Rhythm::default();
        self.other = false;
        Ok(Some(line))
    }

    /// Gives a line back that is of no use any more.
    fn lose(&mut self, line: Option<Line>, reason: Option<CloseReason>) -> Result<(), HotError> {
        let now_us = self.now_us();
        self.session.close();
        self.note(now_us, LinkNote::PortLost);
        if let Some(line) = line {
            let lost = Lost { line, attached: self.attached, other: self.other };
            // Room for as many as there can be; a line that did not fit would be closed here.
            drop(self.ends.lost.push(lost));
        }
        let refusal = self.session.refusal();
        match (reason, refusal) {
            _ if self.attached || self.options.patient => Ok(()),
            (_, Some(refusal)) => Err(refusal.into()),
            (Some(reason), None) => Err(HotError::Closed(reason)),
            (None, None) => Ok(()),
        }
    }

    /// Takes what the line has and writes the command it leads to. Gives the reason where the link closed.
    fn turn(&mut self, line: &mut Line) -> Result<Option<CloseReason>, Break> {
        self.transmit(line)?;
        let mut input = [0; INPUT];
        let count = self.read(line, &mut input)?;
        let received_ns = (self.clock)();
        let turn = self.receive(line, input.get(..count).unwrap_or(&[]), received_ns)?;
        self.attached |= turn.configured;
        self.other |= turn.other;
        self.counters.degraded += u64::from(turn.degraded);
        let now_us = received_ns / 1000;
        if turn.stepped {
            self.rhythm.frame(received_ns);
            self.report_state(now_us);
        }
        self.turned(now_us);
        Ok(turn.closed)
    }

    /// Waits for bytes and reads them. Where the loop may spin it sleeps until shortly before the next frame is due, and then asks until
    /// shortly after: to wake a thread takes longer than all that it does here.
    fn read(&mut self, line: &mut Line, input: &mut [u8]) -> Result<usize, PortError> {
        let now_ns = (self.clock)();
        let Some((from_ns, until_ns)) = self.rhythm.awaited(now_ns, self.options.spin_us) else {
            return line.read(input, READ_TIMEOUT);
        };
        let sleep = Duration::from_nanos(from_ns.saturating_sub(now_ns));
        let mut count = line.read(input, sleep.min(READ_TIMEOUT))?;
        // Where it was woken early the loop goes round first.
        while count == 0 && (from_ns..until_ns).contains(&(self.clock)()) {
            count = line.read(input, Duration::ZERO)?;
        }
        Ok(count)
    }

    /// The loop has gone round, with a line or without.
    fn turned(&mut self, now_us: u64) {
        self.counters.turns += 1;
        self.ends.shared.beat.store(self.counters.turns, Ordering::Relaxed);
        if now_us >= self.pulse_us {
            self.pulse(now_us);
        }
    }

    /// Runs bytes through the session and writes the command.
    fn receive(&mut self, line: &mut Line, bytes: &[u8], received_ns: u64) -> Result<Turn, Break> {
        let host_us = received_ns / 1000;
        let mut out = [0; MAX_WIRE];
        let mut turn = Turn::default();
        self.counters.rx_bytes += bytes.len() as u64;
        if !bytes.is_empty() {
            let item = Item::Wire { host_us, to_device: false, bytes };
            put(&mut self.ends, &item);
        }
        let mut left = bytes;
        while let Some(updates) = self.session.receive(host_us, &mut left)? {
            turn.take(&mut self.ends, host_us, &updates);
            if let Some(t) = turn.slip_ended.take() {
                self.report_evidence(host_us, t);
            }
        }
        if self.session.take_steady().is_some() {
            self.note(host_us, LinkNote::Steady);
        }
        let Some(len) = self.session.command(host_us, &mut out) else { return Ok(turn) };
        let frame = out.get(..len).unwrap_or(&out);
        line.write_command(frame)?;
        let taken_ns = (self.clock)().saturating_sub(received_ns);
        self.counters.latency.record(taken_ns);
        self.age_evidence(host_us);
        self.reported(host_us, frame);
        if let Some(grip) = self.session.link().last_grip().copied() {
            put(&mut self.ends, &Item::Command { host_us, grip: &grip });
        }
        Ok(turn)
    }

    /// What the slip that has just ended showed, where somebody asks a shadow model about it. That happens in another thread.
    #[cold]
    fn report_evidence(&mut self, host_us: u64, t: Micros) {
        if self.ends.shared.wants_evidence.load(Ordering::Relaxed)
            && let Some(evidence) = SlipEvidence::of(self.session.log(), t)
        {
            self.ends.service.put(&Item::Evidence { host_us, evidence: &evidence });
        }
    }

    /// How old the newest row was at the command that was just written.
    fn age_evidence(&mut self, host_us: u64) {
        self.late_us = self.session.evidence_age_us(host_us);
        let Some(late_us) = self.late_us else { return };
        self.counters.evidence_age.record(1000 * late_us);
        if self.session.is_late(host_us) {
            self.counters.late_commands += 1;
            if host_us >= self.episode_us {
                self.note(host_us, LinkNote::Late(late_us));
            }
            self.episode_us = host_us + LATE_EPISODE_US;
        }
    }

    /// Bytes were written.
    fn reported(&mut self, host_us: u64, bytes: &[u8]) {
        self.counters.tx_bytes += bytes.len() as u64;
        put(&mut self.ends, &Item::Wire { host_us, to_device: true, bytes });
    }

    /// Writes what the link itself has to report, one frame a write.
    fn transmit(&mut self, line: &mut Line) -> Result<(), PortError> {
        let mut out = [0; MAX_WIRE];
        let host_us = self.now_us();
        while let Some(len) = self.session.poll_transmit(host_us, &mut out) {
            let frame = out.get(..len).unwrap_or(&out);
            line.write_frame(frame)?;
            self.reported(host_us, frame);
        }
        Ok(())
    }

    /// What other threads want, at the border of a frame.
    fn between_frames(&mut self) {
        while let Ok(command) = self.ends.commands.pop() {
            let host_us = self.now_us();
            if self.session.obey(host_us, command) {
                put(&mut self.ends, &Item::Client { host_us, command });
            }
        }
        if self.ends.settings.is_empty() {
            return;
        }
        let host_us = self.now_us();
        let waited_us = host_us.saturating_sub(*self.asked_us.get_or_insert(host_us));
        while self.session.can_swap(waited_us)
            && let Ok(mut settings) = self.ends.settings.pop()
        {
            self.asked_us = None;
            let Self { session, ends, .. } = self;
            let Settings { config, estimator, refused } = &mut *settings;
            match session.swap(config, estimator) {
                Ok(Some(beginning)) => put(ends, &Item::Began { host_us, beginning }),
                Ok(None) => {}
                Err(error) => *refused = Some(error),
            }
            // As many came in as can go back.
            drop(self.ends.replaced.push(settings));
        }
    }

    fn note(&mut self, host_us: u64, note: LinkNote) {
        put(&mut self.ends, &Item::Link { host_us, note: &note });
    }

    /// Copies the counters for the service thread; where it has not taken the last ones, these come later.
    fn pulse(&mut self, now_us: u64) {
        self.pulse_us = now_us + PULSE_EVERY_US;
        self.counters.host_us = now_us;
        self.counters.read(&self.session);
        self.counters.service_dropped = self.ends.service.drops().now().total();
        self.counters.recorder_dropped =
            self.ends.recorder.as_ref().map_or(0, |ring| ring.drops().now().total());
        let _later = self.ends.pulses.push(self.counters);
    }

    /// The state after a frame: to the recorder always, to the service thread as often as somebody looks.
    fn report_state(&mut self, host_us: u64) {
        let wanted = self.ends.shared.wants_samples.load(Ordering::Relaxed);
        let due = host_us >= self.state_us;
        if !(wanted || due || self.ends.recorder.is_some()) {
            return;
        }
        let Some(state) = self.state(host_us) else { return };
        let item = Item::State(&state);
        if let Some(recorder) = &mut self.ends.recorder {
            recorder.put(&item);
        }
        if wanted || due {
            self.state_us = host_us + STATE_EVERY_US;
            self.ends.service.put(&item);
        }
    }

    fn state(&self, host_us: u64) -> Option<PipelineState> {
        let (features, estimate) = self.session.log().evidence();
        let esc = features.and_then(|features| features.esc);
        let state = self.session.latest()?.state(self.session.grip_state(), esc, estimate);
        Some(PipelineState {
            host: Micros(host_us),
            sensors: self.session.sensors()?,
            applied_n: self.session.applied_n(),
            lost: self.session.lost(),
            rate_hz: self.session.link().in_force().map_or(0, |config| config.sample_rate_hz),
            late_ms: self.late_us.map(|us| us as f32 * 1e-3),
            ..state
        })
    }

    /// What the loop counted.
    #[must_use]
    pub fn counters(&self) -> &HotCounters {
        &self.counters
    }

    /// The session, for a summary.
    #[must_use]
    pub fn session(&self) -> &Session {
        &self.session
    }
}

impl Turn {
    /// Sends updates on their way.
    #[inline]
    fn take(&mut self, ends: &mut Ends, host_us: u64, updates: &Update<'_>) {
        match *updates {
            Update::Step { index, sample, taxels, .. } => {
                self.stepped = true;
                let item = Item::Sample { host_us, index, sample, taxels };
                if let Some(recorder) = &mut ends.recorder {
                    recorder.put(&item);
                }
                if ends.shared.wants_samples.load(Ordering::Relaxed) {
                    ends.service.put(&item);
                }
            }
            Update::Event(event) => {
                if let Event::Slip(SlipReport { phase: Phase::Ended, t, .. }) = event {
                    self.slip_ended = Some(t);
                }
                put(ends, &Item::Event { host_us, event: &event });
            }
            Update::Began(beginning) => {
                self.configured = true;
                put(ends, &Item::Began { host_us, beginning });
            }
            Update::Gripper { ident, rebooted, other } => {
                self.other |= other;
                let note = if other {
                    LinkNote::OtherGripper { uid: ident.uid }
                } else {
                    let (uid, boot_id, firmware) = (ident.uid, ident.boot_id, ident.firmware);
                    LinkNote::Identified { uid, boot_id, firmware, rebooted }
                };
                put(ends, &Item::Link { host_us, note: &note });
            }
            Update::Link(event) => self.link(ends, host_us, &event),
        }
    }

    fn link(&mut self, ends: &mut Ends, host_us: u64, event: &HostEvent) {
        let note = match *event {
            HostEvent::State { to, .. } => {
                self.degraded |= to == LinkState::Degraded;
                LinkNote::State(to)
            }
            HostEvent::Configured { clamped } => LinkNote::Configured(clamped),
            HostEvent::Rebooted { .. } => LinkNote::Rebooted,
            HostEvent::Status(status) => LinkNote::Status(status),
            HostEvent::Event(event) if event.kind != EventKind::State => LinkNote::Device(event),
            HostEvent::Refused(nack) => LinkNote::Refused(nack),
            HostEvent::Closed(reason) => {
                self.closed = Some(reason);
                LinkNote::Closed(reason)
            }
            _ => return,
        };
        put(ends, &Item::Link { host_us, note: &note });
    }
}

/// Waits a little for a line.
fn pause() {
    let timeout = Timespec { tv_sec: 0, tv_nsec: 2_000_000 };
    // Ended early by a signal: the caller looks again all the same.
    let _ended = poll(&mut [], Some(&timeout));
}

/// Puts an item into both sets of rings.
#[inline]
fn put(ends: &mut Ends, item: &Item<'_>) {
    if let Some(recorder) = &mut ends.recorder {
        recorder.put(item);
    }
    ends.service.put(item);
}
