//! The Python of this machine, if it has one.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

const OLDEST: &str = "import sys; sys.exit(sys.version_info < (3, 9))";

/// protocol/python.
pub(crate) fn package() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../protocol/python").canonicalize().unwrap()
}

/// A folder for files of this test program.
pub(crate) fn folder() -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("python-peer");
    fs::create_dir_all(&folder).unwrap();
    folder
}

/// A command that leaves no byte code in the source tree.
pub(crate) fn command(program: impl AsRef<Path>) -> Command {
    let mut command = Command::new(program.as_ref());
    command.env("PYTHONPYCACHEPREFIX", folder().join("byte-code")).env_remove("PYTHONPATH");
    command
}

/// The interpreter; `None`, and the reason printed, where there is none of 3.9 or newer.
pub(crate) fn interpreter() -> Option<&'static str> {
    let runs = command("python3").args(["-c", OLDEST]).status();
    match runs {
        Ok(status) if status.success() => Some("python3"),
        Ok(_) => {
            println!("SKIPPED: python3 is older than 3.9");
            None
        }
        Err(error) => {
            println!("SKIPPED: no python3 on this machine ({error})");
            None
        }
    }
}

/// Lines of stdout of `python -m grip_link.diff MODE` for these lines, which go through a file of that name. It needs no
/// package beside the standard library.
pub(crate) fn answers(interpreter: &str, file: &str, mode: &str, lines: &[String]) -> Vec<String> {
    let input = folder().join(format!("{file}.txt"));
    fs::write(&input, lines.join("\n") + "\n").unwrap();
    let done = command(interpreter)
        .args(["-m", "grip_link.diff", mode])
        .env("PYTHONPATH", package().join("src"))
        .stdin(Stdio::from(File::open(&input).unwrap()))
        .output()
        .unwrap();
    assert!(done.status.success(), "{}", said(&done));
    String::from_utf8(done.stdout).unwrap().lines().map(str::to_owned).collect()
}

/// Both outputs as text.
pub(crate) fn said(output: &Output) -> String {
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    format!("{}\n{}{}", output.status, text(&output.stdout), text(&output.stderr))
}
