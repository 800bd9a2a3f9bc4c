//! The host of the Python peer does what this crate's does, on the seeds of the fuzz target and on seeds with a byte changed.

use crate::peer::Peer;
use crate::targets::host_script::Talk;
use crate::targets::peers::host_talks;
use std::path::Path;

/// What must be said in some of the talks.
const SAID: [&str; 33] = [
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
];

#[test]
#[ignore = "needs Python 3.9 (CONTRIBUTING.md)"]
fn the_hosts_agree_on_every_seed() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/seeds");
    let talks = host_talks(&folder).into_iter().map(|Talk { lines, stated }| (lines, stated));
    let (lines, stated): (Vec<_>, Vec<_>) = talks.unzip();
    assert!(lines.len() > 400, "{}", lines.len());
    let stated = stated.concat();
    for word in SAID {
        let count = stated.iter().filter(|line| line.contains(word)).count();
        assert!(count > 2, "{word:?} in {count} lines");
    }
    Peer::Python.must_say("host", &lines.concat(), &stated);
}
