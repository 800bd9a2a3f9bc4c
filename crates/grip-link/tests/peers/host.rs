//! The host of the Python peer does what this crate's does: on random lives and on the seeds of the fuzz target.

use crate::host_lives::Life;
use crate::peer::Peer;
use crate::targets::host::talk;
use crate::targets::host_script::Talk;
use crate::targets::peers::host_talks;
use std::path::Path;

/// Both have these talks; what was said.
fn same(talks: Vec<Talk>) -> Vec<String> {
    let (lines, said): (Vec<_>, Vec<_>) =
        talks.into_iter().map(|talk| (talk.lines, talk.said)).unzip();
    let said = said.concat();
    Peer::Python.must_say("host", &lines.concat(), &said);
    said
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
    let said = same((0..100).map(|seed| talk(&Life::new(seed).bytes())).collect());
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
    let talks = host_talks(&folder);
    assert!(talks.len() > 100, "{}", talks.len());
    let said = same(talks);
    assert_all(
        &said,
        &["= stream", "= degraded", "rebooted", "closed lost", "closed unanswered", "done 13"],
    );
}
