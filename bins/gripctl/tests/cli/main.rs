//! Tests of gripctl as a person or a script meets it: its arguments, files, output and exit code.
#![expect(clippy::cognitive_complexity, reason = "every assertion counts as a branch")]
#![expect(clippy::unwrap_used, clippy::panic, reason = "test code")]

mod calibrate;
mod collect;
mod daemon;
mod demo;
mod doctor;
mod estimate;
mod export;
mod grasp;
mod import;
mod learn;
mod outputs;
mod progress;
mod refusals;
mod replay;
mod run;
mod score;
mod sim;
mod splits;
mod status;
mod study;
mod surfaces;
mod tables;
mod tape;

/// What is tested.
const PROGRAM: &str = env!("CARGO_BIN_EXE_gripctl");
