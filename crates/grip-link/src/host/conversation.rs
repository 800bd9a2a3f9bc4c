//! State of one link on the host's side: the notices and events to pass on from good frames.

use super::{
    CloseReason, HostConfig, LAST_BYTES, LinkState,
    link::{GripCommand, HostEvent},
    request::{Due, Request},
};
use crate::{
    clock::{ClockSync, PongVerdict},
    decoder::{Counters, Decoder},
    frame::{Direction, Frame, MAX_WIRE, Sender},
    message::{
        Ack, ClearFault, Config, ConfigAck, DeviceState, Event, FaultCode, Grip, GripMode, Hello,
        Ident, Kind, Layout, Log, Nack, NackReason, PayloadError, Ping, Pong, Samples,
        SamplesHeader, Stats, Status, Versions,
    },
};

#[derive(Debug, Clone)]
pub(super) struct Conversation {
    pub(super) config: HostConfig,
    pub(super) sender: Sender,
    pub(super) state: LinkState,
    pub(super) announced: LinkState,
    /// An event that waits for the caller.
    pub(super) notice: Option<HostEvent>,
    pub(super) session: u16,
    pub(super) greet_again: bool,
    pub(super) hello_since_us: u64,
    pub(super) hello_due_us: u64,
    pub(super) hellos: u32,
    pub(super) bytes: u64,
    pub(super) last: [u8; LAST_BYTES],
    pub(super) at_open: Counters,
    pub(super) ident: Option<Ident>,
    pub(super) in_force: Option<Config>,
    pub(super) layout: Layout,
    pub(super) request: Option<Request>,
    pub(super) rows: RowCount,
    pub(super) clock: Option<ClockSync>,
    pub(super) pings: u8,
    pub(super) ping_due_us: u64,
    pub(super) samples_us: u64,
    pub(super) frame_us: u64,
    pub(super) cmd_id: u32,
    /// Force of the last GRIP of this session.
    pub(super) force_sent_mn: Option<i32>,
    pub(super) last_grip: Option<Grip>,
    pub(super) malformed: u32,
    pub(super) unexpected: u32,
    pub(super) failures: u8,
}

impl Conversation {
    pub(super) fn new(config: HostConfig) -> Self {
        Self {
            config,
            sender: Sender::new(Direction::ToDevice),
            state: LinkState::Closed,
            announced: LinkState::Closed,
            notice: None,
            session: 0,
            greet_again: false,
            hello_since_us: 0,
            hello_due_us: 0,
            hellos: 0,
            bytes: 0,
            last: [0; LAST_BYTES],
            at_open: Counters::default(),
            ident: None,
            in_force: None,
            layout: Layout::EMPTY,
            request: None,
            rows: RowCount::default(),
            clock: None,
            pings: 0,
            ping_due_us: 0,
            samples_us: 0,
            frame_us: 0,
            cmd_id: 0,
            force_sent_mn: None,
            last_grip: None,
            malformed: 0,
            unexpected: 0,
            failures: 0,
        }
    }

    pub(super) fn greet(&mut self, now_us: u64, session: u16, decoder: &mut Decoder) {
        self.session = session;
        self.sender.session = session;
        decoder.open_session(session, None);
        self.hello_since_us = now_us;
        self.hello_due_us = now_us;
        self.hellos = 0;
        self.in_force = None;
        self.request = None;
        self.force_sent_mn = None;
        self.frame_us = now_us;
    }

    pub(super) fn forget_loss(&mut self) {
        self.rows = RowCount::default();
    }

    pub(super) fn close(&mut self, reason: CloseReason) {
        self.state = LinkState::Closed;
        self.request = None;
        self.in_force = None;
        if reason != CloseReason::Requested {
            self.failures = self.failures.saturating_add(1);
        }
        self.notice = Some(HostEvent::Closed(reason));
    }

    pub(super) const fn is_linked(&self) -> bool {
        matches!(self.state, LinkState::Config | LinkState::Stream | LinkState::Degraded)
    }

    pub(super) const fn is_streaming(&self) -> bool {
        self.state.streams()
    }

    pub(super) fn pending(&mut self) -> Option<HostEvent> {
        if let Some(notice) = self.notice.take() {
            return Some(notice);
        }
        let (from, to) = (self.announced, self.state);
        self.announced = to;
        (from != to).then_some(HostEvent::State { from, to })
    }

    /// Acts on a frame; what is to be passed on with its contents is returned, the rest becomes a notice.
    pub(super) fn on_frame(&mut self, now_us: u64, frame: &Frame<'_>) -> Option<HostEvent> {
        self.take_frame(now_us, frame).unwrap_or_else(|_short| {
            self.malformed = self.malformed.saturating_add(1);
            None
        })
    }

    fn take_frame(
        &mut self,
        now_us: u64,
        frame: &Frame<'_>,
    ) -> Result<Option<HostEvent>, PayloadError> {
        let payload = frame.payload;
        match frame.header.kind {
            Kind::IDENT if frame.header.session == 0 => self.on_announcement(payload)?,
            Kind::IDENT => self.on_ident(now_us, payload)?,
            Kind::CONFIG_ACK => self.on_config_ack(now_us, &ConfigAck::parse(payload)?),
            Kind::ACK => self.on_ack(now_us, Ack::parse(payload)?),
            Kind::NACK => self.on_nack(Nack::parse(payload)?),
            Kind::PONG => {
                let pong = Pong::parse(payload)?;
                let verdict = self.clock.as_mut().map(|clock| clock.push(&pong, now_us));
                if verdict == Some(PongVerdict::Outlier) {
                    self.ping_quickly(self.ping_due_us.min(now_us.saturating_add(QUICK_PING_US)));
                }
                return Ok(verdict.map(HostEvent::Clock));
            }
            Kind::SAMPLES => return self.on_samples(now_us, payload),
            Kind::STATUS => return self.on_status(now_us, payload),
            Kind::STATS => return Ok(Some(HostEvent::Stats(Stats::parse(payload)?))),
            Kind::EVENT => return Ok(Some(HostEvent::Event(Event::parse(payload)?))),
            Kind::LOG => return Log::parse(payload).map(|_| Some(HostEvent::Log)),
            _ => {}
        }
        Ok(None)
    }

    /// An IDENT of session 0: the gripper knows no session, so it must have started anew.
    fn on_announcement(&mut self, payload: &[u8]) -> Result<(), PayloadError> {
        let now = Ident::parse(payload)?.boot_id;
        if self.is_linked() && !self.greet_again {
            self.greet_again = true;
            let before = self.ident.map_or(0, |ident| ident.boot_id);
            self.notice = Some(HostEvent::Rebooted { before, now });
        }
        Ok(())
    }

    fn on_ident(&mut self, now_us: u64, payload: &[u8]) -> Result<(), PayloadError> {
        if self.state != LinkState::Hello {
            self.count_unexpected();
            return Ok(());
        }
        let Versions { min, max } = Versions::parse(payload)?;
        if Versions::OURS.common(Versions { min, max }).is_none() {
            self.close(CloseReason::VersionMismatch { min, max });
            return Ok(());
        }
        let Ok(ident) = Ident::parse(payload) else {
            self.close(CloseReason::BadIdent);
            return Ok(());
        };
        if !ident.shows_slips() {
            self.close(CloseReason::NoStylus);
            return Ok(());
        }
        let same_boot = |old: &Ident| old.uid == ident.uid && old.boot_id == ident.boot_id;
        let rebooted = self.ident.as_ref().is_some_and(|old| !same_boot(old));
        if rebooted || self.clock.is_none() {
            self.clock = Some(ClockSync::new(ident.tick_hz, ident.boot_id));
        }
        self.ident = Some(ident);
        self.ping_quickly(now_us);
        self.notice = Some(HostEvent::Identified { rebooted });
        self.configure(now_us);
        Ok(())
    }

    /// Asks for the wanted CONFIG.
    pub(super) fn configure(&mut self, now_us: u64) {
        self.state = LinkState::Config;
        self.in_force = None;
        self.request = Some(Request::new(Kind::CONFIG, 0, now_us));
    }

    fn count_unexpected(&mut self) {
        self.unexpected = self.unexpected.saturating_add(1);
    }

    /// A gripper that streamed and states LINKED has lost its CONFIG, as a repeated HELLO of this session makes it.
    fn on_status(
        &mut self,
        now_us: u64,
        payload: &[u8],
    ) -> Result<Option<HostEvent>, PayloadError> {
        let status = Status::parse(payload)?;
        if self.is_streaming() && self.request.is_none() && status.state == DeviceState::Linked {
            self.configure(now_us);
        }
        Ok(Some(HostEvent::Status(status)))
    }

    fn answered(&mut self, kind: Kind, seq: u16) -> bool {
        let answered = self.request.as_ref().is_some_and(|request| request.answered_by(kind, seq));
        if answered {
            self.request = None;
        } else {
            self.count_unexpected();
        }
        answered
    }

    fn on_config_ack(&mut self, now_us: u64, ack: &ConfigAck) {
        if self.answered(Kind::CONFIG, ack.seq) {
            self.in_force = Some(ack.config);
            self.layout = Layout::new(
                self.ident.as_ref().map_or(&[], Ident::channels),
                ack.config.channel_mask,
            );
            self.rows.restart();
            self.notice = Some(HostEvent::Configured { clamped: ack.clamped });
            self.request = Some(Request::new(Kind::START, 0, now_us));
        }
    }

    fn on_ack(&mut self, now_us: u64, ack: Ack) {
        if ack.kind != Kind::ESTOP && !self.answered(ack.kind, ack.seq) {
            return;
        }
        self.notice = Some(HostEvent::Done(ack.kind));
        match ack.kind {
            Kind::START => self.stream(now_us),
            Kind::STOP => self.state = LinkState::Config,
            Kind::CLEAR_FAULT => self.configure(now_us),
            _ => {}
        }
    }

    fn stream(&mut self, now_us: u64) {
        self.state = LinkState::Stream;
        self.samples_us = now_us;
        self.failures = 0;
        self.rows.restart();
    }

    fn on_nack(&mut self, nack: Nack) {
        if !self.answered(nack.kind, nack.seq) {
            return;
        }
        let vital =
            matches!(nack.kind, Kind::CONFIG | Kind::START) && nack.reason != NackReason::Latched;
        if vital {
            self.close(CloseReason::Refused { kind: nack.kind.0, reason: nack.reason });
        } else {
            self.notice = Some(HostEvent::Refused(nack));
        }
    }

    fn on_samples(
        &mut self,
        now_us: u64,
        payload: &[u8],
    ) -> Result<Option<HostEvent>, PayloadError> {
        // CONFIG stopped the sampling before: samples now mean that START arrived and its ACK did not.
        if self
            .request
            .as_ref()
            .is_some_and(|request| request.kind == Kind::START && request.was_sent())
        {
            self.request = None;
            self.notice = Some(HostEvent::Done(Kind::START));
            self.stream(now_us);
        }
        if !self.is_streaming() {
            self.count_unexpected();
            return Ok(None);
        }
        let header = Samples::parse(payload, &self.layout)?.header;
        let loss = self.rows.take(&header);
        self.samples_us = now_us;
        self.state = if loss.is_contiguous() { LinkState::Stream } else { LinkState::Degraded };
        Ok(Some(HostEvent::Samples { header, loss }))
    }

    /// Opens another session after the gripper started anew; takes no more of this one after closing, whatever else came
    /// in the same read.
    pub(super) fn after_frame(&mut self, now_us: u64, decoder: &mut Decoder) {
        if self.state == LinkState::Closed {
            decoder.close_session();
        }
        if core::mem::take(&mut self.greet_again) {
            self.state = LinkState::Hello;
            let session = self.session.wrapping_add(1).max(1);
            self.greet(now_us, session, decoder);
        }
    }
}

/// What is missing before a batch.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Loss {
    /// Rows missing according to the row numbers.
    pub rows: u32,
    /// Of these, rows the MCU states it dropped; the others were lost on the wire.
    pub dropped_by_mcu: u32,
    /// The row numbers went back: the MCU counts afresh and nothing can be said about loss.
    pub restarted: bool,
}

impl Loss {
    /// Whether the batch continues the one before.
    #[must_use]
    pub const fn is_contiguous(&self) -> bool {
        self.rows == 0 && !self.restarted
    }
}

/// Sums since the link opened.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct LossCount {
    /// Rows received.
    pub received: u64,
    /// Rows missing.
    pub lost: u64,
    /// Of these, dropped by the MCU.
    pub dropped_by_mcu: u64,
    /// Times the row numbers went back.
    pub restarts: u32,
}

/// Follows the row numbers of one boot.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct RowCount {
    next: Option<(u32, u32)>,
    count: LossCount,
}

impl RowCount {
    /// Takes the next batch as the first of its kind.
    pub(super) const fn restart(&mut self) {
        self.next = None;
    }

    pub(super) const fn count(&self) -> LossCount {
        self.count
    }

    pub(super) fn take(&mut self, header: &SamplesHeader) -> Loss {
        let SamplesHeader { first_index, rows, dropped_total, .. } = *header;
        let loss = self.next.map_or(Loss::default(), |(expected, dropped)| {
            let missing = first_index.wrapping_sub(expected);
            let restarted = missing > u32::MAX / 2;
            let rows = if restarted { 0 } else { missing };
            Loss { rows, dropped_by_mcu: dropped_total.wrapping_sub(dropped).min(rows), restarted }
        });
        self.next = Some((first_index.wrapping_add(u32::from(rows)), dropped_total));
        self.count.received += u64::from(rows);
        self.count.lost += u64::from(loss.rows);
        self.count.dropped_by_mcu += u64::from(loss.dropped_by_mcu);
        self.count.restarts = self.count.restarts.saturating_add(u32::from(loss.restarted));
        loss
    }
}

// Timing of the link: frames that are due, and the end of links that are silent.

const HELLO_EVERY_US: u64 = 100_000;
const QUICK_PINGS: u8 = 8;
pub(super) const QUICK_PING_US: u64 = 50_000;
const PING_US: u64 = 1_000_000;
const PREAMBLE: [u8; 8] = [0; 8];

impl Conversation {
    pub(super) fn tick(&mut self, now_us: u64, decoder: &mut Decoder) {
        let silent_us = now_us.saturating_sub(self.frame_us);
        match self.state {
            LinkState::Closed | LinkState::Open => {}
            LinkState::Hello
                if now_us.saturating_sub(self.hello_since_us) >= self.config.hello_for_us =>
            {
                self.close(self.no_answer(decoder.counters()));
            }
            LinkState::Hello => {}
            _ if self
                .request
                .as_ref()
                .is_some_and(|request| request.due(now_us) == Due::GiveUp) =>
            {
                let kind = self.request.map_or(0, |request| request.kind.0);
                self.close(CloseReason::Unanswered { kind });
            }
            _ if silent_us > self.config.lost_us => self.close(CloseReason::Lost { silent_us }),
            LinkState::Stream if now_us.saturating_sub(self.samples_us) > self.stale_us() => {
                self.state = LinkState::Degraded;
            }
            _ => {}
        }
        if self.state == LinkState::Closed {
            decoder.close_session();
        }
    }

    fn stale_us(&self) -> u64 {
        let rate_hz = self.in_force.map_or(0, |config| config.sample_rate_hz);
        let three_periods = 3_000_000_u64.checked_div(u64::from(rate_hz)).unwrap_or(0);
        self.config.stale_us.max(three_periods)
    }

    /// Counts received `bytes`, and keeps the last of them until somebody answers.
    pub(super) fn count(&mut self, bytes: &[u8]) {
        self.bytes = self.bytes.saturating_add(bytes.len() as u64);
        if self.state == LinkState::Hello {
            self.last.rotate_left(bytes.len().min(LAST_BYTES));
            let places = self.last.iter_mut().rev();
            places.zip(bytes.iter().rev()).for_each(|(place, byte)| *place = *byte);
        }
    }

    fn no_answer(&self, now: &Counters) -> CloseReason {
        let before = &self.at_open;
        let others = |c: &Counters| c.stale.saturating_add(c.version).saturating_add(c.unknown);
        CloseReason::NoAnswer {
            hellos: self.hellos,
            bytes: self.bytes,
            garbage_bytes: now.garbage_bytes.saturating_sub(before.garbage_bytes),
            echoes: now.echo.saturating_sub(before.echo),
            frames: others(now).saturating_sub(others(before)),
            last: self.last,
        }
    }

    pub(super) fn transmit(&mut self, now_us: u64, out: &mut [u8; MAX_WIRE]) -> Option<usize> {
        match self.state {
            LinkState::Closed | LinkState::Other(_) => None,
            LinkState::Open => {
                self.state = LinkState::Hello;
                out.first_chunk_mut().map(|start| *start = PREAMBLE)?;
                Some(PREAMBLE.len())
            }
            LinkState::Hello if now_us >= self.hello_due_us => {
                self.hello_due_us = now_us.saturating_add(HELLO_EVERY_US);
                self.hellos = self.hellos.saturating_add(1);
                let hello =
                    Hello { versions: Versions::OURS, max_rx: 480, caps: 0, time_us: now_us };
                let mut payload = [0; Hello::SIZE];
                hello.write(&mut payload).ok()?;
                self.sender.send(Kind::HELLO, true, &payload, out)
            }
            LinkState::Hello => None,
            LinkState::Config | LinkState::Stream | LinkState::Degraded => {
                self.send_request(now_us, out).or_else(|| self.send_ping(now_us, out))
            }
        }
    }

    fn send_request(&mut self, now_us: u64, out: &mut [u8; MAX_WIRE]) -> Option<usize> {
        let request = self.request.as_mut().filter(|request| request.due(now_us) == Due::Send)?;
        let mut payload = [0; Config::SIZE];
        let len = match request.kind {
            Kind::CONFIG => self.config.config.write(&mut payload),
            Kind::CLEAR_FAULT => ClearFault { fault: FaultCode(request.fault) }.write(&mut payload),
            _ => Ok(0),
        };
        let seq = self.sender.next_seq();
        let sent = self.sender.send(request.kind, true, payload.get(..len.ok()?)?, out)?;
        request.sent(seq, now_us);
        Some(sent)
    }

    /// The clocks are not related well: the next PING is due at `due_us`, and the ones after it come quickly.
    pub(super) const fn ping_quickly(&mut self, due_us: u64) {
        self.pings = 0;
        self.ping_due_us = due_us;
    }

    /// Starts the clock estimate again.
    pub(super) fn resync(&mut self, now_us: u64) {
        let Some(ident) = &self.ident else { return };
        self.clock = Some(ClockSync::new(ident.tick_hz, ident.boot_id));
        self.ping_quickly(now_us);
    }

    fn send_ping(&mut self, now_us: u64, out: &mut [u8; MAX_WIRE]) -> Option<usize> {
        if now_us < self.ping_due_us {
            return None;
        }
        self.pings = self.pings.saturating_add(1);
        let wait_us = if self.pings < QUICK_PINGS { QUICK_PING_US } else { PING_US };
        self.ping_due_us = now_us.saturating_add(wait_us);
        let ping = Ping { t1_us: now_us };
        self.sender.message(Kind::PING, |p| ping.write(p), out)
    }

    pub(super) fn grip(
        &mut self,
        command: &GripCommand,
        out: &mut [u8; MAX_WIRE],
    ) -> Option<usize> {
        let config = self.in_force.filter(|_| self.is_streaming() && command.force_mn >= 0)?;
        let most_mn = match self.state {
            LinkState::Degraded if command.mode == GripMode::Force => {
                self.force_sent_mn?.min(config.force_max_mn)
            }
            _ => config.force_max_mn,
        };
        let grip = Grip {
            cmd_id: self.cmd_id.wrapping_add(1),
            mode: command.mode.code(),
            flags: if command.answers_slip { Grip::ANSWERS_SLIP } else { 0 },
            ttl_ms: command.ttl_ms,
            force_mn: command.force_mn.min(most_mn),
            slew_mn_s: command.slew_mn_s,
            cause_sample: command.cause_sample,
        };
        let mut payload = [0; Grip::SIZE];
        grip.write(&mut payload).ok()?;
        let len = self.sender.send(Kind::GRIP, false, &payload, out)?;
        self.cmd_id = grip.cmd_id;
        self.force_sent_mn = Some(if command.mode == GripMode::Force { grip.force_mn } else { 0 });
        self.last_grip = Some(grip);
        Some(len)
    }
}
