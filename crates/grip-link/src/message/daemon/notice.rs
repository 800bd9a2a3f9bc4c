//! NOTICE: something a client should know, in a code for programs and a text for people.

use super::NoticeKind;
use crate::message::wire::{PayloadError, Reader, Writer};

/// NOTICE (A6), daemon to client.
///
/// | offset | size | type | field | unit |
/// |---|---|---|---|---|
/// | 0 | 1 | u8 | [`NoticeKind`] code | |
/// | 1 | 1 | u8 | code, by kind | |
/// | 2 | 2 | u16 | value, by kind | |
/// | 4 | 4 | u32 | count, by kind | |
/// | 8 | 8 | u64 | host time since the daemon's start | us |
/// | 16 | 1 | u8 | bytes of text m | |
/// | 17 | m | u8\[m\] | text, UTF-8 | |
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Notice<'a> {
    /// What it is about.
    pub kind: NoticeKind,
    /// By kind: dropped class, sensor, link state, operation, reason.
    pub code: u8,
    /// By kind: health of the sensor, fault.
    pub value: u16,
    /// By kind: frames dropped since the last NOTICE of this class.
    pub count: u32,
    /// Host time (us since the daemon's start).
    pub host_us: u64,
    /// What people read; at most 255 bytes are sent.
    pub text: &'a [u8],
}

impl<'a> Notice<'a> {
    /// Bytes before the text.
    pub const HEADER: usize = 17;

    /// Reads a payload.
    ///
    /// # Errors
    /// [`PayloadError::Short`].
    pub fn parse(payload: &'a [u8]) -> Result<Self, PayloadError> {
        let mut r = Reader::new(payload);
        Ok(Self {
            kind: NoticeKind::from_code(r.u8()?),
            code: r.u8()?,
            value: r.u16()?,
            count: r.u32()?,
            host_us: r.u64()?,
            text: r.text()?,
        })
    }

    /// Writes the payload; its length.
    ///
    /// # Errors
    /// [`PayloadError::Full`].
    pub fn write(&self, out: &mut [u8]) -> Result<usize, PayloadError> {
        let w = Writer::new(out).u8(self.kind.code()).u8(self.code).u16(self.value);
        w.u32(self.count).u64(self.host_us).text(self.text).finish()
    }

    /// The text up to the first byte that is not UTF-8.
    #[must_use]
    pub fn as_str(&self) -> &'a str {
        super::readable(self.text)
    }
}
