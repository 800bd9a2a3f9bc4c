//! The tests of protocol/python in a virtual environment of their own.

use crate::python::{command, folder, interpreter, package, said};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;

/// What pip says when it reaches no package index.
const OFFLINE: [&str; 6] = [
    "Failed to establish a new connection",
    "Temporary failure in name resolution",
    "Name or service not known",
    "Network is unreachable",
    "Connection refused",
    "Read timed out",
];

/// The interpreter of a virtual environment with the package and what its tests need; `None` where there is no network.
///
/// The environment is kept for the next run and made anew when pyproject.toml changed.
fn environment(interpreter: &str) -> Option<PathBuf> {
    let (folder, package) = (folder(), package());
    let (home, stamp) = (folder.join("environment"), folder.join("installed"));
    let python = home.join("bin/python");
    let wanted = format!(
        "{}\n{}",
        package.display(),
        fs::read_to_string(package.join("pyproject.toml")).unwrap()
    );
    if python.exists() && fs::read_to_string(&stamp).is_ok_and(|text| text == wanted) {
        return Some(python);
    }
    let made = command(interpreter).args(["-m", "venv", "--clear"]).arg(&home).output().unwrap();
    assert!(
        made.status.success(),
        "python3 makes no virtual environment; on Debian install python3-venv.\n{}",
        said(&made)
    );
    let installed = install(&python, &package);
    if !installed.status.success() {
        let why = said(&installed);
        assert!(OFFLINE.iter().any(|words| why.contains(words)), "pip cannot install:\n{why}");
        println!("SKIPPED: no network, pip reaches no package index");
        return None;
    }
    fs::write(&stamp, wanted).unwrap();
    Some(python)
}

fn install(python: &Path, package: &Path) -> Output {
    command(python)
        .args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--retries", "1"])
        .args(["--editable", &format!("{}[test]", package.display())])
        .output()
        .unwrap()
}

#[test]
fn its_own_tests_pass() {
    let Some(interpreter) = interpreter() else { return };
    let Some(python) = environment(interpreter) else { return };
    let tests = command(python)
        .args(["-m", "pytest", "-q", "-p", "no:cacheprovider"])
        .current_dir(package())
        .env("PYTHONUNBUFFERED", "1")
        .output()
        .unwrap();
    println!("{}", said(&tests));
    assert!(tests.status.success());
}
