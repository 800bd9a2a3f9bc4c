//! Preview of a recording by its index: where it begins and ends, and samples from some hundred places of it.

use super::{Stop, deliver};
use crate::feed::{Feed, RowBlock};
use crate::source::outlet::Outlet;
use crate::source::reported::Blocks;
use core::time::Duration;
use grip_record::mcap::{ChunkPlace, Entry, McapIndex, McapReader, Record};
use slip_core::units::Micros;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

/// Places looked into.
const PLACES: usize = 256;
/// Recordings with fewer chunks are read as a whole before anybody sees a preview.
const WORTH: usize = 64;
/// A preview takes no longer: on a slow disk it has fewer places.
const BUDGET: Duration = Duration::from_millis(1200);

type Reader = McapReader<BufReader<File>>;

/// Shows where the recording begins and ends, and some of what lies between. What cannot be read here is reported when the whole is read.
pub(super) fn show(file: &Path, index: &McapIndex, outlet: &mut Outlet) -> Result<(), Stop> {
    let Some((reader, from_us)) = begin(file) else { return Ok(()) };
    let mut looker = Looker { reader, before_us: from_us };
    let Some(to_us) = looker.end_us(&index.chunks).filter(|to_us| *to_us > from_us) else {
        // The gripper has restarted in between: where things stand on the axis is known only when they are read.
        return Ok(());
    };
    let (from_s, to_s) = (Micros(from_us).as_seconds(), Micros(to_us).as_seconds());
    deliver(outlet, vec![Feed::Extent { from_s, to_s, file: file.to_owned() }], (0, 1))?;
    if index.chunks.len() < WORTH {
        return Ok(());
    }
    let until = outlet.clock.now() + BUDGET;
    let step = index.chunks.len().div_ceil(PLACES);
    for place in index.chunks.iter().step_by(step).skip(1) {
        if outlet.clock.now() > until {
            return Ok(());
        }
        let Some(block) = looker.rows(place) else { continue };
        if !looker.goes_on(&block) {
            return Ok(());
        }
        deliver(outlet, vec![Feed::Preview(RowBlock { broken: true, ..block })], (0, 1))?;
    }
    Ok(())
}

/// A reader that has read up to the first sample, and so knows what the messages are, and the time of that sample (us).
fn begin(file: &Path) -> Option<(Reader, u64)> {
    let mut reader = McapReader::open(file).ok()?;
    loop {
        if let Entry::Message { record: Record::Sample(row), .. } = reader.next_entry().ok()?? {
            let from_us = row.sample.t.0;
            return Some((reader, from_us));
        }
    }
}

struct Looker {
    reader: Reader,
    /// Time of the last row that was seen (us).
    before_us: u64,
}

impl Looker {
    /// The samples of a chunk; `None` where it holds none, or cannot be read.
    fn rows(&mut self, place: &ChunkPlace) -> Option<RowBlock> {
        self.reader.jump(place.offset).ok()?;
        let mut blocks = Blocks::default();
        loop {
            if let Entry::Message { record: Record::Sample(row), .. } =
                self.reader.next_entry().ok()??
            {
                blocks.push(&row.sample, row.taxels);
            }
            if !self.reader.chunk_goes_on() {
                return blocks.take();
            }
        }
    }

    /// Time of the last sample (us); the last chunks may hold none.
    fn end_us(&mut self, chunks: &[ChunkPlace]) -> Option<u64> {
        let last = chunks.iter().rev().take(8).find_map(|place| self.rows(place));
        last?.times_us.last().copied()
    }

    /// Whether the block lies behind the one before.
    fn goes_on(&mut self, block: &RowBlock) -> bool {
        let Some((first_us, last_us)) = block.times_us.first().zip(block.times_us.last()) else {
            return false;
        };
        let goes_on = *first_us > self.before_us && block.times_us.is_sorted();
        self.before_us = *last_us;
        goes_on
    }
}
