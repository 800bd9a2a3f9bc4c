//! Reference decoder from wire bytes to verdicts: the decoder once more, as slow and obvious as the specification reads.

use grip_link::PROTOCOL;
use grip_link::decoder::{Fault, Role};
use grip_link::frame::{Direction, Header};
use grip_link::message::Kind;

/// A verdict without borrowed parts.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Seen {
    /// A good frame.
    Frame(Header, Vec<u8>),
    /// A block that was dropped.
    Bad(Fault),
}

/// What a decoder made of bytes.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Judged {
    /// Verdicts in order.
    pub seen: Vec<Seen>,
    /// Frames missing.
    pub gap: u32,
    /// Bytes in blocks that were no frames.
    pub garbage: u32,
}

/// Judges a whole stream.
pub fn judge(role: Role, session: Option<u16>, mut newest: Option<u16>, bytes: &[u8]) -> Judged {
    let mut judged = Judged::default();
    let Some(end) = bytes.iter().rposition(|&byte| byte == 0) else { return judged };
    for block in bytes[..end].split(|&byte| byte == 0).filter(|block| !block.is_empty()) {
        let verdict = frame(block).and_then(|(header, payload)| {
            accept(role, session, &header)?;
            if !skips_the_session(role, session, &header) {
                judged.gap += follow(&mut newest, header.seq)?;
                known(role, &header)?;
            }
            Ok((header, payload))
        });
        judged.seen.push(match verdict {
            Ok((header, payload)) => Seen::Frame(header, payload),
            Err(fault) => {
                if matches!(fault, Fault::TooLong | Fault::Cobs | Fault::Length | Fault::Crc) {
                    judged.garbage += u32::try_from(block.len()).unwrap();
                }
                Seen::Bad(fault)
            }
        });
    }
    judged
}

fn frame(block: &[u8]) -> Result<(Header, Vec<u8>), Fault> {
    if block.len() > 494 {
        return Err(Fault::TooLong);
    }
    let body = cobs(block).ok_or(Fault::Cobs)?;
    let len = |at: usize| usize::from(u16::from_le_bytes([body[at], body[at + 1]]));
    if body.len() < 12 || len(6) != body.len() - 12 || len(6) > 480 {
        return Err(Fault::Length);
    }
    let (covered, crc) = body.split_at(body.len() - 4);
    if crc32c(covered).to_le_bytes() != crc {
        return Err(Fault::Crc);
    }
    let number = |at: usize| u16::from_le_bytes([body[at], body[at + 1]]);
    let header = Header {
        version: body[0] / 16,
        direction: if body[0] % 2 == 1 { Direction::ToHost } else { Direction::ToDevice },
        ack_req: body[0] / 2 % 2 == 1,
        kind: Kind(body[1]),
        seq: number(2),
        session: number(4),
    };
    Ok((header, covered[8..].to_vec()))
}

/// The data of a block; `None` where a code points past its end.
fn cobs(block: &[u8]) -> Option<Vec<u8>> {
    let mut data = Vec::new();
    let mut rest = block;
    while let Some((&code, after)) = rest.split_first() {
        let count = usize::from(code) - 1;
        data.extend(after.get(..count)?);
        rest = &after[count..];
        if code < 255 && !rest.is_empty() {
            data.push(0);
        }
    }
    Some(data)
}

/// CRC-32C bit by bit.
fn crc32c(bytes: &[u8]) -> u32 {
    let mut crc = u32::MAX;
    for &byte in bytes {
        crc ^= u32::from(byte);
        for _ in 0..8 {
            crc = if crc % 2 == 1 { (crc / 2) ^ 0x82F6_3B78 } else { crc / 2 };
        }
    }
    !crc
}

fn skips_the_session(role: Role, session: Option<u16>, header: &Header) -> bool {
    match role {
        Role::Device => {
            (header.kind == Kind::HELLO && session != Some(header.session))
                || (header.kind == Kind::ESTOP && header.session == 0)
        }
        Role::Host => header.kind == Kind::IDENT && header.session == 0,
        Role::Daemon => header.kind == Kind(0xA8) && session != Some(header.session),
        Role::Client => header.kind == Kind(0xA6) && header.session == 0,
        Role::Tap => false,
    }
}

fn accept(role: Role, session: Option<u16>, header: &Header) -> Result<(), Fault> {
    let down = role == Role::Device || role == Role::Daemon;
    let to_me = (header.direction == Direction::ToDevice) == down;
    if !to_me {
        return Err(Fault::Echo);
    }
    let greetings: &[u8] = match role {
        Role::Daemon => &[0xA8],
        Role::Client => &[0xA0],
        _ => &[0x01, 0x81],
    };
    let any_version = greetings.contains(&header.kind.0);
    if header.version != PROTOCOL && !any_version {
        return Err(Fault::Version(header.version));
    }
    let mine = role == Role::Tap
        || skips_the_session(role, session, header)
        || session == Some(header.session);
    if mine { Ok(()) } else { Err(Fault::Stale(header.session)) }
}

/// Frames missing before this one.
fn follow(newest: &mut Option<u16>, seq: u16) -> Result<u32, Fault> {
    let missing = match *newest {
        None => 0,
        Some(newest) => {
            let ahead = (u32::from(seq) + 65_536 - u32::from(newest)) % 65_536;
            if ahead == 0 || ahead > 65_536 - 256 {
                return Err(Fault::Duplicate(seq));
            }
            ahead - 1
        }
    };
    *newest = Some(seq);
    Ok(missing)
}

fn known(role: Role, header: &Header) -> Result<(), Fault> {
    let types: &[u8] = match role {
        Role::Device => &[0x01, 0x03, 0x04, 0x05, 0x06, 0x10, 0x11, 0x12, 0x13],
        Role::Host => &[0x81, 0x83, 0x86, 0x8E, 0x8F, 0x90, 0x91, 0x92, 0x93, 0x94],
        Role::Daemon => &[0xA8, 0xA9, 0xAA],
        Role::Client => &[0xA0, 0xA1, 0xA2, 0xA3, 0xA4, 0xA5, 0xA6, 0x8E, 0x8F],
        Role::Tap => return Ok(()),
    };
    if types.contains(&header.kind.0) { Ok(()) } else { Err(Fault::UnknownKind(*header)) }
}
