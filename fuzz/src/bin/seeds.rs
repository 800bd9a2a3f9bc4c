//! The seeds of `device` and `host`, made from lives.txt. Run it from anywhere: `cargo run --manifest-path fuzz/Cargo.toml --bin seeds`.
//! Seeds of the other targets are bytes of protocol/vectors and what was found.

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
