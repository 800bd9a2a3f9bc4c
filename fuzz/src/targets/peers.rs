//! Lines for the peers in C and Python, from the folder of seeds: each seed as it is, and with one byte changed here and there.

use super::{decoder, script};
use std::fs;
use std::path::{Path, PathBuf};

/// Seeds of a target with their paths, in the order of these.
pub fn seeds(folder: &Path, target: &str) -> Vec<(PathBuf, Vec<u8>)> {
    let folder = folder.join(target);
    let files = fs::read_dir(&folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
    let paths = files.map(|file| file.unwrap().path());
    let mut seeds: Vec<_> = paths.map(|path| (path.clone(), fs::read(path).unwrap())).collect();
    seeds.sort();
    seeds
}

/// A seed, and `count` copies with one byte changed.
fn variants(seed: &[u8], count: usize) -> impl Iterator<Item = Vec<u8>> {
    let step = seed.len() / count.max(1) + 1;
    let changed = (1..seed.len()).step_by(step).map(|at| {
        let mut copy = seed.to_vec();
        copy[at] ^= 1 << (at % 8);
        copy
    });
    core::iter::once(seed.to_vec()).chain(changed)
}

/// Lines for the mode `decode` of the peers.
pub fn decoder_lines(folder: &Path) -> Vec<String> {
    let all = seeds(folder, "decoder");
    all.iter()
        .flat_map(|(_, seed)| variants(seed, 30))
        .filter_map(|data| decoder::line(&data))
        .collect()
}

/// Scripts for the mode `device` of the peers.
pub fn device_scripts(folder: &Path) -> Vec<Vec<String>> {
    let all = seeds(folder, "device");
    let lives = all.iter().flat_map(|(_, seed)| variants(seed, 12));
    lives.map(|data| script::steps(&data).iter().map(script::Step::line).collect()).collect()
}
