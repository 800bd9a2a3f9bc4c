//! Sources on their threads: daemons that come and go, recordings whole and broken, studies, the demo.
#![expect(clippy::unwrap_used, clippy::panic, reason = "test code")]

mod daemon;
mod demo;
mod export;
mod files;
mod rig;
mod trigger;
