//! The next frame to send, of what is due at a tick.

use super::DeviceLink;
use super::force::Drive;
use super::outbox::Reply;
use crate::frame::MAX_WIRE;
use crate::message::{
    Event, ForceClamp, Ident, Kind, Log, LogLevel, Pong, Stats, Status, StatusFlags,
};

impl DeviceLink {
    /// Writes the next frame that is due, or returns `None`. Call it whenever the port can take a frame.
    pub fn poll_transmit(&mut self, tick: u64, out: &mut [u8; MAX_WIRE]) -> Option<usize> {
        self.step(tick);
        if let Some(reply) = self.outbox.replies.peek() {
            self.outbox.replies.pop();
            return self.send_reply(tick, reply, out);
        }
        if self.sender.session == 0 {
            return None;
        }
        if let Some(event) = self.outbox.events.peek() {
            self.outbox.events.pop();
            let dropped = u16::try_from(self.outbox.events.dropped() & 0xFFFF).unwrap_or(u16::MAX);
            let event = Event { dropped, ..event };
            return self.sender.message(Kind::EVENT, |p| event.write(p), out);
        }
        self.batches.close_old(tick);
        let (status, samples) =
            (tick >= self.status_due, self.sampling && self.batches.oldest().is_some());
        if samples && (self.samples_next || !status) {
            return self.send_samples(out);
        }
        if status {
            return self.send_status(tick, out);
        }
        if tick >= self.stats_due {
            self.stats_due = tick.saturating_add(self.ticks(1000));
            let stats = self.stats();
            return self.sender.message(Kind::STATS, |p| stats.write(p), out);
        }
        None
    }

    /// Writes a LOG at once; `None` without a session or for a text over 255 bytes.
    pub fn log(
        &mut self,
        tick: u64,
        level: LogLevel,
        text: &str,
        out: &mut [u8; MAX_WIRE],
    ) -> Option<usize> {
        let log = Log { tick, level, text: text.as_bytes() };
        if self.sender.session == 0 {
            None
        } else {
            self.sender.message(Kind::LOG, |p| log.write(p), out)
        }
    }

    fn send_reply(&mut self, tick: u64, reply: Reply, out: &mut [u8; MAX_WIRE]) -> Option<usize> {
        match reply {
            Reply::Ident { session } => {
                let ident =
                    Ident { state: self.state, fault: self.latch.code(), ..self.config.ident };
                self.sender
                    .within(session, |sender| sender.message(Kind::IDENT, |p| ident.write(p), out))
            }
            Reply::Config(ack) => self.sender.message(Kind::CONFIG_ACK, |p| ack.write(p), out),
            Reply::Ack(ack) => self.sender.message(Kind::ACK, |p| ack.write(p), out),
            Reply::Nack(nack) => self.sender.message(Kind::NACK, |p| nack.write(p), out),
            Reply::Pong { ping, rx_tick } => {
                let pong = Pong { t1_us: ping.t1_us, rx_tick, tx_tick: tick };
                self.sender.message(Kind::PONG, |p| pong.write(p), out)
            }
        }
    }

    fn send_samples(&mut self, out: &mut [u8; MAX_WIRE]) -> Option<usize> {
        let payload = self.batches.oldest()?;
        let len = self.sender.send(Kind::SAMPLES, false, payload, out)?;
        self.batches.sent();
        self.samples_next = false;
        Some(len)
    }

    fn send_status(&mut self, tick: u64, out: &mut [u8; MAX_WIRE]) -> Option<usize> {
        self.status_due = tick.saturating_add(self.ticks(8));
        self.samples_next = true;
        let status = self.status(tick);
        self.dropped_seen = self.batches.dropped_rows();
        self.sender.message(Kind::STATUS, |p| status.write(p), out)
    }

    /// STATUS as it would be sent now.
    #[must_use]
    pub fn status(&self, tick: u64) -> Status {
        let (last_cmd_id, age) =
            self.guard.last().map_or((0, u64::MAX), |(id, at)| (id, tick.saturating_sub(at)));
        let age_us = u128::from(age) * 1_000_000 / u128::from(self.config.ident.tick_hz.max(1));
        let goal = self.guard.goal();
        let flags = StatusFlags(0)
            .with(StatusFlags::SAMPLING, self.sampling)
            .with(StatusFlags::DROPPING, self.dropped_seen != self.batches.dropped_rows())
            .with(StatusFlags::PASSIVE, goal == Drive::Passive)
            .with(StatusFlags::OPEN, goal == Drive::Open)
            .with(StatusFlags::NO_COMMAND, self.guard.last().is_none())
            .with(StatusFlags::MOTION, self.moving.is_some())
            .with(StatusFlags::MOVING, self.moving == Some(true));
        Status {
            last_cmd_id,
            state: self.state,
            clamp: self.guard.clamp(),
            fault: self.latch.code(),
            applied_mn: self.measured_mn.unwrap_or(self.guard.applied_mn()),
            target_mn: goal.force_mn(),
            age_us: u32::try_from(age_us).unwrap_or(u32::MAX),
            flags,
            rejected: self.rejected,
        }
    }

    /// Clamp bits of the newest command.
    #[must_use]
    pub const fn clamp_bits(&self) -> ForceClamp {
        self.guard.clamp()
    }

    fn stats(&self) -> Stats {
        Stats {
            received: *self.decoder.counters(),
            sent: self.sender.sent(),
            dropped_batches: self.batches.dropped_batches(),
            dropped_rows: self.batches.dropped_rows(),
            malformed: self.malformed,
            old: self.old,
            refused: self.refused,
            unanswered: self.outbox.replies.dropped(),
        }
    }
}
