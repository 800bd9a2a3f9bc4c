//! The vectors of protocol/vectors and lives.txt in, the files under `fuzz/seeds` out. Run it from anywhere:
//! `cargo run --manifest-path fuzz/Cargo.toml --bin seeds`. Files that start with `found-` are kept.

use grip_link_fuzz::targets::{host, script, words::unhex};
use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::Path;

/// Target and name of a seed.
type Seeds = BTreeMap<(&'static str, String), Vec<u8>>;

fn main() -> io::Result<()> {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut seeds = Seeds::new();
    valid(&fs::read_to_string(here.join("../protocol/vectors/valid.tsv"))?, &mut seeds);
    invalid(&fs::read_to_string(here.join("../protocol/vectors/invalid.tsv"))?, &mut seeds);
    clients(&fs::read_to_string(here.join("../protocol/vectors/clients.tsv"))?, &mut seeds);
    refused(&fs::read_to_string(here.join("../protocol/vectors/clients-invalid.tsv"))?, &mut seeds);
    lives(include_str!("../../lives.txt"), &mut seeds);
    let folder = here.join("seeds");
    for ((target, name), bytes) in &seeds {
        fs::create_dir_all(folder.join(target))?;
        fs::write(folder.join(target).join(name), bytes)?;
    }
    let bytes: usize = seeds.values().map(Vec::len).sum();
    println!("{} seeds, {bytes} bytes under {}", seeds.len(), folder.display());
    Ok(())
}

fn rows(text: &str) -> impl Iterator<Item = Vec<&str>> {
    text.lines().filter(|line| !line.starts_with('#')).map(|line| line.split('\t').collect())
}

/// One frame of each type, alone for `messages`; all frames of a direction in a row for `decoder` and `chunks`.
fn valid(text: &str, seeds: &mut Seeds) {
    let mut streams = [Vec::new(), Vec::new()];
    for row in rows(text) {
        let [name, _, direction, _, _, _, wire] = row[..] else { panic!("{row:?}") };
        if direction == "cobs" {
            continue;
        }
        let wire = unhex(wire);
        let to_host = usize::from(direction == "to_host");
        streams[to_host].extend(&wire);
        let body = uncobs(&wire[1..wire.len() - 1]);
        let payload = &body[8..body.len() - 4];
        if payload.len() < 300 {
            seeds.insert(("messages", name.to_owned()), [&body[1..2], payload].concat());
        }
    }
    for (role, stream) in streams.iter().enumerate() {
        let role = u8::try_from(role).unwrap();
        for (variant, bits) in [("open", 1 << 2), ("closed", 3 << 2)] {
            let name = format!("valid-{role}-{variant}");
            let part = &stream[..stream.len().min(3000)];
            seeds.insert(("decoder", name.clone()), [&[role | bits], part].concat());
            seeds.insert(("chunks", name), [&[role | bits, 7], part].concat());
        }
    }
}

/// Each broken input of the vectors, and all of them in a row.
fn invalid(text: &str, seeds: &mut Seeds) {
    let mut all = [Vec::new(), Vec::new()];
    for row in rows(text) {
        let [name, role, session, wire, ..] = row[..] else { panic!("{row:?}") };
        let host = u8::from(role == "host");
        let first = host | if session == "beef" { 0 } else { 3 << 2 };
        let wire = unhex(wire);
        all[usize::from(host)].extend(&wire);
        if wire.len() < 700 {
            seeds.insert(("decoder", name.to_owned()), [&[first], wire.as_slice()].concat());
        }
    }
    for (role, stream) in (0_u8..).zip(&all) {
        let name = format!("invalid-{role}");
        for seed in 0..4 {
            seeds.insert(
                ("chunks", format!("{name}-{seed}")),
                [&[role, seed], stream.as_slice()].concat(),
            );
        }
    }
}

/// Frames between daemon and clients: the first of each type for `messages`, all of a direction in a row for `decoder`.
fn clients(text: &str, seeds: &mut Seeds) {
    let mut streams = [Vec::new(), Vec::new()];
    let mut types = Vec::new();
    for row in rows(text) {
        let [name, _, direction, kind, _, _, wire] = row[..] else { panic!("{row:?}") };
        let wire = unhex(wire);
        streams[usize::from(direction == "to_client")].extend(&wire);
        let body = uncobs(&wire[1..wire.len() - 1]);
        if !types.contains(&kind.to_owned()) {
            types.push(kind.to_owned());
            let payload = &body[8..body.len() - 4];
            seeds.insert(("messages", name.to_owned()), [&body[1..2], payload].concat());
        }
    }
    for (role, stream) in (0_u8..).zip(&streams) {
        let part = &stream[..stream.len().min(3000)];
        let name = format!("clients-{role}");
        seeds.insert(("decoder", name), [&[LISTENS_TO_CLIENTS | role], part].concat());
    }
}

/// Bit of the first byte of an input for `decoder`: a daemon or a client listens.
const LISTENS_TO_CLIENTS: u8 = 1 << 4;

/// What daemon and clients refuse, in a row.
fn refused(text: &str, seeds: &mut Seeds) {
    let mut all = [Vec::new(), Vec::new()];
    for row in rows(text) {
        let [_, role, _, wire, ..] = row[..] else { panic!("{row:?}") };
        all[usize::from(role == "client")].extend(unhex(wire));
    }
    for (role, stream) in (0_u8..).zip(&all) {
        let name = format!("clients-invalid-{role}");
        seeds.insert(("decoder", name), [&[LISTENS_TO_CLIENTS | role], stream.as_slice()].concat());
    }
}

/// The data of a good COBS block.
fn uncobs(block: &[u8]) -> Vec<u8> {
    let mut data = Vec::new();
    let mut rest = block;
    while let Some((&code, after)) = rest.split_first() {
        let (part, next) = after.split_at(usize::from(code) - 1);
        data.extend(part);
        rest = next;
        if code < 255 && !rest.is_empty() {
            data.push(0);
        }
    }
    data
}

/// The lives and conversations of a text.
fn lives(text: &'static str, seeds: &mut Seeds) {
    let mut parts = BTreeMap::new();
    for line in text.lines().filter(|line| !line.is_empty() && !line.starts_with('#')) {
        let (head, words) = line.split_once(": ").unwrap_or_else(|| panic!("{line}"));
        let (target, name) = head.split_once(' ').unwrap_or_else(|| panic!("{line}"));
        let (target, turns) = match target {
            "device" => ("device", &script::TURNS[..]),
            "host" => ("host", &host::TURNS[..]),
            _ => {
                parts.insert(name, words);
                continue;
            }
        };
        let Some((name, count)) = name.split_once("0..") else {
            seeds.insert((target, name.to_owned()), bytes(words, &parts, turns, 0));
            continue;
        };
        for time in 0..count.parse().unwrap() {
            seeds.insert((target, format!("{name}{time}")), bytes(words, &parts, turns, time));
        }
    }
}

/// What the words state, for the `time`-th time.
fn bytes(words: &str, parts: &BTreeMap<&str, &str>, turns: &[&str], time: u8) -> Vec<u8> {
    let again = |words: &str, time| bytes(words, parts, turns, time);
    let word = |word: &str| {
        if let Some((count, part)) = word.split_once('*') {
            (0..count.parse().unwrap()).flat_map(|time| again(part, time)).collect()
        } else if let Some(part) = parts.get(word) {
            again(part, time)
        } else if let Some(place) = turns.iter().position(|turn| *turn == word) {
            vec![u8::try_from(place).unwrap()]
        } else if let Some(text) = word.strip_prefix('"') {
            text.trim_end_matches('"').as_bytes().to_vec()
        } else if let Some(hex) = word.strip_prefix("0x") {
            unhex(hex)
        } else if let Some(number) = word.strip_suffix("u16") {
            number.parse::<u16>().unwrap().to_le_bytes().to_vec()
        } else {
            vec![if word == "@" { time } else { word.parse().unwrap_or_else(|_| panic!("{word}")) }]
        }
    };
    words.split_whitespace().flat_map(word).collect()
}
