//! What the stories share: programs that are never stale, a program that runs.
#![expect(clippy::unwrap_used, clippy::panic, clippy::missing_panics_doc, reason = "test code")]

mod build;
mod program;

pub use build::Build;
pub use program::{Ended, Program};
pub use rustix::process::Signal;

use core::time::Duration;
use std::thread;

/// Looks of 20 ms after which something that should happen has not, however busy the machine.
const LOOKS: u32 = 4500;
/// Runs of which one must go as the story demands.
const TRIES: u32 = 5;

/// Looks until it is so; `false` where it does not become so.
pub fn until(mut is_so: impl FnMut() -> bool) -> bool {
    (0..LOOKS).any(|_| is_so() || pause())
}

#[expect(clippy::disallowed_methods, reason = "a test may wait for another program")]
fn pause() -> bool {
    thread::sleep(Duration::from_millis(20));
    false
}

/// What the first run gives that goes well. A machine that stops the programs for longer than an object takes to fall drops it: they may try
/// again.
pub fn in_one_of_some_runs<T>(mut run: impl FnMut() -> Result<T, String>) -> T {
    for _ in 0..TRIES {
        match run() {
            Ok(good) => return good,
            Err(why) => eprintln!("once more: {why}"),
        }
    }
    panic!("none of {TRIES} runs went well");
}

/// A folder of its own for a story.
#[must_use]
pub fn folder() -> tempfile::TempDir {
    tempfile::tempdir().unwrap()
}
