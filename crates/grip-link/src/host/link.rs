//! The state machine of the computer's side.

use super::conversation::{Conversation, Loss, LossCount};
use super::request::Request;
use super::{CloseReason, HostConfig, HostConfigError, LAST_BYTES, LinkState};
use crate::clock::{ClockSync, PongVerdict};
use crate::decoder::{Counters, Decoder, Role};
use crate::frame::MAX_WIRE;
use crate::message::{
    Clamped, Config, Event, FaultCode, Grip, GripMode, Heartbeat, Ident, Kind, Layout, Log, Nack,
    Samples, SamplesHeader, Stats, Status,
};
use slip_msg::units::Newtons;

/// What came out of received bytes or of time going on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum HostEvent {
    /// The state changed.
    State {
        /// State before.
        from: LinkState,
        /// State now.
        to: LinkState,
    },
    /// A gripper answered: see [`HostLink::ident`].
    Identified {
        /// Its boot_id differs from the one of the session before: everything starts again.
        rebooted: bool,
    },
    /// The gripper started anew in the middle of a session; HELLO goes out again by itself.
    Rebooted {
        /// boot_id before.
        before: u32,
        /// boot_id now.
        now: u32,
    },
    /// CONFIG is in force: see [`HostLink::in_force`].
    Configured {
        /// Fields that the gripper changed.
        clamped: Clamped,
    },
    /// A batch of samples: see [`HostLink::samples`].
    Samples {
        /// What stands before the rows.
        header: SamplesHeader,
        /// What is missing before them.
        loss: Loss,
    },
    /// State of the gripper.
    Status(Status),
    /// Link counters of the gripper.
    Stats(Stats),
    /// Fault or change of state of the gripper.
    Event(Event),
    /// Text of the gripper: see [`HostLink::log`].
    Log,
    /// A PONG went into the clock estimate.
    Clock(PongVerdict),
    /// A request was carried out.
    Done(Kind),
    /// A request was refused; the link goes on.
    Refused(Nack),
    /// The link closed.
    Closed(CloseReason),
}

/// A force command of the controller.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct GripCommand {
    /// What to do.
    pub mode: GripMode,
    /// The command answers a slip.
    pub answers_slip: bool,
    /// Force \[mN\], >= 0; above F_max it is clamped.
    pub force_mn: i32,
    /// Life \[ms\], 0 = that of CONFIG.
    pub ttl_ms: u16,
    /// Change of force \[mN/s\], 0 = that of CONFIG.
    pub slew_mn_s: u32,
    /// Sample index that caused it.
    pub cause_sample: u32,
}

impl GripCommand {
    /// A force in newtons, rounded to mN; `None` for NaN, a negative force or one over 2.1 MN.
    #[must_use]
    pub fn newtons(force_n: f32) -> Option<Self> {
        let force_mn = Newtons(force_n).to_mn()?;
        Some(Self {
            mode: GripMode::Force,
            answers_slip: false,
            force_mn,
            ttl_ms: 0,
            slew_mn_s: 0,
            cause_sample: 0,
        })
    }
}

/// The computer's end of the link.
#[derive(Debug, Clone)]
pub struct HostLink {
    decoder: Decoder,
    talk: Conversation,
}

impl HostLink {
    /// A closed link.
    ///
    /// # Errors
    /// [`HostConfigError`] with the numbers that cannot be.
    pub fn new(config: HostConfig) -> Result<Self, HostConfigError> {
        config.check()?;
        Ok(Self { decoder: Decoder::new(Role::Host), talk: Conversation::new(config) })
    }

    /// The port is open: 00 x 8 and HELLO go out next. `session` is a fresh random nonce, not 0.
    ///
    /// # Errors
    /// [`HostConfigError::Session`].
    pub fn open(&mut self, now_us: u64, session: u16) -> Result<(), HostConfigError> {
        if session == 0 {
            return Err(HostConfigError::Session);
        }
        let Self { decoder, talk } = self;
        decoder.restart();
        talk.at_open = *decoder.counters();
        (talk.bytes, talk.last) = (0, [0; LAST_BYTES]);
        talk.forget_loss();
        talk.state = LinkState::Open;
        talk.notice = None;
        talk.greet(now_us, session, decoder);
        Ok(())
    }

    /// The port is gone or no longer wanted.
    pub fn close(&mut self) {
        if self.talk.state != LinkState::Closed {
            self.talk.close(CloseReason::Requested);
            self.decoder.close_session();
        }
    }

    /// Closes the link because the caller cannot work with this gripper, for a `reason` of its own.
    pub fn refuse(&mut self, reason: CloseReason) {
        if self.talk.state != LinkState::Closed {
            self.talk.close(reason);
            self.decoder.close_session();
        }
    }

    /// Takes bytes off `input` up to the next event; `None` when they are used up and no event waits.
    ///
    /// Call it until `None`, with no bytes too when only time went on.
    pub fn receive(&mut self, now_us: u64, input: &mut &[u8]) -> Option<HostEvent> {
        loop {
            if let Some(event) = self.talk.pending() {
                return Some(event);
            }
            let before = *input;
            let verdict = self.decoder.advance(input);
            let taken = before.len().saturating_sub(input.len());
            self.talk.count(before.get(..taken).unwrap_or(before));
            match verdict {
                None => {
                    self.talk.tick(now_us, &mut self.decoder);
                    return self.talk.pending();
                }
                Some(Err(_)) => {}
                Some(Ok(())) if self.talk.state == LinkState::Closed => {}
                Some(Ok(())) => {
                    self.talk.frame_us = now_us;
                    if let Some(event) = self.talk.on_frame(now_us, &self.decoder.frame()?) {
                        return Some(event);
                    }
                    self.talk.after_frame(now_us, &mut self.decoder);
                }
            }
        }
    }

    /// The rows of the [`HostEvent::Samples`] that was returned last; `None` once more bytes were taken.
    #[must_use]
    pub fn samples(&self, header: SamplesHeader) -> Option<Samples<'_>> {
        let frame = self.decoder.frame().filter(|frame| frame.header.kind == Kind::SAMPLES)?;
        Samples::of(header, &self.talk.layout, frame.payload)
    }

    /// The text of the [`HostEvent::Log`] that was returned last; `None` once more bytes were taken.
    #[must_use]
    pub fn log(&self) -> Option<Log<'_>> {
        let frame = self.decoder.frame().filter(|frame| frame.header.kind == Kind::LOG)?;
        Log::parse(frame.payload).ok()
    }

    /// Writes the next bytes that are due: the preamble, HELLO, a request or a PING. One write for each.
    pub fn poll_transmit(&mut self, now_us: u64, out: &mut [u8; MAX_WIRE]) -> Option<usize> {
        self.talk.tick(now_us, &mut self.decoder);
        self.talk.transmit(now_us, out)
    }

    /// Writes a GRIP frame; `None` unless samples flow (STREAM or DEGRADED), and for a negative force.
    ///
    /// Force is clamped to F_max and, while DEGRADED, to the force sent before in this session; before the first one
    /// DEGRADED gives `None`, because the gripper may hold what a force of 0 drops. See [`HostLink::last_grip`].
    pub fn grip(
        &mut self,
        now_us: u64,
        command: &GripCommand,
        out: &mut [u8; MAX_WIRE],
    ) -> Option<usize> {
        self.talk.tick(now_us, &mut self.decoder);
        self.talk.grip(command, out)
    }

    /// Writes a HEARTBEAT frame; `None` without a session.
    pub fn heartbeat(&mut self, heartbeat: &Heartbeat, out: &mut [u8; MAX_WIRE]) -> Option<usize> {
        if !self.talk.is_linked() {
            return None;
        }
        self.talk.sender.message(Kind::HEARTBEAT, |p| heartbeat.write(p), out)
    }

    /// Writes an ESTOP frame, with session 0 so that it is taken in any session. Repeat it until
    /// [`HostEvent::Done`] or STATUS shows ESTOP.
    pub fn estop(&mut self, out: &mut [u8; MAX_WIRE]) -> Option<usize> {
        self.talk.sender.within(0, |sender| sender.send(Kind::ESTOP, true, &[], out))
    }

    /// Asks for other limits or another sampling: CONFIG and START go out next. Ignored when closed.
    ///
    /// # Errors
    /// [`HostConfigError::Config`].
    pub fn reconfigure(&mut self, now_us: u64, config: Config) -> Result<(), HostConfigError> {
        HostConfig { config, ..self.talk.config }.check()?;
        self.talk.config.config = config;
        if self.talk.is_linked() {
            self.talk.configure(now_us);
        }
        Ok(())
    }

    /// Asks for samples again after [`HostLink::stop`].
    pub fn start(&mut self, now_us: u64) {
        if self.talk.in_force.is_some() {
            self.talk.request = Some(Request::new(Kind::START, 0, now_us));
        }
    }

    /// Asks for no more samples; the state goes back to CONFIG.
    pub fn stop(&mut self, now_us: u64) {
        if self.talk.in_force.is_some() {
            self.talk.request = Some(Request::new(Kind::STOP, 0, now_us));
        }
    }

    /// Asks to clear the fault that STATUS or IDENT reported; CONFIG follows by itself when it is cleared.
    pub fn clear_fault(&mut self, now_us: u64, fault: FaultCode) {
        if self.talk.is_linked() {
            self.talk.request = Some(Request::new(Kind::CLEAR_FAULT, fault.0, now_us));
        }
    }

    /// How long to wait before opening again \[us\]: 0, then 50 ms doubling to 2 s with each failure in a row.
    #[must_use]
    pub fn reopen_after_us(&self) -> u64 {
        let doublings = u32::from(self.talk.failures).min(7);
        if doublings == 0 { 0 } else { (25_000 << doublings).min(2_000_000) }
    }

    /// State now.
    #[must_use]
    pub const fn state(&self) -> LinkState {
        self.talk.state
    }

    /// Session nonce in use.
    #[must_use]
    pub const fn session(&self) -> u16 {
        self.talk.session
    }

    /// The gripper, once it answered.
    #[must_use]
    pub const fn ident(&self) -> Option<&Ident> {
        self.talk.ident.as_ref()
    }

    /// CONFIG in force, once accepted.
    #[must_use]
    pub const fn in_force(&self) -> Option<&Config> {
        self.talk.in_force.as_ref()
    }

    /// Columns of the sample rows in force.
    #[must_use]
    pub const fn layout(&self) -> &Layout {
        &self.talk.layout
    }

    /// Clock relation, once a gripper answered.
    #[must_use]
    pub const fn clock(&self) -> Option<&ClockSync> {
        self.talk.clock.as_ref()
    }

    /// Forgets the relation of the clocks, because the gripper's clock has stopped or jumped, and asks for it again.
    pub fn resync(&mut self, now_us: u64) {
        self.talk.resync(now_us);
    }

    /// What the decoder counted since the link was made.
    #[must_use]
    pub const fn counters(&self) -> &Counters {
        self.decoder.counters()
    }

    /// Rows received and lost since the link opened.
    #[must_use]
    pub const fn loss(&self) -> LossCount {
        self.talk.rows.count()
    }

    /// Good frames with a malformed payload.
    #[must_use]
    pub const fn malformed(&self) -> u32 {
        self.talk.malformed
    }

    /// Good frames that nothing waited for: answers to no request, IDENT after the first, SAMPLES outside of STREAM and DEGRADED.
    #[must_use]
    pub const fn unexpected(&self) -> u32 {
        self.talk.unexpected
    }

    /// The GRIP sent last, as clamped.
    #[must_use]
    pub const fn last_grip(&self) -> Option<&Grip> {
        self.talk.last_grip.as_ref()
    }
}
