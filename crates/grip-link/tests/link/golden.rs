//! Pinned frames, and every one-byte change of each of them.

use crate::targets::gripper::{SESSION, wire};
use crate::targets::words::{hex, unhex};
use grip_link::decoder::{Decoder, Role, Verdict};
use grip_link::frame::{Direction, Frame, Header};
use grip_link::message::{Grip, GripMode, Hello, Kind, Ping, Versions};

const HELLO: &str = "000312010104efbe10050101e00101010101010101010101010598f394cd00";
const GRIP: &str = "000410100704efbe14022a0101020102320388130104400d030440e201051cd41e0700";
const PING: &str = "000410060904efbe080104ca9a3b01010105fb2a4e8100";
const ESTOP: &str = "0004121208010101010559fa7db600";

fn to_device(kind: Kind, seq: u16, session: u16) -> Header {
    let ack_req = kind == Kind::HELLO || kind == Kind::ESTOP;
    Header { ack_req, ..Header::new(Direction::ToDevice, kind, seq, session) }
}

#[test]
fn reference_frames_are_byte_exact() {
    let mut payload = [0; 32];
    let hello = Hello { versions: Versions { min: 1, max: 1 }, max_rx: 480, caps: 0, time_us: 0 };
    let len = hello.write(&mut payload).unwrap();
    assert_eq!(hex(&wire(&to_device(Kind::HELLO, 0, SESSION), &payload[..len])), HELLO);
    let grip = Grip {
        cmd_id: 42,
        mode: GripMode::Force.code(),
        flags: 0,
        ttl_ms: 50,
        force_mn: 5000,
        slew_mn_s: 200_000,
        cause_sample: 123_456,
    };
    let len = grip.write(&mut payload).unwrap();
    assert_eq!(hex(&wire(&to_device(Kind::GRIP, 7, SESSION), &payload[..len])), GRIP);
    let len = Ping { t1_us: 1_000_000_000 }.write(&mut payload).unwrap();
    assert_eq!(hex(&wire(&to_device(Kind::PING, 9, SESSION), &payload[..len])), PING);
    assert_eq!(hex(&wire(&to_device(Kind::ESTOP, 8, 0), &[])), ESTOP);
}

/// One frame of each type and some of full length.
pub(crate) fn golden_frames() -> Vec<Vec<u8>> {
    let mut frames: Vec<Vec<u8>> = [HELLO, GRIP, PING, ESTOP].map(unhex).to_vec();
    frames.extend(crate::messages::PINNED.iter().map(|(_, text)| unhex(text)));
    let long: Vec<u8> = (0..480_u16).map(|i| u8::try_from(i % 251 + 1).unwrap()).collect();
    for len in [0, 1, 241, 242, 243, 244, 480] {
        frames
            .push(wire(&Header::new(Direction::ToHost, Kind::SAMPLES, 600, SESSION), &long[..len]));
    }
    frames.push(wire(&Header::new(Direction::ToHost, Kind::SAMPLES, 600, SESSION), &[0; 480]));
    frames
}

fn owned(frame: &Frame<'_>) -> (Header, Vec<u8>) {
    (frame.header, frame.payload.to_vec())
}

fn accepted(bytes: &[u8], role: Role) -> Vec<(Header, Vec<u8>)> {
    let mut decoder = Decoder::new(role);
    decoder.open_session(SESSION, None);
    let mut input = bytes;
    let mut found = Vec::new();
    while let Some(verdict) = decoder.next(&mut input) {
        if let Verdict::Frame(frame) = verdict {
            found.push(owned(&frame));
        }
    }
    found
}

#[test]
fn every_byte_changed_to_every_value() {
    let mut tried = 0_u64;
    for golden in golden_frames() {
        let role =
            if accepted(&golden, Role::Device).is_empty() { Role::Host } else { Role::Device };
        let clean = accepted(&golden, role);
        assert_eq!(clean.len(), 1, "{}", hex(&golden));
        let (direction, seq) = (clean[0].0.direction, clean[0].0.seq);
        let (kind, session) =
            if role == Role::Host { (Kind::PONG, SESSION) } else { (Kind::PING, SESSION) };
        let before = wire(&Header::new(direction, kind, seq.wrapping_sub(1), session), &[7; 24]);
        let after = wire(&Header::new(direction, kind, seq.wrapping_add(1), session), &[8; 24]);
        let whole = [&before[..], &golden, &after].concat();
        let sent = accepted(&whole, role);
        assert_eq!(sent.len(), 3);
        for at in 0..golden.len() {
            let mut changed = whole.clone();
            for other in 1..=255 {
                changed[before.len() + at] = golden[at] ^ other;
                let got = accepted(&changed, role);
                tried += 1;
                assert!(
                    got == sent || (got.len() == 2 && got[0] == sent[0] && got[1] == sent[2]),
                    "{at} {other}"
                );
            }
        }
    }
    assert!(tried > 500_000, "{tried}");
}
