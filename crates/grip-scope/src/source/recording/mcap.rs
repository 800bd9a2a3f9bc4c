//! An MCAP recording in; a picture of all of it first, then everything in it, out.

use super::entries::Entries;
use super::{Stop, deliver, preview};
use crate::feed::Feed;
use crate::source::outlet::Outlet;
use grip_record::mcap::{Entry, McapError, McapIndex, McapReader};
use std::fs::File;
use std::path::Path;

/// Reads the recording to its end, or as far as it is whole.
pub(super) fn read(file: &Path, outlet: &mut Outlet) -> Result<(), Stop> {
    let failed = |error: &dyn core::fmt::Display| Stop::Failed(error.to_string());
    let mut reader = McapReader::open(file).map_err(|error| failed(&error))?;
    let unreadable = |error: std::io::Error| {
        Stop::Failed(format!("{}: cannot be read ({error})", file.display()))
    };
    let input = File::open(file).map_err(unreadable)?;
    let len = input.metadata().map_err(unreadable)?.len();
    // A file without an index is read from its start all the same, which tells what is wrong with it.
    if let Ok(Some(index)) = McapIndex::read(&input) {
        preview::show(file, &index, outlet)?;
    }
    let mut entries = Entries::default();
    let mut seen = false;
    loop {
        let position = reader.position();
        let entry = match reader.next_entry() {
            Ok(Some(entry)) => entry,
            Ok(None) => break,
            Err(error) => {
                deliver(outlet, entries.take(), share(position, len))?;
                return Err(stop(&error, seen));
            }
        };
        seen |= matches!(entry, Entry::Message { .. });
        entries.take_entry(&entry);
        if entries.is_due() {
            deliver(outlet, entries.take(), share(position, len))?;
        }
    }
    let rest: Vec<Feed> = entries.take();
    deliver(outlet, rest, 1.0)?;
    if seen {
        return Ok(());
    }
    Err(Stop::Short("the recording holds no messages".to_owned()))
}

/// What was read stands, unless nothing was.
fn stop(error: &McapError, seen: bool) -> Stop {
    if seen { Stop::Short(error.to_string()) } else { Stop::Failed(error.to_string()) }
}

#[expect(clippy::cast_precision_loss, reason = "a share of a file")]
fn share(position: u64, len: u64) -> f64 {
    (position as f64 / len.max(1) as f64).min(1.0)
}
