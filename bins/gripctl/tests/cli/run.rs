//! Run of gripctl with arguments: what it printed and how it ended.

use serde_json::Value;
use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
};
use stories::{Ended, Program};

/// A run that has ended.
#[derive(Debug)]
pub(crate) struct Ran {
    pub(crate) code: i32,
    pub(crate) out: String,
    pub(crate) err: String,
}

/// Runs gripctl in `folder` with the words of `line` to its end; a panic is never one.
pub(crate) fn gripctl(folder: impl AsRef<Path>, line: impl AsRef<str>) -> Ran {
    let args: Vec<&str> = line.as_ref().split_whitespace().collect();
    run(folder.as_ref(), &args)
}

/// Runs the program of these tests in `folder` with `args` to its end; a panic is never one.
pub(crate) fn run(folder: &Path, args: &[&str]) -> Ran {
    let program = Path::new(crate::PROGRAM);
    let Ended { code, out, err } = Program::start(program, folder, args).ended();
    Ran { code, out, err }
}

/// Writes a file.
pub(crate) fn put(folder: impl AsRef<Path>, name: impl AsRef<Path>, content: impl AsRef<[u8]>) {
    fs::write(folder.as_ref().join(name), content).unwrap();
}

/// The text of a file.
pub(crate) fn read(folder: impl AsRef<Path>, name: impl AsRef<Path>) -> String {
    fs::read_to_string(folder.as_ref().join(name)).unwrap()
}

impl Ran {
    #[track_caller]
    pub(crate) fn done(self) -> Self {
        assert_eq!(self.code, 0, "{self:?}");
        self
    }

    /// As [`Ended::refused`].
    #[track_caller]
    pub(crate) fn refused(self, code: i32, words: &[&str]) -> Self {
        let Self { code: own, out, err } = self;
        let Ended { code, out, err } = Ended { code: own, out, err }.refused(code, words);
        Self { code, out, err }
    }

    /// The last line of standard output as JSON, of a run that is done.
    #[track_caller]
    pub(crate) fn last(self) -> Value {
        self.done().json().pop().unwrap()
    }

    /// The lines of standard output as JSON.
    pub(crate) fn json(&self) -> Vec<Value> {
        self.out.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
    }
}

#[track_caller]
pub(crate) fn number(value: &Value, name: &str) -> f64 {
    value[name].as_f64().unwrap_or_else(|| panic!("no number {name} in {value}"))
}

/// Even noise from -0.5 to 0.5, the same every time.
pub(crate) fn noise(mut seed: u32) -> impl FnMut() -> f64 {
    move || {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(seed >> 8) / f64::from(1 << 24) - 0.5
    }
}

/// Nearly normal noise of the deviation 1.
pub(crate) fn normal(seed: u32) -> impl FnMut() -> f64 {
    let mut even = noise(seed);
    move || (0..12).map(|_| even()).sum()
}

/// A WAV of one channel of 16 bits.
pub(crate) fn wav(rate_hz: u32, samples: impl Iterator<Item = f64>) -> Vec<u8> {
    #[expect(clippy::cast_possible_truncation, reason = "saturates, as a microphone does")]
    let data: Vec<u8> = samples.flat_map(|sample| (sample as i16).to_le_bytes()).collect();
    let len = u32::try_from(data.len()).unwrap();
    let [all, rate, bytes, len] = [36 + len, rate_hz, 2 * rate_hz, len].map(u32::to_le_bytes);
    let head = [b"RIFF", &all, &b"WAVEfmt \x10\0\0\0\x01\0\x01\0"[..], &rate, &bytes];
    [&head.concat()[..], b"\x02\0\x10\0data", &len, &data].concat()
}

/// The files of a folder, those in its folders too, with what they hold.
pub(crate) fn content(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut all = BTreeMap::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        match path.is_dir() {
            true => all.extend(content(&path)),
            false => {
                all.insert(path.display().to_string(), fs::read(&path).unwrap_or_default());
            }
        }
    }
    all
}

/// The folder `name` of the real recordings, which are no part of the project.
pub(crate) fn real_data(name: &str) -> PathBuf {
    let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data");
    let folder = std::env::var_os("GRIP_DATA").map_or_else(beside, PathBuf::from).join(name);
    assert!(folder.is_dir(), "no folder {}: set GRIP_DATA", folder.display());
    folder
}
