//! STATS, EVENT and LOG: what the microcontroller has to tell.

use super::FaultCode;
use super::wire::{PayloadError, Reader, Writer};
use super::{EventKind, LogLevel};
use crate::decoder::Counters;

/// STATS (92), MCU to host, every second; all counts since the MCU started, saturating but for the rows dropped, which wrap.
///
/// | offset | size | type | field |
/// |---|---|---|---|
/// | 0 | 4 | u32 | good frames received |
/// | 4 | 4 | u32 | blocks too long |
/// | 8 | 4 | u32 | blocks that are not COBS |
/// | 12 | 4 | u32 | blocks with a wrong length |
/// | 16 | 4 | u32 | blocks with a wrong CRC |
/// | 20 | 4 | u32 | echoes |
/// | 24 | 4 | u32 | frames of another version |
/// | 28 | 4 | u32 | frames of another session |
/// | 32 | 4 | u32 | duplicates |
/// | 36 | 4 | u32 | frames of unknown type |
/// | 40 | 4 | u32 | frames missing |
/// | 44 | 4 | u32 | bytes in bad blocks |
/// | 48 | 4 | u32 | frames sent |
/// | 52 | 4 | u32 | batches dropped |
/// | 56 | 4 | u32 | rows dropped |
/// | 60 | 4 | u32 | good frames with a malformed payload |
/// | 64 | 4 | u32 | GRIPs not newer than the newest one |
/// | 68 | 4 | u32 | requests that could not be carried out |
/// | 72 | 4 | u32 | answers dropped because too many waited |
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Stats {
    /// What the MCU's decoder counted.
    pub received: Counters,
    /// Frames sent.
    pub sent: u32,
    /// Batches dropped.
    pub dropped_batches: u32,
    /// Rows dropped.
    pub dropped_rows: u32,
    /// Good frames with a malformed payload.
    pub malformed: u32,
    /// GRIPs not newer than the newest one: ignored.
    pub old: u32,
    /// Requests that could not be carried out: latched, wrong state, no channel left or another fault.
    pub refused: u32,
    /// Answers dropped because eight newer ones waited.
    pub unanswered: u32,
}

impl Stats {
    /// Bytes of the payload.
    pub const SIZE: usize = 76;

    /// Reads a payload.
    ///
    /// # Errors
    /// [`PayloadError::Short`].
    pub fn parse(payload: &[u8]) -> Result<Self, PayloadError> {
        let mut r = Reader::new(payload);
        let received = Counters {
            ok: r.u32()?,
            too_long: r.u32()?,
            cobs: r.u32()?,
            length: r.u32()?,
            crc: r.u32()?,
            echo: r.u32()?,
            version: r.u32()?,
            stale: r.u32()?,
            duplicate: r.u32()?,
            unknown: r.u32()?,
            gap: r.u32()?,
            garbage_bytes: r.u32()?,
        };
        let [sent, dropped_batches, dropped_rows, malformed] =
            [r.u32()?, r.u32()?, r.u32()?, r.u32()?];
        let [old, refused, unanswered] = [r.u32()?, r.u32()?, r.u32()?];
        Ok(Self {
            received,
            sent,
            dropped_batches,
            dropped_rows,
            malformed,
            old,
            refused,
            unanswered,
        })
    }

    /// Writes the payload; its length.
    ///
    /// # Errors
    /// [`PayloadError::Full`].
    pub fn write(&self, out: &mut [u8]) -> Result<usize, PayloadError> {
        let c = self.received;
        let w = Writer::new(out)
            .u32(c.ok)
            .u32(c.too_long)
            .u32(c.cobs)
            .u32(c.length)
            .u32(c.crc)
            .u32(c.echo);
        let w = w
            .u32(c.version)
            .u32(c.stale)
            .u32(c.duplicate)
            .u32(c.unknown)
            .u32(c.gap)
            .u32(c.garbage_bytes);
        w.u32(self.sent)
            .u32(self.dropped_batches)
            .u32(self.dropped_rows)
            .u32(self.malformed)
            .u32(self.old)
            .u32(self.refused)
            .u32(self.unanswered)
            .finish()
    }
}

/// EVENT (93), MCU to host.
///
/// | offset | size | type | field |
/// |---|---|---|---|
/// | 0 | 8 | u64 | tick of the event |
/// | 8 | 1 | u8 | kind: [`EventKind`] code |
/// | 9 | 1 | u8 | state before: [`DeviceState`](super::DeviceState) code |
/// | 10 | 1 | u8 | state after |
/// | 11 | 1 | | reserved, 0 |
/// | 12 | 2 | u16 | fault |
/// | 14 | 2 | u16 | events dropped since the start, wraps |
/// | 16 | 4 | i32 | value, by kind |
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Event {
    /// Tick of the event.
    pub tick: u64,
    /// What happened.
    pub kind: EventKind,
    /// State before.
    pub before: super::DeviceState,
    /// State after.
    pub after: super::DeviceState,
    /// Fault concerned.
    pub fault: FaultCode,
    /// Events that found no room.
    pub dropped: u16,
    /// A number, by kind.
    pub value: i32,
}

impl Event {
    /// Bytes of the payload.
    pub const SIZE: usize = 20;

    /// Reads a payload.
    ///
    /// # Errors
    /// [`PayloadError::Short`].
    pub fn parse(payload: &[u8]) -> Result<Self, PayloadError> {
        let mut r = Reader::new(payload);
        let tick = r.u64()?;
        let [kind, before, after, _] = r.take()?;
        Ok(Self {
            tick,
            kind: EventKind::from_code(kind),
            before: super::DeviceState::from_code(before),
            after: super::DeviceState::from_code(after),
            fault: FaultCode(r.u16()?),
            dropped: r.u16()?,
            value: r.i32()?,
        })
    }

    /// Writes the payload; its length.
    ///
    /// # Errors
    /// [`PayloadError::Full`].
    pub fn write(&self, out: &mut [u8]) -> Result<usize, PayloadError> {
        let w = Writer::new(out).u64(self.tick).u8(self.kind.code());
        let w = w.u8(self.before.code()).u8(self.after.code()).u8(0);
        w.u16(self.fault.0).u16(self.dropped).i32(self.value).finish()
    }
}

/// LOG (94), MCU to host.
///
/// | offset | size | type | field |
/// |---|---|---|---|
/// | 0 | 8 | u64 | tick |
/// | 8 | 1 | u8 | level: [`LogLevel`] code |
/// | 9 | 1 | u8 | bytes of text m, 0..=255 |
/// | 10 | m | u8\[m\] | text, UTF-8 |
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Log<'a> {
    /// Tick.
    pub tick: u64,
    /// Weight.
    pub level: LogLevel,
    /// Text; should be UTF-8, at most 255 bytes.
    pub text: &'a [u8],
}

impl<'a> Log<'a> {
    /// Reads a payload.
    ///
    /// # Errors
    /// [`PayloadError::Short`].
    pub fn parse(payload: &'a [u8]) -> Result<Self, PayloadError> {
        let mut r = Reader::new(payload);
        let tick = r.u64()?;
        let level = LogLevel::from_code(r.u8()?);
        let len = r.u8()?;
        Ok(Self { tick, level, text: r.slice(usize::from(len))? })
    }

    /// Writes the payload; its length.
    ///
    /// # Errors
    /// [`PayloadError`]: `Full`, or `Value` for a text over 255 bytes.
    pub fn write(&self, out: &mut [u8]) -> Result<usize, PayloadError> {
        let len = u8::try_from(self.text.len());
        let len = len.map_err(|_| PayloadError::Value {
            at: 9,
            value: i64::try_from(self.text.len()).unwrap_or(i64::MAX),
        })?;
        Writer::new(out).u64(self.tick).u8(self.level.code()).u8(len).put(self.text).finish()
    }

    /// The text up to the first byte that is not UTF-8.
    #[must_use]
    pub fn as_str(&self) -> &'a str {
        self.text.utf8_chunks().next().map_or("", |chunk| chunk.valid())
    }
}
