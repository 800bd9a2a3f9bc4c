//! The Python of this machine, 3.9 or newer.

use std::fs::{self, File};
use std::path::Path;
use std::process::{Command, Stdio};

/// Lines of stdout of `python -m grip_link.diff MODE` for these lines, which go through a file of that name. It needs no
/// package beside the standard library, and leaves no byte code in the source tree.
pub(crate) fn answers(file: &str, mode: &str, lines: &[String]) -> Vec<String> {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../protocol/python/src");
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("python-peer");
    fs::create_dir_all(&folder).unwrap();
    let input = folder.join(format!("{file}.txt"));
    fs::write(&input, lines.join("\n") + "\n").unwrap();
    let done = Command::new("python3")
        .args(["-m", "grip_link.diff", mode])
        .env("PYTHONPATH", source.canonicalize().unwrap())
        .env("PYTHONPYCACHEPREFIX", folder.join("byte-code"))
        .stdin(Stdio::from(File::open(&input).unwrap()))
        .output()
        .unwrap_or_else(|error| panic!("no python3 on this machine: {error}"));
    let text = |bytes: Vec<u8>| String::from_utf8_lossy(&bytes).into_owned();
    let (out, err) = (text(done.stdout), text(done.stderr));
    assert!(done.status.success(), "{}: {err}", done.status);
    out.lines().map(str::to_owned).collect()
}
