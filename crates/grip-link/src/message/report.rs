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
        48 sent: u32, "frames sent", "Sent.";
        52 dropped_batches: u32, "SAMPLES never sent", "Batches dropped.";
        56 dropped_rows: u32, "rows in them, the same number as `dropped_total` of SAMPLES; wraps", "Rows dropped.";
        60 malformed: u32, "good frames with a payload that cannot be read: too short, or a field outside its range; and HELLO with session 0", "Malformed.";
        64 old: u32, "GRIPs whose `cmd_id` is not newer than the newest: replayed, or out of order", "Ignored.";
        68 refused: u32, "requests that cannot be carried out: NACK LATCHED, WRONG_STATE, OTHER_FAULT, or a CONFIG that leaves no channel", "Refused.";
        72 unanswered: u32, "answers dropped because eight newer ones waited", "Unanswered.";
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
