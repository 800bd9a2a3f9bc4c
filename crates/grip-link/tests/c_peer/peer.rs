//! Builds the C test program with the linker's own compiler driver and runs it; the variable `GRIP_C_FLAGS` adds flags
//! such as sanitizers.

use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::OnceLock;

fn built() -> &'static Path {
    static PROGRAM: OnceLock<PathBuf> = OnceLock::new();
    PROGRAM.get_or_init(|| {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../protocol/c");
        let program = Path::new(env!("CARGO_TARGET_TMPDIR")).join("c-peer");
        let sources =
            ["grip_link.c", "test/init.c", "test/main.c", "test/stream.c", "test/vectors.c"];
        let result = Command::new("cc")
            .args(["-std=c99", "-Wall", "-Wextra", "-Wconversion", "-Werror", "-O2"])
            .args(std::env::var("GRIP_C_FLAGS").unwrap_or_default().split_whitespace())
            .arg("-o")
            .arg(&program)
            .args(sources.map(|source| folder.join(source)))
            .output()
            .unwrap_or_else(|e| panic!("cc, which links Rust programs too, does not start: {e}"));
        assert!(result.status.success(), "{}", String::from_utf8_lossy(&result.stderr));
        program
    })
}

/// Lines that the C program prints for `input` in a mode.
pub(crate) fn run(mode: &str, input: &str) -> Vec<String> {
    let mut child = Command::new(built())
        .arg(mode)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut stdin = child.stdin.take().unwrap();
    let text = input.to_owned();
    let writer = std::thread::spawn(move || stdin.write_all(text.as_bytes()));
    let output = child.wait_with_output().unwrap();
    writer.join().unwrap().unwrap();
    assert!(output.status.success(), "{:?}", output.status);
    String::from_utf8(output.stdout).unwrap().lines().map(str::to_owned).collect()
}

/// Compares line by line and shows what led to the first difference.
pub(crate) fn assert_same(what: &str, rust: &[String], c: &[String]) {
    for (i, (rust_line, c_line)) in rust.iter().zip(c).enumerate() {
        let from = i.saturating_sub(3);
        assert_eq!(rust_line, c_line, "{what}, line {i}, after {:#?}", &rust[from..i]);
    }
    assert_eq!(rust.len(), c.len(), "{what}");
}
