//! STATS, EVENT and LOG: what the microcontroller has to report.

use super::FaultCode;
use super::{DeviceState, EventKind, LogLevel};
use crate::decoder::Counters;
use slip_msg::message;

message! {
    /// STATS (92), MCU to host, every second; all counts since the MCU started, saturating but for the rows dropped, which wrap.
    #[derive(Eq, Default)]
    Stats {
        0 received: Counters, "", "What the MCU's decoder counted.";
        48 sent: u32, "frames", "Frames sent.";
        52 dropped_batches: u32, "batches", "Batches dropped.";
        56 dropped_rows: u32, "rows", "Rows dropped.";
        60 malformed: u32, "frames", "Good frames with a malformed payload.";
        64 old: u32, "frames", "GRIPs not newer than the newest one: ignored.";
        68 refused: u32, "frames", "Requests that could not be carried out: latched, wrong state, no channel left or another fault.";
        72 unanswered: u32, "answers", "Answers dropped because eight newer ones waited.";
    }
}

message! {
    /// EVENT (93), MCU to host.
    #[derive(Eq)]
    Event {
        0 tick: u64, "when it happened", "When it happened.";
        8 kind: EventKind, "event kind", "What happened.";
        9 before: DeviceState, "device state before", "State before.";
        10 after: DeviceState, "device state after", "State after.", reserved 1;
        12 fault: FaultCode, "fault latched after the event, as in STATUS", "Fault concerned.";
        14 dropped: u16, "events dropped since the start, wraps", "Events that found no room.";
        16 value: i32, "by kind", "A number, by kind.";
    }
}

message! {
    /// LOG (94), MCU to host.
    #[derive(Eq)]
    Log<'a> {
        0 tick: u64, "when it was written", "When it was written.";
        8 level: LogLevel, "log level", "Weight.";
        9 text: &'a [u8], "UTF-8; a reader shows it up to the first byte that is not; fewer than m bytes are malformed", "Text; should be UTF-8; at most 255 bytes are sent.";
    }
}

impl<'a> Log<'a> {
    /// The text up to the first byte that is not UTF-8.
    #[must_use]
    pub fn as_str(&self) -> &'a str {
        self.text.utf8_chunks().next().map_or("", |chunk| chunk.valid())
    }
}
