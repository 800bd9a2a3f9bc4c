//! Decoder of wire bytes in any chunking: checked frames and counted faults, one at a time.
//!
//! The checks come in this order, each with its own counter, and a block that fails one is not looked at
//! further: too long, COBS, length, CRC, direction, version, session, sequence, type. The buffer holds one
//! block (494 bytes); the memory never grows.
//!
//! Session rule: a device takes HELLO of any other session and ESTOP of session 0; a host takes IDENT of session 0; these
//! skip the sequence check. A daemon takes SUBSCRIBE of any other session, a client NOTICE of session 0. Every other frame must bear the open session. Sequence rule: the first frame of a
//! session sets the number; then one that lies 0..=255 behind the newest is a duplicate and dropped, any other is taken and the
//! numbers skipped are counted as a gap. Frames of unknown type count in the sequence.

use crate::cobs;
use crate::frame::{BodyError, Direction, Frame, Header, MAX_BLOCK};
use crate::kind::Kind;
use crate::{PROTOCOL, frame::HEADER};
use slip_msg::message;

/// A frame whose seq lies this far or less behind the newest one is a duplicate; anything else is a gap.
pub const DUPLICATE_WINDOW: u16 = 256;

/// Who is listening.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// The computer: takes frames with the direction bit set, of its session.
    Host,
    /// The microcontroller: takes frames with the direction bit clear, of its session.
    Device,
    /// A recording or a test: direction bit set, any session, any type.
    Tap,
    /// The daemon, of one client: direction bit clear, of the session that the client opened.
    Daemon,
    /// A client of the daemon: direction bit set, of its own session.
    Client,
}

impl Role {
    const fn receives(self) -> Direction {
        match self {
            Self::Device | Self::Daemon => Direction::ToDevice,
            Self::Host | Self::Tap | Self::Client => Direction::ToHost,
        }
    }

    fn is_greeting(self, kind: Kind) -> bool {
        match self {
            Self::Device | Self::Host | Self::Tap => kind == Kind::HELLO || kind == Kind::IDENT,
            Self::Daemon => kind == Kind::SUBSCRIBE,
            Self::Client => kind == Kind::WELCOME,
        }
    }

    const fn knows(self, kind: Kind) -> bool {
        match self {
            Self::Host => kind.is_to_host(),
            Self::Device => kind.is_to_device(),
            Self::Daemon => kind.is_to_daemon(),
            Self::Client => kind.is_to_client(),
            Self::Tap => true,
        }
    }
}

/// What came of the bytes up to a delimiter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict<'a> {
    /// A good frame, borrowed from the decoder until the next call.
    Frame(Frame<'a>),
    /// A block that was dropped and counted.
    Bad(Fault),
}

/// Why a block was dropped.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fault {
    /// Longer than any frame: dropped up to the next delimiter.
    TooLong,
    /// Not a COBS block.
    Cobs,
    /// Length field and bytes disagree, or fewer bytes than header and CRC.
    Length,
    /// Checksum wrong.
    Crc,
    /// Direction bit of the listener itself: an echo.
    Echo,
    /// Another protocol version (the greetings pass with any: HELLO and IDENT, to a daemon SUBSCRIBE, to a client WELCOME).
    Version(u8),
    /// Another session than the open one.
    Stale(u16),
    /// A sequence number seen before.
    Duplicate(u16),
    /// A good frame of a type this role does not know.
    UnknownKind(Header),
}

message! {
    /// Counts since the decoder was made; all saturate. A part of STATS.
    #[derive(Eq, Default)]
    Counters {
        0 ok: u32, "good frames", "Frames handed out.";
        4 too_long: u32, "blocks longer than any frame: delimiters lost, wrong baud rate, foreign protocol", "Too long.";
        8 cobs: u32, "blocks that are not COBS: bytes lost, or garbage such as modem commands", "No COBS.";
        12 length: u32, "blocks whose length field disagrees: bytes lost, inserted or joined", "Wrong length.";
        16 crc: u32, "blocks with a wrong checksum: bits flipped", "Wrong checksum.";
        20 echo: u32, "frames of the listener's own direction: echo is switched on", "Echoes.";
        24 version: u32, "frames of another protocol version", "Wrong version.";
        28 stale: u32, "frames of another session: a host or boot of the past, or a second host", "Wrong session.";
        32 duplicate: u32, "frames with a number of the recent past: repeated by a buffer, or replayed", "Seen before.";
        36 unknown: u32, "good frames of an unknown type: a newer peer", "Type not known.";
        40 gap: u32, "frames missing by their numbers", "Lost.";
        44 garbage_bytes: u32, "bytes, without delimiters, of the blocks counted in `too_long`, `cobs`, `length`, `crc`", "Bytes that were no frame.";
    }
}

impl Counters {
    /// Blocks that were no frame at all.
    #[must_use]
    pub const fn bad_blocks(&self) -> u32 {
        self.too_long.saturating_add(self.cobs).saturating_add(self.length).saturating_add(self.crc)
    }

    fn count(&mut self, fault: Fault) {
        let counter = match fault {
            Fault::TooLong => &mut self.too_long,
            Fault::Cobs => &mut self.cobs,
            Fault::Length => &mut self.length,
            Fault::Crc => &mut self.crc,
            Fault::Echo => &mut self.echo,
            Fault::Version(_) => &mut self.version,
            Fault::Stale(_) => &mut self.stale,
            Fault::Duplicate(_) => &mut self.duplicate,
            Fault::UnknownKind(_) => &mut self.unknown,
        };
        *counter = counter.saturating_add(1);
    }
}

/// Cuts a byte stream into frames.
///
/// ```
/// use grip_link::decoder::{Decoder, Role, Verdict};
/// let mut decoder = Decoder::new(Role::Device);
/// let wire = b"\x00\x04\x12\x12\x08\x01\x01\x01\x01\x05\x59\xfa\x7d\xb6\x00";
/// let mut input = &wire[..];
/// while let Some(verdict) = decoder.next(&mut input) {
///     assert!(matches!(verdict, Verdict::Frame(frame) if frame.header.seq == 8));
/// }
/// assert_eq!(decoder.counters().ok, 1);
/// ```
#[derive(Debug, Clone)]
pub struct Decoder {
    block: [u8; MAX_BLOCK],
    filled: usize,
    /// Bytes of a block that did not fit the buffer.
    spilled: u32,
    /// Header of the last good frame, and where its payload lies in `block`; only valid right after it was found.
    found: Option<(Header, u16, u16)>,
    role: Role,
    session: Option<u16>,
    last_seq: Option<u16>,
    counters: Counters,
}

impl Decoder {
    /// A decoder without a session: until [`Decoder::open_session`] a device takes HELLO and ESTOP only, a host nothing
    /// but an IDENT of session 0, a daemon SUBSCRIBE only, a client nothing
    /// but a NOTICE of session 0.
    #[must_use]
    pub const fn new(role: Role) -> Self {
        Self {
            block: [0; MAX_BLOCK],
            filled: 0,
            spilled: 0,
            found: None,
            role,
            session: None,
            last_seq: None,
            counters: Counters {
                ok: 0,
                too_long: 0,
                cobs: 0,
                length: 0,
                crc: 0,
                echo: 0,
                version: 0,
                stale: 0,
                duplicate: 0,
                unknown: 0,
                gap: 0,
                garbage_bytes: 0,
            },
        }
    }

    /// Takes frames of `session` from now on; `last_seq` is the last sequence number seen of it, if any.
    pub const fn open_session(&mut self, session: u16, last_seq: Option<u16>) {
        self.session = Some(session);
        self.last_seq = last_seq;
    }

    /// Takes no session's frames any more.
    pub const fn close_session(&mut self) {
        self.session = None;
        self.last_seq = None;
    }

    /// Forgets a block under way, as after reopening a port; counters and session stay.
    pub const fn restart(&mut self) {
        self.filled = 0;
        self.spilled = 0;
    }

    /// Counts so far.
    #[must_use]
    pub const fn counters(&self) -> &Counters {
        &self.counters
    }

    /// Takes bytes off `input` up to the end of the next block; `None` when `input` is used up.
    pub fn next(&mut self, input: &mut &[u8]) -> Option<Verdict<'_>> {
        Some(match self.advance(input)? {
            Ok(()) => Verdict::Frame(self.frame()?),
            Err(fault) => Verdict::Bad(fault),
        })
    }

    /// As [`Decoder::next`], without borrowing the frame: [`Decoder::frame`] gives it.
    pub(crate) fn advance(&mut self, input: &mut &[u8]) -> Option<Result<(), Fault>> {
        loop {
            let Some(end) = cobs::find_zero(input) else {
                self.take(input);
                *input = &[];
                return None;
            };
            let (head, rest) = input.split_at_checked(end)?;
            self.take(head);
            *input = rest.get(1..)?;
            if self.filled > 0 || self.spilled > 0 {
                return Some(self.close_block());
            }
        }
    }

    /// The frame that the last call found.
    pub(crate) fn frame(&self) -> Option<Frame<'_>> {
        let (header, begin, end) = self.found?;
        Some(Frame { header, payload: self.block.get(begin.into()..end.into())? })
    }

    fn take(&mut self, bytes: &[u8]) {
        let room = self.block.get_mut(self.filled..).and_then(|free| free.get_mut(..bytes.len()));
        match room {
            Some(room) if self.spilled == 0 => {
                room.copy_from_slice(bytes);
                self.filled += bytes.len();
            }
            _ => {
                self.spilled =
                    self.spilled.saturating_add(u32::try_from(bytes.len()).unwrap_or(u32::MAX))
            }
        }
    }

    fn close_block(&mut self) -> Result<(), Fault> {
        let filled = core::mem::take(&mut self.filled);
        let spilled = core::mem::take(&mut self.spilled);
        let verdict = self.judge(filled, spilled);
        match verdict {
            Ok(()) => self.counters.ok = self.counters.ok.saturating_add(1),
            Err(fault) => {
                self.counters.count(fault);
                if matches!(fault, Fault::TooLong | Fault::Cobs | Fault::Length | Fault::Crc) {
                    let bytes = u32::try_from(filled).unwrap_or(u32::MAX).saturating_add(spilled);
                    self.counters.garbage_bytes = self.counters.garbage_bytes.saturating_add(bytes);
                }
            }
        }
        verdict
    }

    fn judge(&mut self, filled: usize, spilled: u32) -> Result<(), Fault> {
        if spilled > 0 {
            return Err(Fault::TooLong);
        }
        let block = self.block.get_mut(..filled).ok_or(Fault::TooLong)?;
        let body = cobs::decode_in_place(block).ok_or(Fault::Cobs)?;
        let len = body.len();
        let (header, payload) = match Frame::from_body(body) {
            Ok(frame) => (frame.header, frame.payload.len()),
            Err(BodyError::Length { .. }) => return Err(Fault::Length),
            Err(BodyError::Crc { .. }) => return Err(Fault::Crc),
        };
        let begin = filled - len + HEADER;
        let place = |at| u16::try_from(at).map_err(|_| Fault::TooLong);
        self.found = Some((header, place(begin)?, place(begin + payload)?));
        self.accept(&header)
    }

    fn accept(&mut self, header: &Header) -> Result<(), Fault> {
        if header.direction != self.role.receives() {
            return Err(Fault::Echo);
        }
        if header.version != PROTOCOL && !self.role.is_greeting(header.kind) {
            return Err(Fault::Version(header.version));
        }
        let other = self.session != Some(header.session);
        let outside_session = match self.role {
            Role::Device if header.kind == Kind::HELLO => other,
            Role::Device => header.kind == Kind::ESTOP && header.session == 0,
            Role::Host => header.kind == Kind::IDENT && header.session == 0,
            Role::Daemon => header.kind == Kind::SUBSCRIBE && other,
            Role::Client => header.kind == Kind::NOTICE && header.session == 0,
            Role::Tap => false,
        };
        if outside_session {
            return Ok(());
        }
        if self.role != Role::Tap && self.session != Some(header.session) {
            return Err(Fault::Stale(header.session));
        }
        self.follow(header.seq)?;
        if self.role.knows(header.kind) { Ok(()) } else { Err(Fault::UnknownKind(*header)) }
    }

    fn follow(&mut self, seq: u16) -> Result<(), Fault> {
        if let Some(last) = self.last_seq {
            if last.wrapping_sub(seq) < DUPLICATE_WINDOW {
                return Err(Fault::Duplicate(seq));
            }
            let missing = seq.wrapping_sub(last).wrapping_sub(1);
            self.counters.gap = self.counters.gap.saturating_add(u32::from(missing));
        }
        self.last_seq = Some(seq);
        Ok(())
    }
}
