//! Another peer of the link as a program that answers lines with lines.

use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::OnceLock;

/// Who is asked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Peer {
    C,
    Python,
}

fn protocol(part: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../protocol").join(part)
}

/// The C program, built with the linker's own compiler driver; the variable `GRIP_C_FLAGS` adds flags such as sanitizers.
fn built() -> &'static Path {
    static PROGRAM: OnceLock<PathBuf> = OnceLock::new();
    PROGRAM.get_or_init(|| {
        let program = Path::new(env!("CARGO_TARGET_TMPDIR")).join("c-peer");
        let sources =
            ["grip_link.c", "test/init.c", "test/main.c", "test/stream.c", "test/vectors.c"];
        let result = Command::new("cc")
            .args(["-std=c99", "-Wall", "-Wextra", "-Wconversion", "-Werror", "-O2"])
            .args(std::env::var("GRIP_C_FLAGS").unwrap_or_default().split_whitespace())
            .arg("-o")
            .arg(&program)
            .args(sources.map(|source| protocol("c").join(source)))
            .output()
            .unwrap_or_else(|e| panic!("cc, which links Rust programs too, does not start: {e}"));
        assert!(result.status.success(), "{}", String::from_utf8_lossy(&result.stderr));
        program
    })
}

/// `python -m grip_link.diff`, 3.9 or newer: no package beside the standard library, no byte code left in the source tree.
fn python() -> Command {
    let mut command = Command::new("python3");
    let cache = Path::new(env!("CARGO_TARGET_TMPDIR")).join("byte-code");
    command.args(["-m", "grip_link.diff"]).env("PYTHONPYCACHEPREFIX", cache);
    command.env("PYTHONPATH", protocol("python/src").canonicalize().unwrap());
    command
}

impl Peer {
    /// What it prints for these lines in a mode.
    pub(crate) fn answers(self, mode: &str, lines: &[String]) -> Vec<String> {
        let mut command = if self == Self::C { Command::new(built()) } else { python() };
        let pipes = command.arg(mode).stdin(Stdio::piped()).stdout(Stdio::piped());
        let child = pipes.stderr(Stdio::piped()).spawn();
        let mut child = child.unwrap_or_else(|error| panic!("{self:?} does not start: {error}"));
        let text: String = lines.iter().map(|line| format!("{line}\n")).collect();
        let mut stdin = child.stdin.take().unwrap();
        let writer = std::thread::spawn(move || stdin.write_all(text.as_bytes()));
        let output = child.wait_with_output().unwrap();
        let stated = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{self:?}: {:?} {stated}", output.status);
        writer.join().unwrap().unwrap();
        String::from_utf8(output.stdout).unwrap().lines().map(str::to_owned).collect()
    }

    /// Asks for the answers and shows what led to the first that differs from this crate's.
    pub(crate) fn must_say(self, mode: &str, lines: &[String], rust: &[String]) {
        let found = self.answers(mode, lines);
        for (i, (rust_line, line)) in rust.iter().zip(&found).enumerate() {
            let before = &rust[i.saturating_sub(6)..i];
            assert_eq!(rust_line, line, "{self:?} {mode}, answer {i}, after {before:#?}");
        }
        assert_eq!(rust.len(), found.len(), "{self:?} {mode}");
    }
}
