//! Wire bytes against the slow decoder of `reference`; every frame handed out survives being encoded again.
//!
//! Input: a byte that states who listens, then the wire bytes.

use super::gripper::{SESSION, wire};
use super::reference::{Judged, Seen, judge};
use super::words::hex;
use grip_link::decoder::{Counters, Decoder, Fault, Role, Verdict};

/// Who listens: role, open session, newest sequence number of it.
pub type Listener = (Role, Option<u16>, Option<u16>);

/// By the first byte of an input.
pub fn listener(byte: u8) -> Listener {
    let role = match (byte >> 4 & 1, byte & 3) {
        (0, 1) => Role::Host,
        (0, 2) => Role::Tap,
        (0, _) => Role::Device,
        (_, 0 | 2) => Role::Daemon,
        _ => Role::Client,
    };
    let (session, newest) = match byte >> 2 & 3 {
        0 => (Some(SESSION), Some(0)),
        1 => (Some(SESSION), None),
        2 => (Some(SESSION), Some(65_530)),
        _ => (None, None),
    };
    (role, session, newest)
}

/// A decoder for a listener.
pub fn decoder(listener: Listener) -> Decoder {
    let (role, session, newest) = listener;
    let mut decoder = Decoder::new(role);
    if let Some(session) = session {
        decoder.open_session(session, newest);
    }
    decoder
}

/// Feeds pieces one after the other.
pub fn judged<'a>(
    mut decoder: Decoder,
    pieces: impl Iterator<Item = &'a [u8]>,
) -> (Judged, Counters) {
    let mut judged = Judged::default();
    for piece in pieces {
        let mut input = piece;
        while let Some(verdict) = decoder.next(&mut input) {
            judged.seen.push(match verdict {
                Verdict::Frame(frame) => Seen::Frame(frame.header, frame.payload.to_vec()),
                Verdict::Bad(fault) => Seen::Bad(fault),
            });
        }
        assert!(input.is_empty(), "bytes were left");
    }
    let counters = *decoder.counters();
    (judged_with(judged, &counters), counters)
}

fn judged_with(judged: Judged, counters: &Counters) -> Judged {
    Judged { gap: counters.gap, garbage: counters.garbage_bytes, ..judged }
}

/// The target.
pub fn check(data: &[u8]) {
    let Some((&first, bytes)) = data.split_first() else { return };
    let (role, session, newest) = listener(first);
    let (fast, counters) = judged(decoder((role, session, newest)), [bytes].into_iter());
    assert_eq!(fast, judge(role, session, newest, bytes));
    let count = |wanted: fn(&Fault) -> bool| {
        let bad = fast.seen.iter().filter(|seen| matches!(seen, Seen::Bad(fault) if wanted(fault)));
        u32::try_from(bad.count()).unwrap()
    };
    assert_eq!(counters.crc, count(|fault| *fault == Fault::Crc));
    assert_eq!(counters.stale, count(|fault| matches!(fault, Fault::Stale(_))));
    assert_eq!(counters.duplicate, count(|fault| matches!(fault, Fault::Duplicate(_))));
    for seen in &fast.seen {
        if let Seen::Frame(header, payload) = seen {
            let again = wire(header, payload);
            let listener = decoder((role, Some(header.session), None));
            let (once, _) = judged(listener, [again.as_slice()].into_iter());
            assert_eq!(once.seen, core::slice::from_ref(seen));
        }
    }
}

/// The input as a line `ROLE SESSION[:SEQ]|- HEX` for the other peers; `None` where they know no such listener.
pub fn line(data: &[u8]) -> Option<String> {
    let (&first, bytes) = data.split_first()?;
    let (role, session, newest) = listener(first);
    let role = match role {
        Role::Device => "device",
        Role::Host => "host",
        Role::Tap | Role::Daemon | Role::Client => return None,
    };
    let session = match (session, newest) {
        (None, _) => "-".to_owned(),
        (Some(session), None) => format!("{session:04x}"),
        (Some(session), Some(newest)) => format!("{session:04x}:{newest}"),
    };
    (!bytes.is_empty()).then(|| format!("{role} {session} {}", hex(bytes)))
}
