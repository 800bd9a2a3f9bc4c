//! A recording in; what it holds out, as fast as the model takes it: nothing is dropped, the thread waits for room.
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
    outlet.put(Feed::Status(status));
    outlet.wake();
}

/// Puts items in and reports how far reading is.
pub(super) fn deliver(outlet: &mut Outlet, feeds: Vec<Feed>, done: f64) -> Result<(), Stop> {
    let some = !feeds.is_empty();
    for feed in feeds {
        if !outlet.put(feed) {
            return Err(Stop::Gone);
        }
    }
    if some {
        // Steps of a percent: more are not seen.
        #[expect(clippy::cast_possible_truncation, reason = "a share")]
        let done = ((100.0 * done).floor() / 100.0) as f32;
        outlet.progress(done);
        outlet.wake();
    }
    Ok(())
}
