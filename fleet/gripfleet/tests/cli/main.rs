//! Tests of the commands of gripfleet as a person or a script meets them: arguments, files, output and exit code.
#![expect(clippy::unwrap_used, clippy::panic, reason = "test code")]

#[path = "../../../../bins/gripctl/tests/cli/daemon.rs"]
mod daemon;
mod fleet;
mod fleet_archive;
mod fleet_collect;
mod foxglove;
#[path = "../../../../bins/gripctl/tests/cli/run.rs"]
#[expect(dead_code, reason = "the tests of gripctl need more of it")]
mod run;

/// What is tested.
const PROGRAM: &str = env!("CARGO_BIN_EXE_gripfleet");
