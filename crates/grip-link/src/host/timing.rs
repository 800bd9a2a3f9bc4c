//! Time in; frames that are due, and the end of links that are silent, out.

use super::conversation::Conversation;
use super::link::GripCommand;
use super::request::Due;
use super::{CloseReason, LinkState};
use crate::clock::ClockSync;
use crate::decoder::{Counters, Decoder};
use crate::frame::MAX_WIRE;
use crate::message::{ClearFault, Config, FaultCode, Grip, GripMode, Hello, Kind, Ping, Versions};

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

    fn no_answer(&self, now: &Counters) -> CloseReason {
        let before = &self.at_open;
        let others = |c: &Counters| c.stale.saturating_add(c.version).saturating_add(c.unknown);
        CloseReason::NoAnswer {
            hellos: self.hellos,
            bytes: self.bytes,
            garbage_bytes: now.garbage_bytes.saturating_sub(before.garbage_bytes),
            echoes: now.echo.saturating_sub(before.echo),
            frames: others(now).saturating_sub(others(before)),
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
