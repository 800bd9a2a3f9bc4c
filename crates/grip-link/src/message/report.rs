//! STATS, EVENT and LOG: what the microcontroller has to report.

use super::FaultCode;
use super::wire::{PayloadError, Reader, Writer};
use super::{DeviceState, EventKind, LogLevel};
use crate::decoder::Counters;
use slip_msg::message;

message! {
    /// STATS (92), MCU to host, every second; all counts since the MCU started, saturating but for the rows dropped, which wrap.
    #[derive(Eq, Default)]
    Stats {
        0 received: Counters, "", "What the MCU's decoder counted.";
        48 sent: u32, "", "Frames sent.";
        52 dropped_batches: u32, "", "Batches dropped.";
        56 dropped_rows: u32, "wraps", "Rows dropped.";
        60 malformed: u32, "", "Good frames with a malformed payload.";
        64 old: u32, "", "GRIPs not newer than the newest one: ignored.";
        68 refused: u32, "", "Requests that could not be carried out: latched, wrong state, no channel left or another fault.";
        72 unanswered: u32, "", "Answers dropped because eight newer ones waited.";
    }
}

message! {
    /// EVENT (93), MCU to host.
    #[derive(Eq)]
    Event {
        0 tick: u64, "ticks", "When it happened.";
        8 kind: EventKind, "", "What happened.";
        9 before: DeviceState, "", "State before.";
        10 after: DeviceState, "", "State after.", reserved 1;
        12 fault: FaultCode, "", "Fault concerned.";
        14 dropped: u16, "since the start, wraps", "Events that found no room.";
        16 value: i32, "", "A number, by kind.";
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
