//! The state machine of the microcontroller's side.

use super::batches::Batches;
use super::force::{Drive, ForceGuard, Phase};
use super::outbox::Outbox;
use super::{DeviceConfig, DeviceConfigError, Latch};
use crate::decoder::{Counters, Decoder, Role};
use crate::frame::{Direction, Sender};
use crate::message::{
    Config, DeviceState, Event, EventKind, FaultCode, Grip, Heartbeat, Layout, Reaction,
    SampleFormat,
};
use core::num::NonZero;
use thiserror::Error;

/// What a received frame meant; the link has already acted on it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum DeviceEvent {
    /// A host opened this session.
    Linked {
        /// Session nonce.
        session: u16,
    },
    /// CONFIG was accepted, perhaps clamped: set the sampling up.
    Configured(Config),
    /// Begin to push rows.
    Started,
    /// Rows are no longer wanted.
    Stopped,
    /// A GRIP was accepted.
    Command(Grip),
    /// A GRIP was rejected.
    Rejected(Grip),
    /// Health of the host.
    Heartbeat(Heartbeat),
    /// ESTOP was latched.
    Estop,
    /// A fault was cleared.
    Cleared(FaultCode),
}

/// Why a row was not taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum RowError {
    /// Samples are not wanted now.
    #[error("sampling is not started")]
    NotSampling,
    /// CONFIG asked for the other format.
    #[error("rows are wanted as {wanted:?}")]
    Format {
        /// Format in force.
        wanted: SampleFormat,
    },
    /// The row has another number of elements than the channels of the mask.
    #[error("row of {got} elements, {need} are needed")]
    Elements {
        /// Elements of a row in force.
        need: usize,
        /// Elements given.
        got: usize,
    },
}

/// Tasks that have run since the watchdog was last fed: a bit set.
mod ran {
    pub(super) const CONTROL: u8 = 1;
    pub(super) const LINK: u8 = 2;
    pub(super) const SAMPLING: u8 = 4;
}

/// The microcontroller's end of the link: 4.3 KiB of memory, no allocation.
#[derive(Debug, Clone)]
pub struct DeviceLink {
    pub(super) config: DeviceConfig,
    pub(super) decoder: Decoder,
    pub(super) sender: Sender,
    pub(super) outbox: Outbox,
    pub(super) guard: ForceGuard,
    pub(super) batches: Batches,
    pub(super) layout: Layout,
    pub(super) state: DeviceState,
    pub(super) latch: Latch,
    pub(super) cleared: FaultCode,
    pub(super) in_force: Option<Config>,
    pub(super) sampling: bool,
    pub(super) ran: u8,
    pub(super) measured_mn: Option<i32>,
    pub(super) moving: Option<bool>,
    pub(super) status_due: u64,
    pub(super) stats_due: u64,
    pub(super) announce_due: u64,
    pub(super) samples_next: bool,
    pub(super) dropped_seen: u32,
    pub(super) rejected: u16,
    pub(super) malformed: u32,
    pub(super) old: u32,
    pub(super) refused: u32,
}

impl DeviceLink {
    /// A link in state BOOT: passive, and deaf until [`DeviceLink::ready`].
    ///
    /// # Errors
    /// [`DeviceConfigError`] with the numbers that cannot be.
    pub fn new(config: DeviceConfig) -> Result<Self, DeviceConfigError> {
        config.check()?;
        let tick_hz = NonZero::new(u64::from(config.ident.tick_hz))
            .ok_or(DeviceConfigError::TickRate { tick_hz: 0 })?;
        Ok(Self {
            config,
            decoder: Decoder::new(Role::Device),
            sender: Sender::new(Direction::ToHost),
            outbox: Outbox::new(),
            guard: ForceGuard::new(tick_hz, &config.ident.limits),
            batches: Batches::new(),
            layout: Layout::EMPTY,
            state: DeviceState::Boot,
            latch: Latch::CLEAR,
            cleared: FaultCode::NONE,
            in_force: None,
            sampling: false,
            ran: 0,
            measured_mn: None,
            moving: None,
            status_due: 0,
            stats_due: 0,
            announce_due: 0,
            samples_next: false,
            dropped_seen: 0,
            rejected: 0,
            malformed: 0,
            old: 0,
            refused: 0,
        })
    }

    /// Self-tests are over: BOOT -> IDLE.
    pub fn ready(&mut self, tick: u64) {
        if self.state == DeviceState::Boot {
            self.enter(tick, DeviceState::Idle);
        }
    }

    /// State now.
    #[must_use]
    pub const fn state(&self) -> DeviceState {
        self.state
    }

    /// Latched fault; ESTOP comes first.
    #[must_use]
    pub const fn fault(&self) -> FaultCode {
        self.latch.code()
    }

    /// What the decoder counted.
    #[must_use]
    pub const fn counters(&self) -> &Counters {
        self.decoder.counters()
    }

    /// CONFIG in force.
    #[must_use]
    pub const fn in_force(&self) -> Option<&Config> {
        self.in_force.as_ref()
    }

    /// Rows dropped since the start because nothing could be sent.
    #[must_use]
    pub const fn dropped_rows(&self) -> u32 {
        self.batches.dropped_rows()
    }

    /// Takes bytes off `input` up to the next event; `None` when they are used up. Call it again until then.
    pub fn receive(&mut self, tick: u64, input: &mut &[u8]) -> Option<DeviceEvent> {
        self.ran |= ran::LINK;
        self.step(tick);
        loop {
            let verdict = self.decoder.advance(input)?;
            if self.state == DeviceState::Boot {
                continue;
            }
            let event = match verdict {
                Ok(()) => self.on_frame(tick),
                Err(fault) => self.on_fault(tick, fault),
            };
            if event.is_some() {
                return event;
            }
        }
    }

    /// The fingers press with this force \[mN\] already, as a drive does that kept its grip while this program was started: what is held
    /// is not let go. Before the first frame of a host.
    pub fn resume(&mut self, force_mn: i32) {
        self.guard.resume(force_mn);
    }

    /// Latches a fault of the firmware: minor ones hold, all others take the torque off (R6 to R8).
    pub fn raise_fault(&mut self, tick: u64, fault: FaultCode) {
        if !fault.is_fault() || fault == FaultCode::ESTOP {
            return;
        }
        let worse =
            fault.reaction() == Reaction::Passive && self.latch.fault.reaction() == Reaction::Hold;
        if !self.latch.fault.is_fault() || worse {
            self.latch.fault = fault;
        }
        self.cleared = FaultCode::NONE;
        self.react(fault.reaction());
        let before = self.state;
        self.enter(tick, self.latch.state().unwrap_or(before));
        self.note(tick, EventKind::Fault, before, i32::from(fault.0));
    }

    /// Latches a stop, as ESTOP of the host does.
    pub fn estop(&mut self, tick: u64) {
        self.latch.estop = true;
        self.cleared = FaultCode::NONE;
        self.react(self.config.estop);
        self.enter(tick, DeviceState::Estop);
    }

    fn react(&mut self, reaction: Reaction) {
        match reaction {
            Reaction::Hold => self.guard.freeze(),
            Reaction::Passive => self.guard.release(),
        }
    }

    /// Finger position \[um\]: outside the travel of IDENT the force does not rise.
    pub fn report_travel(&mut self, position_um: i32) {
        let limits = self.config.ident.limits;
        self.guard
            .set_travel_end(!(limits.travel_min_um..=limits.travel_max_um).contains(&position_um));
    }

    /// Measured grip force \[mN\] for STATUS; without it STATUS shows the force set.
    pub const fn report_force(&mut self, force_mn: i32) {
        self.measured_mn = Some(force_mn);
    }

    /// Whether the fingers travel freely or the arm is known to move, for STATUS; until the first report STATUS shows nothing about
    /// motion. Fingers that press on something do not move, however the force changes: a host detects less well in motion.
    pub fn report_motion(&mut self, tick: u64, moving: bool) {
        if self.moving.replace(moving) != Some(moving) {
            self.status_due = tick;
        }
    }

    /// What the actuator is to do at this tick.
    pub fn drive(&mut self, tick: u64) -> Drive {
        self.ran |= ran::CONTROL;
        self.step(tick)
    }

    /// Whether control, link and (while started) sampling all ran since the last call: feed the watchdog then only (R9).
    pub fn take_alive(&mut self) -> bool {
        let needed = ran::CONTROL | ran::LINK | if self.sampling { ran::SAMPLING } else { 0 };
        let alive = self.ran & needed == needed;
        if alive {
            self.ran = 0;
        }
        alive
    }

    /// Appends a row of i16 values; -32768 means no reading.
    ///
    /// # Errors
    /// [`RowError`] when samples are not wanted like this.
    pub fn push_i16(&mut self, tick: u64, row: &[i16]) -> Result<(), RowError> {
        self.check_row(SampleFormat::I16, row.len())?;
        self.batches.push(tick, row.iter().flat_map(|value| value.to_le_bytes()));
        Ok(())
    }

    /// Appends a row of f32 values in their units; NaN means no reading.
    ///
    /// # Errors
    /// [`RowError`] when samples are not wanted like this.
    pub fn push_f32(&mut self, tick: u64, row: &[f32]) -> Result<(), RowError> {
        self.check_row(SampleFormat::F32, row.len())?;
        self.batches.push(tick, row.iter().flat_map(|value| value.to_le_bytes()));
        Ok(())
    }

    /// Ends the batch that is being filled, for rows that come in bursts: what is there does not wait for the next row.
    pub fn flush_rows(&mut self) {
        self.batches.flush();
    }

    /// Counts rows that were lost before they came here, so that the host sees by the row numbers that they are missing.
    pub fn skip_rows(&mut self, rows: u32) {
        self.batches.skip(rows);
    }

    fn check_row(&mut self, format: SampleFormat, got: usize) -> Result<(), RowError> {
        self.ran |= ran::SAMPLING;
        if !self.sampling {
            return Err(RowError::NotSampling);
        }
        let wanted = self.batches.format();
        if format != wanted {
            return Err(RowError::Format { wanted });
        }
        let need = self.batches.row_bytes() / format.size();
        if got == need { Ok(()) } else { Err(RowError::Elements { need, got }) }
    }

    pub(super) const fn ticks(&self, ms: u64) -> u64 {
        self.config.ident.tick_hz as u64 * ms / 1000
    }

    pub(super) fn step(&mut self, tick: u64) -> Drive {
        let drive = self.guard.advance(tick);
        let next = match (self.guard.phase(), self.state) {
            (Phase::Hold { .. }, DeviceState::Active) => Some(DeviceState::Hold),
            (
                Phase::Lost,
                DeviceState::Active | DeviceState::Hold | DeviceState::Armed | DeviceState::Linked,
            ) => Some(DeviceState::LossAction),
            _ => None,
        };
        if let Some(state) = next {
            self.enter(tick, state);
            if state == DeviceState::LossAction {
                self.guard.settle();
            }
        }
        drive
    }

    pub(super) fn enter(&mut self, tick: u64, state: DeviceState) {
        let before = self.state;
        if before != state {
            self.state = state;
            self.status_due = tick;
            self.note(tick, EventKind::State, before, 0);
        }
    }

    pub(super) fn note(&mut self, tick: u64, kind: EventKind, before: DeviceState, value: i32) {
        let fault = self.latch.code();
        self.outbox.events.push(Event {
            tick,
            kind,
            before,
            after: self.state,
            fault,
            dropped: 0,
            value,
        });
    }
}
