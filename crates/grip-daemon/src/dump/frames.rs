//! Ring of the last frames of one direction, from chunks of the wire, in memory that was taken once.

use core::fmt;
use grip_link::{
    cobs,
    frame::{Frame, MAX_BLOCK},
    message::{Event, Grip, Kind, Status},
};

/// Frames that are remembered of each direction.
pub(super) const FRAMES: usize = 100;

/// A frame between its delimiters, or what stood there instead of one.
#[derive(Clone, Debug)]
pub(super) struct Slot {
    /// Host time of its last byte (us).
    pub(super) host_us: u64,
    /// Bytes there were; the first [`MAX_BLOCK`] of them are kept.
    total: usize,
    bytes: [u8; MAX_BLOCK],
}

impl Slot {
    const EMPTY: Self = Self { host_us: 0, total: 0, bytes: [0; MAX_BLOCK] };

    fn push(&mut self, host_us: u64, bytes: &[u8]) {
        self.host_us = host_us;
        let room = self.bytes.get_mut(self.total.min(MAX_BLOCK)..).unwrap_or(&mut []);
        let count = room.len().min(bytes.len());
        if let (Some(room), Some(bytes)) = (room.get_mut(..count), bytes.get(..count)) {
            room.copy_from_slice(bytes);
        }
        self.total = self.total.saturating_add(bytes.len());
    }

    fn kept(&self) -> &[u8] {
        self.bytes.get(..self.total.min(MAX_BLOCK)).unwrap_or(&self.bytes)
    }
}

/// The last frames of one direction.
#[derive(Clone, Debug)]
pub(super) struct FrameRing {
    slots: Vec<Slot>,
    next: usize,
    seen: usize,
    open: Slot,
}

impl FrameRing {
    pub(super) fn new() -> Self {
        Self { slots: vec![Slot::EMPTY; FRAMES], next: 0, seen: 0, open: Slot::EMPTY }
    }

    /// Takes bytes as they were read or written, in any pieces.
    pub(super) fn push(&mut self, host_us: u64, mut bytes: &[u8]) {
        while let Some(end) = cobs::find_zero(bytes) {
            let (block, rest) = bytes.split_at(end);
            self.open.push(host_us, block);
            self.close();
            bytes = rest.get(1..).unwrap_or(&[]);
        }
        if !bytes.is_empty() {
            self.open.push(host_us, bytes);
        }
    }

    fn close(&mut self) {
        if self.open.total > 0 {
            if let Some(slot) = self.slots.get_mut(self.next) {
                slot.clone_from(&self.open);
            }
            self.next = (self.next + 1) % FRAMES;
            self.seen = (self.seen + 1).min(FRAMES);
        }
        self.open.total = 0;
    }

    /// What is remembered, the oldest first; the last one may be the beginning of a frame.
    pub(super) fn slots(&self) -> impl Iterator<Item = &Slot> {
        let (new, old) = self.slots.split_at(self.next);
        let filled = if self.seen < FRAMES { [new, &[]] } else { [old, new] };
        let open = Some(&self.open).filter(|open| open.total > 0);
        filled.into_iter().flatten().chain(open)
    }
}

/// What it is, then its bytes.
impl fmt::Display for Slot {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut block = self.bytes;
        let block = block.get_mut(..self.total).and_then(cobs::decode_in_place);
        match block.map(|body| Frame::from_body(body)) {
            Some(Ok(frame)) => describe(f, &frame)?,
            Some(Err(error)) => write!(f, "no frame: {error}")?,
            None if self.total > MAX_BLOCK => write!(f, "no frame: {} bytes", self.total)?,
            None => write!(f, "no frame: not COBS")?,
        }
        f.write_str(" |")?;
        self.kept().iter().try_for_each(|byte| write!(f, " {byte:02X}"))
    }
}

fn describe(f: &mut fmt::Formatter<'_>, frame: &Frame<'_>) -> fmt::Result {
    let (header, payload) = (&frame.header, frame.payload);
    match name(header.kind) {
        Some(name) => f.write_str(name)?,
        None => write!(f, "type {:02X}", header.kind.0)?,
    }
    write!(f, " seq {} session {:04X} {} bytes", header.seq, header.session, payload.len())?;
    match header.kind {
        Kind::GRIP => Grip::parse(payload).map_or(Ok(()), |grip| {
            write!(
                f,
                ", {} mN, mode {}, for sample {}",
                grip.force_mn, grip.mode, grip.cause_sample
            )
        }),
        Kind::STATUS => Status::parse(payload).map_or(Ok(()), |status| {
            let Status { state, fault, applied_mn, target_mn, .. } = status;
            write!(f, ", {state:?}, fault {:04X}, {applied_mn} of {target_mn} mN", fault.0)
        }),
        Kind::EVENT => Event::parse(payload).map_or(Ok(()), |event| {
            let Event { kind, before, after, fault, .. } = event;
            write!(f, ", {kind:?} {before:?} -> {after:?}, fault {:04X}", fault.0)
        }),
        _ => Ok(()),
    }
}

fn name(kind: Kind) -> Option<&'static str> {
    const NAMES: [(Kind, &str); 19] = [
        (Kind::HELLO, "HELLO"),
        (Kind::IDENT, "IDENT"),
        (Kind::CONFIG, "CONFIG"),
        (Kind::CONFIG_ACK, "CONFIG_ACK"),
        (Kind::START, "START"),
        (Kind::STOP, "STOP"),
        (Kind::PING, "PING"),
        (Kind::PONG, "PONG"),
        (Kind::GRIP, "GRIP"),
        (Kind::HEARTBEAT, "HEARTBEAT"),
        (Kind::ESTOP, "ESTOP"),
        (Kind::CLEAR_FAULT, "CLEAR_FAULT"),
        (Kind::ACK, "ACK"),
        (Kind::NACK, "NACK"),
        (Kind::SAMPLES, "SAMPLES"),
        (Kind::STATUS, "STATUS"),
        (Kind::STATS, "STATS"),
        (Kind::EVENT, "EVENT"),
        (Kind::LOG, "LOG"),
    ];
    NAMES.into_iter().find(|(known, _)| *known == kind).map(|(_, name)| name)
}

#[cfg(test)]
mod tests {
    use super::{FRAMES, FrameRing};
    use grip_link::{
        frame::{Direction, Header, MAX_WIRE, encode},
        message::{Grip, Kind},
    };

    fn wire(kind: Kind, seq: u16, payload: &[u8]) -> Vec<u8> {
        let mut out = [0; MAX_WIRE];
        let header = Header::new(Direction::ToDevice, kind, seq, 0x4A2B);
        let len = encode(&header, payload, &mut out).unwrap();
        out[..len].to_vec()
    }

    #[test]
    fn the_last_hundred_frames_stay_in_any_chunks() {
        let stream: Vec<u8> = (0..250).flat_map(|seq| wire(Kind::START, seq, &[])).collect();
        for chunk in [1, 3, 7, 100, stream.len()] {
            let mut ring = FrameRing::new();
            for (at, bytes) in stream.chunks(chunk).enumerate() {
                ring.push(at as u64, bytes);
            }
            let reported: Vec<String> = ring.slots().map(ToString::to_string).collect();
            assert_eq!(reported.len(), FRAMES, "chunks of {chunk}");
            assert!(
                reported[0].starts_with("START seq 150 session 4A2B 0 bytes |"),
                "{}",
                reported[0]
            );
            assert!(reported[99].starts_with("START seq 249 "), "{}", reported[99]);
        }
    }

    #[test]
    fn frames_are_explained_and_noise_is_called_so() {
        let grip = Grip {
            cmd_id: 1,
            mode: 1,
            flags: 0,
            ttl_ms: 50,
            force_mn: 2350,
            slew_mn_s: 1,
            cause_sample: 77,
        };
        let mut payload = [0; Grip::SIZE];
        grip.write(&mut payload).unwrap();
        let mut ring = FrameRing::new();
        ring.push(5, &wire(Kind::GRIP, 9, &payload));
        ring.push(6, &[0, 9, 9, 9, 0]);
        let mut broken = wire(Kind::GRIP, 10, &payload);
        broken[6] ^= 0x40;
        ring.push(7, &broken);
        ring.push(8, &[7; 2000]);
        let reported: Vec<String> = ring.slots().map(ToString::to_string).collect();
        assert!(
            reported[0]
                .starts_with("GRIP seq 9 session 4A2B 20 bytes, 2350 mN, mode 1, for sample 77 | "),
            "{}",
            reported[0]
        );
        assert_eq!(reported[1], "no frame: not COBS | 09 09 09");
        assert!(reported[2].starts_with("no frame: checksum "), "{}", reported[2]);
        assert!(reported[3].starts_with("no frame: 2000 bytes | 07 07 "), "{}", reported[3]);
        assert_eq!(reported.len(), 4);
    }
}
