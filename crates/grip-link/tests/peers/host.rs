//! The host of the Python peer does what this crate's does: on random lives and on the seeds of the fuzz target.

use crate::host_lives::Life;
use crate::peer::Peer;
use crate::targets::host::talk;
use crate::targets::host_script::Talk;
use crate::targets::peers::host_talks;
use std::path::Path;

/// Both have these talks; what was said.
fn same(talks: Vec<Talk>) -> Vec<String> {
    let (lines, stated): (Vec<_>, Vec<_>) =
        talks.into_iter().map(|talk| (talk.lines, talk.stated)).unzip();
    let stated = stated.concat();
    Peer::Python.must_say("host", &lines.concat(), &stated);
    stated
}

fn assert_all(stated: &[String], words: &[&str]) {
    for word in words {
        let count = stated.iter().filter(|line| line.contains(word)).count();
        assert!(count > 2, "{word:?} in {count} lines");
    }
}

#[test]
#[ignore = "needs Python 3.9 (CONTRIBUTING.md)"]
fn the_hosts_agree_on_random_lives() {
    let stated = same((0..100).map(|seed| talk(&Life::new(seed).bytes())).collect());
    assert!(stated.len() > 30_000, "{}", stated.len());
    assert_all(
        &stated,
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
    let stated = same(talks);
    assert_all(
        &stated,
        &["= stream", "= degraded", "rebooted", "closed lost", "closed unanswered", "done 13"],
    );
}
