//! Properties of framing: any payload, any chunking, any bytes.

use crate::targets::gripper::wire;
use grip_link::cobs;
use grip_link::crc::crc32c;
use grip_link::decoder::{Counters, Decoder, Fault, Role, Verdict};
use grip_link::frame::{Direction, Header, MAX_PAYLOAD, MAX_WIRE};
use grip_link::message::{Kind, ToDevice};
use proptest::prelude::{ProptestConfig, any, prop, proptest};
use proptest::{prop_assert, prop_assert_eq};

#[derive(Debug, PartialEq)]
enum Seen {
    Frame(Header, Vec<u8>),
    Bad(Fault),
}

fn decode(chunks: &[&[u8]], role: Role) -> (Vec<Seen>, Counters) {
    let mut decoder = Decoder::new(role);
    decoder.open_session(1, None);
    let mut seen = Vec::new();
    for chunk in chunks {
        let mut input = *chunk;
        while let Some(verdict) = decoder.next(&mut input) {
            seen.push(match verdict {
                Verdict::Frame(frame) => Seen::Frame(frame.header, frame.payload.to_vec()),
                Verdict::Bad(fault) => Seen::Bad(fault),
            });
        }
        assert!(input.is_empty());
    }
    (seen, *decoder.counters())
}

fn split<'a>(bytes: &'a [u8], cuts: &[usize]) -> Vec<&'a [u8]> {
    let mut cuts: Vec<usize> = cuts.iter().map(|cut| cut % (bytes.len() + 1)).collect();
    cuts.sort_unstable();
    let mut chunks = Vec::new();
    let mut start = 0;
    for cut in cuts {
        chunks.push(&bytes[start..cut]);
        start = cut;
    }
    chunks.push(&bytes[start..]);
    chunks
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(512))]

    #[test]
    fn decoding_undoes_encoding(
        payload in prop::collection::vec(any::<u8>(), 0..=MAX_PAYLOAD),
        sparse in any::<bool>(), kind in any::<u8>(), seq in any::<u16>(), session in any::<u16>(), ack_req in any::<bool>(),
    ) {
        let payload: Vec<u8> = payload.iter().map(|&b| if sparse && b < 200 { 0 } else { b }).collect();
        let header = Header { ack_req, ..Header::new(Direction::ToHost, Kind(kind), seq, session) };
        let wire = wire(&header, &payload);
        prop_assert!(wire.len() <= MAX_WIRE);
        prop_assert!(wire[1..wire.len() - 1].iter().all(|&b| b != 0));
        let (seen, counters) = decode(&[&wire], Role::Tap);
        prop_assert_eq!(seen, vec![Seen::Frame(header, payload)]);
        prop_assert_eq!(counters, Counters { ok: 1, ..Counters::default() });
    }

    #[test]
    fn cobs_undoes_itself(data in prop::collection::vec(0_u8..4, 0..1200)) {
        let mut out = vec![0; cobs::max_encoded(data.len())];
        let len = cobs::encode(&data, &mut out).unwrap();
        prop_assert!(out[..len].iter().all(|&b| b != 0));
        prop_assert_eq!(&*cobs::decode_in_place(&mut out[..len]).unwrap(), &data[..]);
    }

    #[test]
    fn any_chunking_gives_the_same(
        pieces in prop::collection::vec((prop::collection::vec(any::<u8>(), 0..700), any::<u8>()), 1..12),
        cuts in prop::collection::vec(any::<usize>(), 0..40),
    ) {
        let mut bytes = Vec::new();
        for (seq, (data, choice)) in pieces.iter().enumerate() {
            let header = Header::new(Direction::ToHost, Kind(0x90 + choice % 8), u16::try_from(seq).unwrap(), 1);
            match choice % 4 {
                0 => bytes.extend_from_slice(data),
                1 => bytes.extend_from_slice(&wire(&header, &[])),
                _ => bytes.extend_from_slice(&wire(&header, &data[..data.len().min(MAX_PAYLOAD)])),
            }
        }
        let whole = decode(&[&bytes], Role::Host);
        prop_assert_eq!(&decode(&split(&bytes, &cuts), Role::Host), &whole);
        let single: Vec<&[u8]> = bytes.chunks(1).collect();
        prop_assert_eq!(&decode(&single, Role::Host), &whole);
    }

    #[test]
    fn random_bytes_are_never_a_frame(bytes in prop::collection::vec(any::<u8>(), 0..3000), few in any::<bool>()) {
        let bytes: Vec<u8> = bytes.iter().map(|&b| if few { b % 3 } else { b }).collect();
        for role in [Role::Host, Role::Device, Role::Tap] {
            let (seen, counters) = decode(&[&bytes], role);
            prop_assert!(seen.iter().all(|seen| matches!(seen, Seen::Bad(_))));
            let blocks = bytes.split(|&b| b == 0).count();
            prop_assert!(seen.len() < blocks);
            prop_assert_eq!(usize::try_from(counters.bad_blocks()).unwrap(), seen.len());
            prop_assert!(usize::try_from(counters.garbage_bytes).unwrap() <= bytes.len());
        }
    }

    #[test]
    fn any_payload_parses_or_is_refused(kind in any::<u8>(), payload in prop::collection::vec(any::<u8>(), 0..=MAX_PAYLOAD)) {
        let header = Header::new(Direction::ToDevice, Kind(kind), 0, 1);
        let parsed = ToDevice::parse(&grip_link::frame::Frame { header, payload: &payload });
        if !Kind(kind).is_to_device() {
            prop_assert!(parsed.is_err());
        }
    }
}

/// What a line makes of some bytes in a row: a kind of fault and what it puts there.
fn faulty(bytes: &[u8], kind: u8, noise: Vec<u8>) -> Vec<u8> {
    match kind {
        0 => Vec::new(),
        1 => [bytes, bytes].concat(),
        2 => bytes.iter().rev().copied().collect(),
        3 => bytes.iter().map(|byte| byte ^ (1 << (noise.len() % 8))).collect(),
        _ => noise,
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4096))]

    /// Bytes that are lost, doubled, turned, flipped, replaced or put in between: only frames that were sent are handed out, once and in
    /// order, and each that was not hit, with its own last byte.
    #[test]
    fn a_fault_costs_the_frames_it_hits_and_no_other(
        payloads in prop::collection::vec(prop::collection::vec(any::<u8>(), 0..120), 7),
        at in any::<prop::sample::Index>(), len in 0_usize..=64, kind in 0_u8..5,
        noise in prop::collection::vec(any::<u8>(), 0..300),
    ) {
        let (mut bytes, mut spans) = (Vec::new(), Vec::new());
        for (seq, payload) in (0..).zip(&payloads) {
            let start = bytes.len();
            bytes.extend(wire(&Header::new(Direction::ToHost, Kind::STATUS, seq, 1), payload));
            spans.push(start..bytes.len());
        }
        let from = at.index(bytes.len());
        let hit = from..(from + len).min(bytes.len());
        let put = faulty(&bytes[hit.clone()], kind, noise);
        let line = [&bytes[..from], &put, &bytes[hit.end..]].concat();

        let mut decoder = Decoder::new(Role::Host);
        decoder.open_session(1, Some(u16::MAX));
        let (mut input, mut received) = (&line[..], Vec::new());
        while let Some(verdict) = decoder.next(&mut input) {
            let Verdict::Frame(frame) = verdict else { continue };
            let seq = usize::from(frame.header.seq);
            prop_assert_eq!(Some(frame.payload), payloads.get(seq).map(Vec::as_slice));
            received.push((seq, line.len() - input.len()));
        }
        prop_assert!(received.is_sorted_by(|a, b| a.0 < b.0), "{:?}", received);
        for (seq, span) in spans.iter().enumerate() {
            let end = if span.end <= from {
                span.end
            } else if span.start >= hit.end {
                span.end + put.len() - hit.len()
            } else {
                continue;
            };
            prop_assert!(received.contains(&(seq, end)), "{} of {:?}", seq, received);
        }
    }
}

#[test]
fn a_frame_is_handed_out_at_its_last_byte() {
    let wire = wire(&Header::new(Direction::ToHost, Kind::STATUS, 0, 1), &[5; 24]);
    let mut decoder = Decoder::new(Role::Tap);
    for (i, byte) in wire.iter().enumerate() {
        let found = decoder.next(&mut &[*byte][..]).is_some();
        assert_eq!(found, i + 1 == wire.len());
    }
}

#[test]
fn too_long_blocks_are_skipped_and_counted() {
    let mut bytes = vec![0x55; 100_000];
    bytes.push(0);
    bytes.extend(wire(&Header::new(Direction::ToHost, Kind::STATUS, 0, 1), &[5; 24]));
    let (seen, counters) = decode(&[&bytes], Role::Host);
    assert_eq!(seen[0], Seen::Bad(Fault::TooLong));
    assert_eq!((counters.too_long, counters.ok, counters.garbage_bytes), (1, 1, 100_000));
}

#[test]
fn sequence_numbers_report_gaps_and_duplicates() {
    let numbered = |seq| wire(&Header::new(Direction::ToHost, Kind::STATUS, seq, 1), &[5; 24]);
    let bytes: Vec<u8> =
        [65_533, 65_534, 65_534, 1, 0, 65_533, 2, 500].into_iter().flat_map(numbered).collect();
    let (seen, counters) = decode(&[&bytes], Role::Host);
    let good: Vec<u16> = seen
        .iter()
        .filter_map(|s| if let Seen::Frame(header, _) = s { Some(header.seq) } else { None })
        .collect();
    assert_eq!(good, [65_533, 65_534, 1, 2, 500]);
    assert_eq!((counters.duplicate, counters.gap), (3, 2 + 497));
}

#[test]
fn each_fault_has_its_counter() {
    let to_host = |kind, seq| Header::new(Direction::ToHost, kind, seq, 1);
    let status = |header: &Header| wire(header, &[5; 24]);
    let mut wrong_len = vec![0x11, 0x91, 1, 0, 1, 0, 9, 0, 1, 2];
    wrong_len.extend(crc32c(&wrong_len).to_le_bytes());
    let mut coded = [0; 40];
    let len = cobs::encode(&wrong_len, &mut coded).unwrap();
    let mut bad_crc = status(&to_host(Kind::STATUS, 2));
    let last = bad_crc.len() - 2;
    bad_crc[last] = if bad_crc[last] == 1 { 2 } else { 1 };
    let bytes = [
        status(&to_host(Kind::STATUS, 0)),
        status(&Header { direction: Direction::ToDevice, ..to_host(Kind::GRIP, 1) }),
        status(&Header { version: 2, ..to_host(Kind::STATUS, 1) }),
        status(&Header { session: 9, ..to_host(Kind::STATUS, 1) }),
        status(&to_host(Kind(0x77), 1)),
        coded[..len].to_vec(),
        vec![0, 9, 1, 0],
        bad_crc,
        vec![7; 600],
        status(&to_host(Kind::STATUS, 2)),
    ]
    .concat();
    let (_, counters) = decode(&[&bytes], Role::Host);
    let expected = Counters {
        ok: 2,
        too_long: 1,
        cobs: 1,
        length: 1,
        crc: 1,
        echo: 1,
        version: 1,
        stale: 1,
        unknown: 1,
        duplicate: 0,
        gap: 0,
        garbage_bytes: counters.garbage_bytes,
    };
    assert_eq!(counters, expected);
}
