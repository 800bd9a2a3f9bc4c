//! NOTICE: something a client should know, in a code for programs and a text for people.

use super::NoticeKind;
use slip_msg::message;

message! {
    /// NOTICE (A6), daemon to client.
    #[derive(Eq)]
    Notice<'a> {
        0 kind: NoticeKind, "notice kind", "What it is about.";
        1 code: u8, "by kind", "By kind: dropped class, sensor, link state, operation, reason.";
        2 value: u16, "by kind", "By kind: health of the sensor, fault.";
        4 count: u32, "of DROPPED: frames since the last one of this class", "By kind: frames dropped since the last NOTICE of this class.";
        8 host_us: u64, "us since the daemon's start", "Host time since the daemon's start.";
        16 text: &'a [u8], "for people, UTF-8", "What people read; at most 255 bytes are sent.";
    }
}

impl<'a> Notice<'a> {
    /// The text up to the first byte that is not UTF-8.
    #[must_use]
    pub fn as_str(&self) -> &'a str {
        super::readable(self.text)
    }
}
