//! The same bytes whole, byte by byte and in pieces of any length: decoder, device and host must not distinguish them.
//!
//! Input: who listens, a byte that makes the lengths of the pieces, the wire bytes.

use super::decoder::{decoder, judged, listener};
use super::gripper::{CONFIG, SESSION, device, greeting};
use grip_link::frame::MAX_WIRE;
use grip_link::host::{HostConfig, HostLink};

const NOW: u64 = 5_000;

/// Pieces of 1 to `longest` bytes, by a small generator of its own.
fn pieces(bytes: &[u8], seed: u8) -> Vec<&[u8]> {
    let mut state = u32::from(seed).wrapping_mul(2_654_435_761) | 1;
    let longest = [3, 17, 64, 300][usize::from(seed & 3)];
    let mut pieces = Vec::new();
    let mut rest = bytes;
    while !rest.is_empty() {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let len = (state >> 16) as usize % longest + 1;
        let (piece, after) = rest.split_at(len.min(rest.len()));
        pieces.push(piece);
        // An empty read shows nothing.
        pieces.push(&[]);
        rest = after;
    }
    pieces
}

/// All that a linked device reports and sends.
fn device_states(pieces: &[&[u8]]) -> Vec<String> {
    let mut link = device(1);
    link.ready(0);
    let greeting = greeting();
    let mut states = Vec::new();
    for piece in core::iter::once(greeting.as_slice()).chain(pieces.iter().copied()) {
        let mut input = piece;
        while let Some(event) = link.receive(NOW, &mut input) {
            states.push(format!("{event:?}"));
        }
    }
    let mut out = [0; MAX_WIRE];
    while let Some(len) = link.poll_transmit(NOW, &mut out) {
        states.push(format!("{:?}", &out[..len]));
    }
    states.push(format!("{:?} {:?}", link.drive(NOW), link.counters()));
    states
}

/// All that a host that has just said HELLO states and sends.
fn host_states(pieces: &[&[u8]]) -> Vec<String> {
    let mut link = HostLink::new(HostConfig::new(CONFIG)).unwrap();
    link.open(NOW, SESSION).unwrap();
    let mut out = [0; MAX_WIRE];
    while link.poll_transmit(NOW, &mut out).is_some() {}
    let mut states = Vec::new();
    for piece in pieces {
        let mut input = *piece;
        while let Some(event) = link.receive(NOW, &mut input) {
            states.push(format!("{event:?}"));
        }
    }
    while let Some(len) = link.poll_transmit(NOW, &mut out) {
        states.push(format!("{:?}", &out[..len]));
    }
    states.push(format!("{:?} {:?}", link.state(), link.counters()));
    states
}

/// The target.
pub fn check(data: &[u8]) {
    let [first, seed, bytes @ ..] = data else { return };
    if bytes.is_empty() {
        return;
    }
    let who = listener(*first);
    let whole = [bytes];
    let single: Vec<&[u8]> = bytes.chunks(1).collect();
    let pieces = pieces(bytes, *seed);
    let expected = judged(decoder(who), whole.iter().copied());
    for cut in [&single, &pieces] {
        assert_eq!(judged(decoder(who), cut.iter().copied()), expected);
        assert_eq!(device_states(cut), device_states(&whole));
        assert_eq!(host_states(cut), host_states(&whole));
    }
}
