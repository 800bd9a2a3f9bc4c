//! What the host's side remembers of one link; good frames in, notices and events to pass on out.

use super::link::HostEvent;
use super::request::Request;
use super::timing::QUICK_PING_US;
use super::{CloseReason, HostConfig, LinkState};
use crate::clock::{ClockSync, PongVerdict};
use crate::decoder::{Counters, Decoder};
use crate::frame::{Direction, Frame};
use crate::message::{
    Ack, ChannelKind, Config, ConfigAck, DeviceState, Event, Grip, Ident, Kind, Layout, Log, Nack,
    NackReason, PayloadError, Pong, Samples, SamplesHeader, Stats, Status, Versions,
};
use crate::sender::Sender;

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
        matches!(self.state, LinkState::Stream | LinkState::Degraded)
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
        if !ident.channels().iter().any(|channel| channel.kind == ChannelKind::Stylus) {
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

    /// A gripper that streamed and says LINKED has lost its CONFIG, as a repeated HELLO of this session makes it.
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
    /// Of these, rows the MCU says it dropped; the others were lost on the wire.
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
