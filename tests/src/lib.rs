//! What the stories share: programs that are never stale, a program that runs.
#![expect(clippy::unwrap_used, clippy::panic, clippy::missing_panics_doc, reason = "test code")]
#![expect(clippy::must_use_candidate, reason = "what is asked to be done need not be looked at")]

mod build;
mod program;

pub use build::Build;
pub use program::{Ended, Program, command};
pub use rustix::process::Signal;

use core::time::Duration;
use std::thread;

/// After this time something that should happen has not, however busy the machine (ms).
const PATIENCE_MS: u32 = 90_000;
/// Runs of which one must go as the story demands.
const TRIES: u32 = 5;

/// Looks until it is so; `false` where it does not become so.
pub fn until(is_so: impl FnMut() -> bool) -> bool {
    looked(PATIENCE_MS, is_so)
}

/// Looks every 2 ms for so many.
#[expect(clippy::disallowed_methods, reason = "a test may wait for another program")]
fn looked(ms: u32, mut is_so: impl FnMut() -> bool) -> bool {
    (0..ms / 2).any(|_| {
        is_so() || {
            thread::sleep(Duration::from_millis(2));
            false
        }
    })
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
