//! Every one-byte change of the frames that every peer writes.

use crate::table::rows;
use crate::targets::gripper::{SESSION, wire};
use crate::targets::words::{hex, unhex};
use grip_link::decoder::{Decoder, Role, Verdict};
use grip_link::frame::{Direction, Header};
use grip_link::message::Kind;
use std::collections::HashSet;

/// The first frame of each type, and some of full length.
fn golden_frames() -> Vec<Vec<u8>> {
    let mut types = HashSet::new();
    let first = rows::<7>("valid.tsv")
        .into_iter()
        .filter(|[_, _, direction, kind, ..]| direction != "cobs" && types.insert(kind.clone()));
    let mut frames: Vec<Vec<u8>> = first.map(|[.., bytes]| unhex(&bytes)).collect();
    let long: Vec<u8> = (0..480_u16).map(|i| u8::try_from(i % 251 + 1).unwrap()).collect();
    for len in [0, 1, 241, 242, 243, 244, 480] {
        frames
            .push(wire(&Header::new(Direction::ToHost, Kind::SAMPLES, 600, SESSION), &long[..len]));
    }
    frames.push(wire(&Header::new(Direction::ToHost, Kind::SAMPLES, 600, SESSION), &[0; 480]));
    frames
}

fn accepted(bytes: &[u8], role: Role) -> Vec<(Header, Vec<u8>)> {
    let mut decoder = Decoder::new(role);
    decoder.open_session(SESSION, None);
    let mut input = bytes;
    let mut found = Vec::new();
    while let Some(verdict) = decoder.next(&mut input) {
        if let Verdict::Frame(frame) = verdict {
            found.push((frame.header, frame.payload.to_vec()));
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
