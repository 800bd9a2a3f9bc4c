//! The host of the Python peer does what this crate's does: on random lives and on the seeds of the fuzz target.

use crate::host_lives::Life;
use crate::host_player::play;
use crate::python::answers;
use crate::targets::host::script;
use crate::targets::peers::host_scripts;
use std::path::Path;

/// Both play the scripts; what was said.
fn same(name: &str, scripts: &[Vec<String>]) -> Vec<String> {
    let lines = scripts.concat();
    let expected = play(&lines);
    let found = answers(name, "host", &lines);
    for (number, (rust, python)) in expected.iter().zip(&found).enumerate() {
        let before = &expected[number.saturating_sub(6)..number];
        let asked = expected[..number].iter().filter(|line| line.starts_with('=')).count();
        assert_eq!(rust, python, "answer {number} to {}, after {before:#?}", lines[asked]);
    }
    assert_eq!(expected.len(), found.len());
    expected
}

fn assert_all(said: &[String], words: &[&str]) {
    for word in words {
        let count = said.iter().filter(|line| line.contains(word)).count();
        assert!(count > 2, "{word:?} in {count} lines");
    }
}

#[test]
#[ignore = "needs Python 3.9 (CONTRIBUTING.md)"]
fn the_hosts_agree_on_random_lives() {
    let lives: Vec<Vec<String>> = (0..100).map(|seed| script(&Life::new(seed).bytes())).collect();
    let said = same("host", &lives);
    assert!(said.len() > 30_000, "{}", said.len());
    assert_all(
        &said,
        &[
            "= closed",
            "= open",
            "= hello",
            "= config",
            "= stream",
            "= degraded",
            "state stream degraded",
            "state degraded stream",
            "identified 0",
            "identified 1",
            "rebooted",
            "configured 0",
            "samples",
            "status",
            "stats",
            "event",
            "clock kept",
            "done 04",
            "done 05",
            "done 12",
            "done 13",
            "refused 03 4",
            "closed requested",
            "closed no_answer",
            "closed version_mismatch",
            "closed bad_ident",
            "closed no_stylus",
            "closed unanswered",
            "closed lost",
            "reopen 100000",
            "none",
            "frame",
            "= hello 0001",
        ],
    );
}

#[test]
#[ignore = "needs Python 3.9 (CONTRIBUTING.md)"]
fn the_hosts_agree_on_every_seed() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/seeds");
    let scripts = host_scripts(&folder);
    assert!(scripts.len() > 100, "{}", scripts.len());
    let said = same("host-seeds", &scripts);
    assert_all(
        &said,
        &["= stream", "= degraded", "rebooted", "closed lost", "closed unanswered", "done 13"],
    );
}
