//! A recording, as fast as it is read.
//!
//! An MCAP file is first looked into at some hundred places, by its index, so that a first picture of all of it is there at once; then it is
//! read from its start to its end. A table is read row by row.

mod csv;
mod entries;
mod mcap;
mod preview;

use super::outlet::Outlet;
use super::spec::extension;
use crate::feed::{Feed, SourceStatus};
use crate::num;
use std::path::Path;

/// Why reading stopped before the end.
pub(super) enum Stop {
    /// The scope lets go.
    Gone,
    /// What was read stands; the sentence states what is wrong with the rest.
    Short(String),
    /// Nothing can be shown.
    Failed(String),
}

/// Reads the recording.
pub(super) fn run(file: &Path, outlet: &mut Outlet) {
    outlet.status(SourceStatus::Loading { done: 0.0 });
    let read = match extension(file).as_str() {
        "mcap" => mcap::read(file, outlet),
        _ => csv::read(file, outlet),
    };
    let status = match read {
        Ok(()) => SourceStatus::Complete { note: String::new() },
        Err(Stop::Short(note)) => SourceStatus::Complete { note },
        Err(Stop::Failed(sentence)) => SourceStatus::Failed { sentence },
        Err(Stop::Gone) => return,
    };
    outlet.status(status);
}

/// Puts items in and reports how far reading is: so many bytes, of so many.
pub(super) fn deliver(outlet: &mut Outlet, feeds: Vec<Feed>, done: (u64, u64)) -> Result<(), Stop> {
    if outlet.stops() {
        return Err(Stop::Gone);
    }
    if feeds.is_empty() {
        return Ok(());
    }
    feeds.into_iter().for_each(|feed| outlet.offer(feed));
    loading(outlet, done);
    outlet.wake();
    Ok(())
}

/// Reports how far reading is.
fn loading(outlet: &mut Outlet, done: (u64, u64)) {
    // Steps of a percent: more are not seen.
    let percent = (100 * done.0 / done.1.max(1)).min(100);
    let done = num::narrow(num::counter(percent) / 100.0);
    outlet.status(SourceStatus::Loading { done });
}
