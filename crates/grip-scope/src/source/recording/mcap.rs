//! Reader of an MCAP recording as a source: a picture of all of it first, then everything in it.

use super::entries::Entries;
use super::{Stop, deliver, preview};
use crate::damage::Damage;
use crate::source::outlet::Outlet;
use grip_record::mcap::{Entry, McapError, McapIndex, McapReader};
use std::fs::File;
use std::path::Path;

/// Reads the recording to its end; damaged parts are passed over, reported and counted.
pub(super) fn read(file: &Path, outlet: &mut Outlet) -> Result<(), Stop> {
    let mut reader = McapReader::open(file).map_err(|error| Stop::Failed(error.to_string()))?;
    let unreadable = |error: std::io::Error| {
        Stop::Failed(format!("{}: cannot be read ({error})", file.display()))
    };
    let input = File::open(file).map_err(unreadable)?;
    let len = input.metadata().map_err(unreadable)?.len();
    // A file without an index is read from its start all the same, which reports what is wrong with it.
    let index = McapIndex::read(&input).ok().flatten();
    if let Some(index) = &index {
        preview::show(file, index, outlet)?;
    }
    let mut entries = Entries::default();
    let mut damage = Damage::default();
    let mut seen = false;
    loop {
        let position = reader.position();
        match reader.next_entry() {
            Ok(Some(entry)) => {
                seen |= matches!(entry, Entry::Message { .. });
                entries.take_entry(&entry);
            }
            Ok(None) => break,
            Err(error) => {
                let (more, at_byte) = damage.pass(error, &mut reader, index.as_ref());
                at_byte.into_iter().for_each(|at_byte| entries.damaged(at_byte));
                if !more {
                    break;
                }
            }
        }
        deliver(outlet, entries.stream.whole(), (position, len))?;
    }
    deliver(outlet, entries.stream.take(), (1, 1))?;
    verdict(damage, seen)
}

/// What was read stands, unless nothing was.
fn verdict(damage: Damage, seen: bool) -> Result<(), Stop> {
    let parts = |first: McapError| match damage.passed {
        _ if !seen => first.to_string(),
        1 => format!("1 damaged part was passed over: {first}"),
        count => format!("{count} damaged parts were passed over, the first one: {first}"),
    };
    let reported = [damage.first.map(parts), damage.end.map(|error| error.to_string())];
    let reported: Vec<String> = reported.into_iter().flatten().collect();
    match (seen, reported.is_empty()) {
        (true, true) => Ok(()),
        (true, false) => Err(Stop::Short(reported.join("; "))),
        (false, true) => Err(Stop::Short("the recording holds no messages".to_owned())),
        (false, false) => Err(Stop::Failed(reported.join("; "))),
    }
}
