//! Good frames in, notices and events to pass on out.

use super::conversation::Conversation;
use super::link::HostEvent;
use super::request::Request;
use super::timing::QUICK_PING_US;
use super::{CloseReason, LinkState};
use crate::clock::{ClockSync, PongVerdict};
use crate::decoder::Decoder;
use crate::frame::Frame;
use crate::message::{
    Ack, ChannelKind, ConfigAck, DeviceState, Event, Ident, Kind, Layout, Log, Nack, NackReason,
    PayloadError, Pong, Samples, Stats, Status, Versions,
};

impl Conversation {
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
                return Ok(verdict.map(|verdict| HostEvent::Clock(verdict)));
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
