//! Damaged streams: both decoders give every block the same verdict.

use crate::peer::{assert_same, run};
use crate::targets::gripper::{SESSION, wire};
use crate::targets::words::{decode, hex};
use grip_link::frame::{Direction, Header};
use grip_link::message::Kind;
use rand_chacha::ChaCha8Rng;
use rand_core::{Rng as _, SeedableRng as _};

fn below(random: &mut ChaCha8Rng, end: u32) -> u32 {
    random.next_u32() % end
}

fn byte(random: &mut ChaCha8Rng) -> u8 {
    random.next_u32().to_le_bytes()[0]
}

fn frame(random: &mut ChaCha8Rng, seq: u16) -> Vec<u8> {
    let kinds = [0x01, 0x03, 0x04, 0x06, 0x10, 0x12, 0x7E, 0x81, 0x86, 0x90, 0x91, 0x94, 0xA0];
    let kind = kinds[below(random, 13) as usize];
    let direction = if (kind >= 0x80) ^ (below(random, 20) == 0) {
        Direction::ToHost
    } else {
        Direction::ToDevice
    };
    let session = if below(random, 10) == 0 { byte(random).into() } else { SESSION };
    let version = if below(random, 20) == 0 { byte(random) % 16 } else { 1 };
    let header = Header { version, ..Header::new(direction, Kind(kind), seq, session) };
    let most = if below(random, 4) == 0 { 481 } else { 40 };
    let zeros = below(random, 3) == 0;
    let payload: Vec<u8> = (0..below(random, most))
        .map(|_| if zeros && below(random, 3) > 0 { 0 } else { byte(random) })
        .collect();
    wire(&header, &payload)
}

fn damage(random: &mut ChaCha8Rng, stream: &mut Vec<u8>) {
    if stream.is_empty() {
        return;
    }
    let at = below(random, u32::try_from(stream.len()).unwrap()) as usize;
    let span = (1 + below(random, 64) as usize).min(stream.len() - at);
    match below(random, 7) {
        0 => stream[at] ^= 1 << below(random, 8),
        1 => stream[at] = byte(random),
        2 => drop(stream.drain(at..at + span.min(8))),
        3 => stream.insert(at, byte(random)),
        4 => stream[at..at + span].iter_mut().for_each(|b| *b ^= 0x5A),
        5 => drop(stream.drain(at..at + span)),
        _ => {
            let copy = stream[at..at + span].to_vec();
            stream.splice(at..at, copy);
        }
    }
}

#[test]
fn same_verdicts_on_damaged_streams() {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let (mut input, mut expected) = (String::new(), Vec::new());
    for turn in 0..6000_u32 {
        let name = if turn % 2 == 0 { "device" } else { "host" };
        let session = (turn % 50 > 0).then_some(SESSION);
        let mut seq = random.next_u32().to_le_bytes()[0].into();
        let mut stream = Vec::new();
        for _ in 0..=below(&mut random, 12) {
            stream.extend(frame(&mut random, seq));
            seq = seq.wrapping_add(if below(&mut random, 10) == 0 { 40_000 } else { 1 });
        }
        for _ in 0..below(&mut random, 5) {
            damage(&mut random, &mut stream);
        }
        if below(&mut random, 20) == 0 {
            let long = vec![7; 480 + below(&mut random, 30) as usize];
            stream.extend([&[0], &long[..], &[0]].concat());
        }
        let opened = session.map_or_else(|| "-".to_owned(), |session| format!("{session:04x}"));
        let line = format!("{name} {opened} {}", hex(&stream));
        expected.push(decode(&line));
        input += &(line + "\n");
    }
    for word in [
        "ok",
        "too_long",
        "cobs",
        "length",
        "crc",
        "echo",
        "version",
        "stale",
        "duplicate",
        "unknown",
    ] {
        assert!(expected.iter().any(|line| line.contains(word)), "no case of {word}");
    }
    assert_same("verdicts", &expected, &run("decode", &input));
}
