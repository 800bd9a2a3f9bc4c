//! Configuration files that must be accepted or refused, as people write them.
#![expect(clippy::unwrap_used, clippy::panic, reason = "test code")]

mod documented;
mod files;
mod layering;
