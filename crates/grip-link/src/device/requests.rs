//! Handlers of received frames: changes of state and replies.

use super::force::Taken;
use super::outbox::Reply;
use super::{DeviceEvent, DeviceLink};
use crate::decoder::Fault;
use crate::frame::Header;
use crate::message::{
    Ack, Clamped, ClearFault, Config, ConfigAck, DeviceState, EventKind, FaultCode, Grip, Hello,
    Layout, Nack, NackReason, ToDevice, Versions,
};

impl DeviceLink {
    pub(super) fn on_fault(&mut self, tick: u64, fault: Fault) -> Option<DeviceEvent> {
        match fault {
            Fault::UnknownKind(header) => self.refuse(&header, NackReason::UnknownType),
            Fault::Stale(_) if self.sender.session == 0 && tick >= self.announce_due => {
                self.announce_due = tick.saturating_add(self.ticks(100));
                self.outbox.replies.push(Reply::Ident { session: 0 });
            }
            _ => {}
        }
        None
    }

    pub(super) fn on_frame(&mut self, tick: u64) -> Option<DeviceEvent> {
        let frame = self.decoder.frame()?;
        let header = frame.header;
        let Ok(message) = ToDevice::parse(&frame) else {
            self.malformed = self.malformed.saturating_add(1);
            self.refuse(&header, NackReason::Malformed);
            return None;
        };
        match message {
            ToDevice::Hello(hello) => self.on_hello(tick, &header, &hello),
            ToDevice::Config(config) => self.on_config(tick, &header, &config),
            ToDevice::Start => self.on_start(&header),
            ToDevice::Stop => {
                self.sampling = false;
                self.agree(&header);
                Some(DeviceEvent::Stopped)
            }
            ToDevice::Ping(ping) => {
                self.outbox.replies.push(Reply::Pong { ping, rx_tick: tick });
                None
            }
            ToDevice::Grip(grip) => self.on_grip(tick, &grip),
            ToDevice::Heartbeat(heartbeat) => Some(DeviceEvent::Heartbeat(heartbeat)),
            ToDevice::Estop => {
                self.estop(tick);
                self.agree(&header);
                Some(DeviceEvent::Estop)
            }
            ToDevice::ClearFault(clear) => self.on_clear(tick, &header, clear),
        }
    }

    fn agree(&mut self, header: &Header) {
        if header.ack_req {
            self.outbox.replies.push(Reply::Ack(Ack { kind: header.kind, seq: header.seq }));
        }
    }

    fn refuse(&mut self, header: &Header, reason: NackReason) {
        if header.ack_req {
            self.outbox.replies.push(Reply::Nack(Nack {
                kind: header.kind,
                reason,
                seq: header.seq,
            }));
        }
    }

    /// A good request that cannot be carried out now.
    fn decline(&mut self, header: &Header, reason: NackReason) {
        self.refused = self.refused.saturating_add(1);
        self.refuse(header, reason);
    }

    fn on_hello(&mut self, tick: u64, header: &Header, hello: &Hello) -> Option<DeviceEvent> {
        let session = header.session;
        if session == 0 {
            self.malformed = self.malformed.saturating_add(1);
            return None;
        }
        self.outbox.replies.push(Reply::Ident { session });
        Versions::OURS.common(hello.versions)?;
        self.decoder.open_session(session, Some(header.seq));
        self.sender.session = session;
        self.disarm(tick);
        Some(DeviceEvent::Linked { session })
    }

    /// Back to LINKED, or to what is latched: the force is held, the loss delay goes on.
    fn disarm(&mut self, tick: u64) {
        self.guard.hold(tick);
        self.in_force = None;
        self.sampling = false;
        self.enter(tick, self.latch.state().unwrap_or(DeviceState::Linked));
    }

    fn on_config(&mut self, tick: u64, header: &Header, asked: &Config) -> Option<DeviceEvent> {
        if self.latch.state().is_some() {
            self.decline(header, NackReason::Latched);
            return None;
        }
        let config = self.clamp(asked);
        if config.channel_mask == 0 {
            self.decline(header, NackReason::Malformed);
            return None;
        }
        self.guard.arm(&config);
        self.guard.hold(tick);
        self.layout = Layout::new(self.config.ident.channels(), config.channel_mask);
        let row_bytes = self.layout.row_bytes(config.format);
        self.batches.configure(&config, row_bytes, self.config.ident.tick_hz);
        self.in_force = Some(config);
        self.sampling = false;
        self.enter(tick, DeviceState::Armed);
        let clamped = Clamped::between(asked, &config);
        self.outbox.replies.push(Reply::Config(ConfigAck { seq: header.seq, clamped, config }));
        Some(DeviceEvent::Configured(config))
    }

    fn clamp(&self, asked: &Config) -> Config {
        let limits = self.config.ident.limits;
        let slowest =
            self.config.ident.tick_hz.div_ceil(u32::from(u16::MAX)).min(limits.rate_max_hz);
        let force_max_mn = asked.force_max_mn.min(limits.force_max_mn);
        Config {
            sample_rate_hz: asked.sample_rate_hz.clamp(slowest, limits.rate_max_hz),
            channel_mask: asked.channel_mask & self.config.ident.available(asked.format),
            force_max_mn,
            slew_mn_s: asked.slew_mn_s.min(limits.slew_max_mn_s),
            ttl_ms: asked.ttl_ms.clamp(Config::TTL_MIN_MS, Config::TTL_MAX_MS),
            hold_cap_mn: asked.hold_cap_mn.min(limits.hold_cap_mn).min(force_max_mn),
            loss_after_ms: asked.loss_after_ms.clamp(100, 60_000),
            ..*asked
        }
    }

    fn on_start(&mut self, header: &Header) -> Option<DeviceEvent> {
        if self.in_force.is_none() {
            self.decline(header, NackReason::WrongState);
            return None;
        }
        self.agree(header);
        let began = !self.sampling;
        self.sampling = true;
        began.then_some(DeviceEvent::Started)
    }

    fn on_grip(&mut self, tick: u64, grip: &Grip) -> Option<DeviceEvent> {
        self.status_due = tick;
        let armed =
            matches!(self.state, DeviceState::Armed | DeviceState::Active | DeviceState::Hold);
        let taken = if armed { self.guard.command(tick, grip) } else { Taken::Rejected };
        match taken {
            Taken::Accepted => {
                self.enter(tick, DeviceState::Active);
                Some(DeviceEvent::Command(*grip))
            }
            Taken::Old => {
                self.old = self.old.saturating_add(1);
                None
            }
            Taken::Rejected => {
                self.guard.reject();
                self.rejected = self.rejected.wrapping_add(1);
                self.note(tick, EventKind::CommandRejected, self.state, grip.force_mn);
                Some(DeviceEvent::Rejected(*grip))
            }
        }
    }

    fn on_clear(&mut self, tick: u64, header: &Header, clear: ClearFault) -> Option<DeviceEvent> {
        let fault = clear.fault;
        if !fault.is_fault() || self.latch.code() != fault {
            // A repeated request whose first answer was lost: the fault is gone already.
            if fault.is_fault() && self.cleared == fault {
                self.agree(header);
            } else {
                self.decline(header, NackReason::OtherFault);
            }
            return None;
        }
        if self.latch.estop {
            self.latch.estop = false;
        } else {
            self.latch.fault = FaultCode::NONE;
        }
        self.cleared = fault;
        self.agree(header);
        let before = self.state;
        self.disarm(tick);
        self.note(tick, EventKind::FaultCleared, before, i32::from(fault.0));
        Some(DeviceEvent::Cleared(fault))
    }
}
