//! Every seed through its target, whole, cut short and with one byte changed.

use crate::targets::{TARGETS, peers};
use std::path::{Path, PathBuf};

/// Most of what may be committed: files and bytes.
const MOST: (usize, usize) = (200, 300_000);

fn seeds(target: &str) -> Vec<(PathBuf, Vec<u8>)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/seeds");
    let seeds = peers::seeds(&folder, target);
    assert!(seeds.len() >= 5, "{} seeds of {target}", seeds.len());
    seeds
}

fn run(target: &str) {
    let (_, check) = TARGETS.iter().find(|(name, _)| *name == target).unwrap();
    for (path, seed) in seeds(target) {
        println!("{}", path.display());
        check(&seed);
        for at in (0..seed.len()).step_by(seed.len() / 24 + 1) {
            check(&seed[..at]);
            let mut changed = seed.clone();
            changed[at] ^= 1 << (at % 8);
            check(&changed);
        }
    }
}

#[test]
fn decoder() {
    run("decoder");
}

#[test]
fn chunks() {
    run("chunks");
}

#[test]
fn messages() {
    run("messages");
}

#[test]
fn device() {
    run("device");
}

#[test]
fn host() {
    run("host");
}

#[test]
fn few_and_small_seeds_are_committed() {
    let all: Vec<_> = TARGETS.iter().flat_map(|(target, _)| seeds(target)).collect();
    let bytes: usize = all.iter().map(|(_, seed)| seed.len()).sum();
    assert!(
        (all.len(), bytes) <= (MOST.0, usize::MAX) && bytes <= MOST.1,
        "{} files, {bytes} bytes",
        all.len()
    );
}
