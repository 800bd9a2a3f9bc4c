//! Frames: wire bytes `00 | COBS(body) | 00` of header and payload; the view of a received frame; the numbering of sent ones.
//!
//! | offset | size | type | field | range |
//! |---|---|---|---|---|
//! | 0 | 1 | u8 | version in bits 4-7, flags in bits 0-3 | version 1; b0 direction (1 = MCU to host), b1 ACK_REQ, b2 b3 sent as 0, ignored |
//! | 1 | 1 | u8 | type | [`Kind`] |
//! | 2 | 2 | u16 | seq | one counter a direction, +1 every frame sent, wraps |
//! | 4 | 2 | u16 | session | host nonce from HELLO, 1..=65535; 0 = no session |
//! | 6 | 2 | u16 | len | payload bytes, 0..=480 |
//! | 8 | len | | payload | |
//! | 8 + len | 4 | u32 | CRC-32C of bytes 0 .. 8 + len | |
//!
//! All integers are little-endian. HELLO and IDENT keep this header and their first two payload bytes in
//! every version, so that two programs that share no version can still report it.

use crate::PROTOCOL;
use crate::cobs;
use crate::crc;
use crate::kind::Kind;
use slip_msg::PayloadError;
use thiserror::Error;

/// Most payload bytes in a frame.
pub const MAX_PAYLOAD: usize = 480;
/// Bytes of the header.
pub const HEADER: usize = 8;
/// Bytes a frame body has beside its payload: header and CRC.
pub const OVERHEAD: usize = HEADER + 4;
/// Most bytes of a COBS block that can hold a frame.
pub const MAX_BLOCK: usize = cobs::max_encoded(MAX_PAYLOAD + OVERHEAD);
/// Most bytes of a frame on the wire, delimiters included.
pub const MAX_WIRE: usize = MAX_BLOCK + 2;

/// Way of a frame: bit 0 of the first byte.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Direction {
    /// Host to microcontroller: bit clear.
    ToDevice,
    /// Microcontroller to host: bit set.
    ToHost,
}

/// The first eight bytes of a body, without the length.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Header {
    /// Protocol version, 0..=15.
    pub version: u8,
    /// Way of the frame.
    pub direction: Direction,
    /// The sender wants an ACK or NACK.
    pub ack_req: bool,
    /// Message type.
    pub kind: Kind,
    /// Sender's frame count, wrapping.
    pub seq: u16,
    /// Session nonce; 0 = none.
    pub session: u16,
}

impl Header {
    /// A header of the present version without ACK_REQ.
    #[must_use]
    pub const fn new(direction: Direction, kind: Kind, seq: u16, session: u16) -> Self {
        Self { version: PROTOCOL, direction, ack_req: false, kind, seq, session }
    }

    fn to_bytes(self, len: u16) -> [u8; HEADER] {
        let direction = u8::from(self.direction == Direction::ToHost);
        let first = (self.version << 4) | direction | (u8::from(self.ack_req) << 1);
        let [seq0, seq1] = self.seq.to_le_bytes();
        let [session0, session1] = self.session.to_le_bytes();
        let [len0, len1] = len.to_le_bytes();
        [first, self.kind.0, seq0, seq1, session0, session1, len0, len1]
    }

    fn from_bytes(bytes: [u8; HEADER]) -> (Self, u16) {
        let [first, kind, seq0, seq1, session0, session1, len0, len1] = bytes;
        let header = Self {
            version: first >> 4,
            direction: if first & 1 == 1 { Direction::ToHost } else { Direction::ToDevice },
            ack_req: first & 2 == 2,
            kind: Kind(kind),
            seq: u16::from_le_bytes([seq0, seq1]),
            session: u16::from_le_bytes([session0, session1]),
        };
        (header, u16::from_le_bytes([len0, len1]))
    }
}

/// A received frame; the payload is borrowed from the decoder.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Frame<'a> {
    /// Header fields.
    pub header: Header,
    /// 0..=480 payload bytes.
    pub payload: &'a [u8],
}

/// Why a decoded body is no frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum BodyError {
    /// Shorter than header and CRC, longer than the largest frame, or `len` disagrees.
    #[error("body of {got} bytes does not match its length field")]
    Length {
        /// Bytes of the body.
        got: usize,
    },
    /// The checksum disagrees.
    #[error("checksum {got:08x} in the frame, {computed:08x} computed")]
    Crc {
        /// Checksum found in the frame.
        got: u32,
        /// Checksum of what was received.
        computed: u32,
    },
}

impl<'a> Frame<'a> {
    /// Checks length, then CRC, of a decoded body.
    ///
    /// # Errors
    /// [`BodyError`] with the disagreeing numbers.
    pub fn from_body(body: &'a [u8]) -> Result<Self, BodyError> {
        let short = BodyError::Length { got: body.len() };
        let (covered, crc) = body.split_last_chunk::<4>().ok_or(short)?;
        let (head, payload) = covered.split_first_chunk::<HEADER>().ok_or(short)?;
        let (header, len) = Header::from_bytes(*head);
        if usize::from(len) != payload.len() || payload.len() > MAX_PAYLOAD {
            return Err(short);
        }
        let got = u32::from_le_bytes(*crc);
        let computed = crc::crc32c(covered);
        if got == computed {
            Ok(Self { header, payload })
        } else {
            Err(BodyError::Crc { got, computed })
        }
    }
}

/// Why a frame could not be written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum EncodeError {
    /// More than 480 payload bytes.
    #[error("payload of {len} bytes, at most 480 fit")]
    Payload {
        /// Bytes given.
        len: usize,
    },
    /// The output cannot hold the frame.
    #[error("output of {len} bytes is too short for the frame")]
    Output {
        /// Bytes of room.
        len: usize,
    },
    /// A version above 15 does not fit its four bits.
    #[error("version {version} does not fit four bits")]
    Version {
        /// Version given.
        version: u8,
    },
}

/// Writes `00 | COBS(body) | 00` to the start of `out` and returns its length; [`MAX_WIRE`] bytes always suffice.
///
/// # Errors
/// [`EncodeError`] when payload, version or output do not fit.
pub fn encode(header: &Header, payload: &[u8], out: &mut [u8]) -> Result<usize, EncodeError> {
    let len = payload.len();
    let short = EncodeError::Output { len: out.len() };
    if len > MAX_PAYLOAD {
        return Err(EncodeError::Payload { len });
    }
    if header.version > 15 {
        return Err(EncodeError::Version { version: header.version });
    }
    let count = u16::try_from(len).map_err(|_| EncodeError::Payload { len })?;
    let head = header.to_bytes(count);
    let crc = crc::of_parts([&head, payload]);
    let (open, rest) = out.split_first_mut().ok_or(short)?;
    let mut block = cobs::Encoder::new(rest);
    block.push(&head);
    block.push(payload);
    block.push(&crc.to_le_bytes());
    let end = block.finish().ok_or(short)?;
    *open = 0;
    *rest.get_mut(end).ok_or(short)? = 0;
    Ok(end + 2)
}

/// Counts and addresses outgoing frames.
#[derive(Debug, Clone)]
pub(crate) struct Sender {
    direction: Direction,
    seq: u16,
    sent: u32,
    /// Session written into frames.
    pub(crate) session: u16,
}

impl Sender {
    pub(crate) const fn new(direction: Direction) -> Self {
        Self { direction, seq: 0, sent: 0, session: 0 }
    }

    /// Number that the next frame gets.
    pub(crate) const fn next_seq(&self) -> u16 {
        self.seq
    }

    pub(crate) const fn sent(&self) -> u32 {
        self.sent
    }

    /// Writes a frame; `None`, and no number used, when it does not fit `out`.
    pub(crate) fn send(
        &mut self,
        kind: Kind,
        ack_req: bool,
        payload: &[u8],
        out: &mut [u8],
    ) -> Option<usize> {
        let header =
            Header { ack_req, ..Header::new(self.direction, kind, self.seq, self.session) };
        let len = encode(&header, payload, out).ok()?;
        self.seq = self.seq.wrapping_add(1);
        self.sent = self.sent.saturating_add(1);
        Some(len)
    }

    /// As [`Sender::send`], with a message that writes its own payload.
    pub(crate) fn message(
        &mut self,
        kind: Kind,
        write: impl FnOnce(&mut [u8]) -> Result<usize, PayloadError>,
        out: &mut [u8],
    ) -> Option<usize> {
        let mut payload = [0; MAX_PAYLOAD];
        let len = write(&mut payload).ok()?;
        self.send(kind, false, payload.get(..len)?, out)
    }

    /// Sends in another session.
    pub(crate) fn within<T>(&mut self, session: u16, send: impl FnOnce(&mut Self) -> T) -> T {
        let own = core::mem::replace(&mut self.session, session);
        let sent = send(self);
        self.session = own;
        sent
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_number_wraps_and_no_frame_is_lost_by_it() {
        let mut sender = Sender::new(Direction::ToHost);
        let mut out = [0; 64];
        for sent in 0..=0x1_0000_u32 {
            assert_eq!((sender.sent(), u32::from(sender.next_seq())), (sent, sent & 0xFFFF));
            assert!(sender.send(Kind::HELLO, false, &[], &mut out).is_some());
        }
    }
}
