//! An open line that takes frames and gives bytes of the gripper. On Linux it never waits longer than it is asked to, and allocates nothing; what
//! is promised of other systems stands in the module `elsewhere`.
//!
//! What the system does not take of a frame is kept, one frame at most, and goes on before anything else, so that frames are never
//! mixed.

use crate::{PortError, system::Wire};
use core::{
    hash::{BuildHasher as _, Hasher as _},
    time::Duration,
};
use grip_link::frame::MAX_WIRE;
use std::collections::hash_map::RandomState;

/// What stands between this program and the gripper.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LineKind {
    /// A gripper that is a USB serial device itself (ttyACM): as fast as USB, whatever the baud rate states.
    UsbDevice,
    /// A UART, on this computer or behind a USB converter: the baud rate is its speed.
    Uart,
    /// A pseudo-terminal: as fast as the processor.
    Pty,
    /// A socket or pipe, for benches and tests.
    Socket,
}

/// What became of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Written {
    /// The system has taken all of it.
    Whole,
    /// The system has taken its beginning; the rest is kept and goes on by itself.
    Begun,
    /// The line is full: the command is kept and goes out next, unless a newer one takes its place.
    Waiting,
    /// The line is full, or the frame is longer than any of the protocol: nothing of it will go out.
    Refused,
}

/// What did not go smoothly on a line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LineCounters {
    /// Frames of which the system took only the beginning at first.
    pub begun: u64,
    /// Commands that were replaced by a newer one before their first byte went out.
    pub replaced: u64,
    /// Frames that were refused.
    pub refused: u64,
}

/// An open line that this process alone holds.
#[derive(Debug)]
pub struct Line {
    wire: Wire,
    kind: LineKind,
    baud: u32,
    latency_timer_ms: Option<u16>,
    rest: Kept,
    waiting: Kept,
    counters: LineCounters,
}

/// What is known of a line once it is set up.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Setup {
    pub(crate) kind: LineKind,
    pub(crate) baud: u32,
    pub(crate) latency_timer_ms: Option<u16>,
}

/// What a wait ended with.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Ready {
    /// Bytes may be read.
    pub(crate) read: bool,
    /// Bytes may be written.
    pub(crate) write: bool,
    /// The other end is gone.
    pub(crate) gone: bool,
}

impl Line {
    pub(crate) fn new(wire: Wire, setup: Setup) -> Self {
        let Setup { kind, baud, latency_timer_ms } = setup;
        Self {
            wire,
            kind,
            baud,
            latency_timer_ms,
            rest: Kept::EMPTY,
            waiting: Kept::EMPTY,
            counters: LineCounters::default(),
        }
    }

    /// Reads what has come into `input`: its length, 0 where nothing came within `timeout` or the wait ended early. Meanwhile what is kept
    /// of earlier frames goes out as soon as the line takes it. Allocates nothing.
    ///
    /// # Errors
    /// [`PortError::Closed`] where the other end is gone; the line must then be dropped at once, or the device comes back under another
    /// name. [`PortError::Read`] or [`PortError::Write`] for anything else.
    pub fn read(&mut self, input: &mut [u8], timeout: Duration) -> Result<usize, PortError> {
        let ready = self.wire.wait(timeout, !self.is_clear())?;
        if ready.write {
            self.resume()?;
        }
        if ready.read && input.is_empty() {
            return Ok(0);
        }
        if ready.read {
            return self.wire.take(input);
        }
        if ready.gone { Err(PortError::Closed) } else { Ok(0) }
    }

    /// Writes a frame with one write, on Linux without waiting. A frame that cannot be begun because the line is full is refused and counted:
    /// requests are repeated by the link. Allocates nothing.
    ///
    /// # Errors
    /// As [`Line::read`].
    pub fn write_frame(&mut self, frame: &[u8]) -> Result<Written, PortError> {
        self.resume()?;
        let written = if self.is_clear() && frame.len() <= MAX_WIRE {
            self.begin(frame)?
        } else {
            Written::Refused
        };
        self.counters.refused += u64::from(written == Written::Refused);
        Ok(written)
    }

    /// Writes a force command, of which only the newest matters: where the line is full it is kept, and takes the place of one that is
    /// kept already. Allocates nothing.
    ///
    /// # Errors
    /// As [`Line::read`].
    pub fn write_command(&mut self, frame: &[u8]) -> Result<Written, PortError> {
        if frame.len() > MAX_WIRE {
            self.counters.refused += 1;
            return Ok(Written::Refused);
        }
        // A command that still waits is older than this one.
        self.counters.replaced += u64::from(!self.waiting.is_empty());
        self.waiting = Kept::EMPTY;
        self.resume()?;
        let written = if self.is_clear() { self.begin(frame)? } else { Written::Refused };
        if written == Written::Refused {
            self.waiting.keep(frame);
            return Ok(Written::Waiting);
        }
        Ok(written)
    }

    /// Goes on with the frame that was begun, then with the command that waits.
    fn resume(&mut self) -> Result<(), PortError> {
        if !self.rest.is_empty() {
            let taken = self.wire.push(self.rest.bytes())?;
            self.rest.start += taken;
        }
        if self.rest.is_empty() && !self.waiting.is_empty() {
            let command = core::mem::replace(&mut self.waiting, Kept::EMPTY);
            if self.begin(command.bytes())? == Written::Refused {
                self.waiting = command;
            }
        }
        Ok(())
    }

    /// Writes to a line on which nothing is kept.
    fn begin(&mut self, frame: &[u8]) -> Result<Written, PortError> {
        let taken = self.wire.push(frame)?;
        if taken >= frame.len() {
            return Ok(Written::Whole);
        }
        if taken == 0 {
            return Ok(Written::Refused);
        }
        self.rest.keep(frame.get(taken..).unwrap_or(&[]));
        self.counters.begun += 1;
        Ok(Written::Begun)
    }

    /// Whether nothing is kept: neither the rest of a frame nor a command.
    #[must_use]
    pub fn is_clear(&self) -> bool {
        self.rest.is_empty() && self.waiting.is_empty()
    }

    #[cfg(target_os = "linux")]
    pub(crate) fn wire(&self) -> &Wire {
        &self.wire
    }

    /// What did not go smoothly so far.
    #[must_use]
    pub fn counters(&self) -> LineCounters {
        self.counters
    }

    /// What kind of line this is.
    #[must_use]
    pub fn kind(&self) -> LineKind {
        self.kind
    }

    /// How long an FTDI converter holds bytes back (ms), read back after setting it to 1; `None` on anything else. More than 1 delays
    /// the answer to a slip by as much.
    #[must_use]
    pub fn latency_timer_ms(&self) -> Option<u16> {
        self.latency_timer_ms
    }

    /// The least time between two commands of `wire_bytes` (us), so that they take at most half of the line; 0 where the baud rate means
    /// nothing.
    #[must_use]
    pub fn least_interval_us(&self, wire_bytes: usize) -> u64 {
        match self.kind {
            LineKind::Uart => least_interval_us(self.baud, wire_bytes),
            LineKind::UsbDevice | LineKind::Pty | LineKind::Socket => 0,
        }
    }
}

/// The least time between frames of `wire_bytes` (us) that leaves half of a line of `baud` bits per second free; a byte takes ten bits.
#[must_use]
pub fn least_interval_us(baud: u32, wire_bytes: usize) -> u64 {
    let bits = u64::try_from(wire_bytes).unwrap_or(u64::MAX).saturating_mul(10);
    bits.saturating_mul(2_000_000).div_ceil(u64::from(baud.max(1)))
}

/// A session number that differs from start to start, never 0.
#[must_use]
pub fn nonce() -> u16 {
    let random = RandomState::new().build_hasher().finish();
    u16::try_from(random % 0xFFFF).unwrap_or(0) + 1
}

/// Bytes that the system has not taken yet.
#[derive(Clone, Copy, Debug)]
struct Kept {
    bytes: [u8; MAX_WIRE],
    start: usize,
    end: usize,
}

impl Kept {
    const EMPTY: Self = Self { bytes: [0; MAX_WIRE], start: 0, end: 0 };

    fn is_empty(&self) -> bool {
        self.start >= self.end
    }

    fn bytes(&self) -> &[u8] {
        self.bytes.get(self.start..self.end).unwrap_or(&[])
    }

    fn keep(&mut self, bytes: &[u8]) {
        for (to, from) in self.bytes.iter_mut().zip(bytes) {
            *to = *from;
        }
        (self.start, self.end) = (0, bytes.len().min(MAX_WIRE));
    }
}

#[cfg(test)]
#[cfg(target_os = "linux")]
mod tests;
