//! Failsafe rules that need a real process: gripd is killed, stopped, disturbed and outlived on a pseudo-terminal. The
//! table of all rules and their tests stands in `crates/grip-sim/tests/failsafe/main.rs`.
#![expect(clippy::unwrap_used, reason = "test code")]

mod daemon;
mod rules;
