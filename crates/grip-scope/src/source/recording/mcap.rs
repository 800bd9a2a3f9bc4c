//! An MCAP recording in; a picture of all of it first, then everything in it, out.

use super::entries::Entries;
use super::{Stop, deliver, preview};
use crate::feed::Feed;
use crate::source::outlet::Outlet;
use grip_record::mcap::{Entry, McapError, McapIndex, McapReader};
use std::fs::File;
use std::io::{Read, Seek};
use std::path::Path;

/// Reads the recording to its end; damaged parts are passed over, told and counted.
pub(super) fn read(file: &Path, outlet: &mut Outlet) -> Result<(), Stop> {
    let failed = |error: &dyn core::fmt::Display| Stop::Failed(error.to_string());
    let mut reader = McapReader::open(file).map_err(|error| failed(&error))?;
    let unreadable = |error: std::io::Error| {
        Stop::Failed(format!("{}: cannot be read ({error})", file.display()))
    };
    let input = File::open(file).map_err(unreadable)?;
    let len = input.metadata().map_err(unreadable)?.len();
    // A file without an index is read from its start all the same, which tells what is wrong with it.
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
                let more = go_on(&mut reader, &error, index.as_ref());
                if let Some(at_byte) = error.damaged_at().filter(|_| more && damage.is_new(&error))
                {
                    entries.damaged(at_byte);
                }
                damage.take(error, !more);
                if !more {
                    break;
                }
            }
        }
        if entries.is_due() {
            deliver(outlet, entries.take(), share(position, len))?;
        }
    }
    let rest: Vec<Feed> = entries.take();
    deliver(outlet, rest, 1.0)?;
    damage.verdict(seen)
}

/// Goes to what can be read behind the damage, by the index where nothing else tells it; `false` where nothing can be.
fn go_on<R: Read + Seek>(
    reader: &mut McapReader<R>,
    error: &McapError,
    index: Option<&McapIndex>,
) -> bool {
    let Some(at_byte) = error.damaged_at() else { return false };
    let next = || index?.chunks.iter().find(|chunk| chunk.offset > at_byte);
    reader.goes_on() || next().is_some_and(|chunk| reader.jump(chunk.offset).is_ok())
}

/// What cannot be read.
#[derive(Default)]
struct Damage {
    first: Option<McapError>,
    last_at: Option<u64>,
    /// Damaged parts that were passed over.
    passed: u32,
    /// Why reading stopped before the end.
    end: Option<McapError>,
}

impl Damage {
    /// Whether it is another part than the one before: each message in a damaged one is told.
    fn is_new(&self, error: &McapError) -> bool {
        error.damaged_at().is_some_and(|at| self.last_at != Some(at))
    }

    fn take(&mut self, error: McapError, ends: bool) {
        let new = self.is_new(&error);
        self.last_at = error.damaged_at();
        if ends {
            self.end = Some(error);
            return;
        }
        self.passed += u32::from(new);
        self.first.get_or_insert(error);
    }

    /// What was read stands, unless nothing was.
    fn verdict(self, seen: bool) -> Result<(), Stop> {
        let parts = |first: McapError| match self.passed {
            1 => format!("1 damaged part was passed over: {first}"),
            count => format!("{count} damaged parts were passed over, the first one: {first}"),
        };
        let told = [self.first.map(parts), self.end.map(|error| error.to_string())];
        let told: Vec<String> = told.into_iter().flatten().collect();
        match (seen, told.is_empty()) {
            (true, true) => Ok(()),
            (true, false) => Err(Stop::Short(told.join("; "))),
            (false, true) => Err(Stop::Short("the recording holds no messages".to_owned())),
            (false, false) => Err(Stop::Failed(told.join("; "))),
        }
    }
}

#[expect(clippy::cast_precision_loss, reason = "a share of a file")]
fn share(position: u64, len: u64) -> f64 {
    (position as f64 / len.max(1) as f64).min(1.0)
}
