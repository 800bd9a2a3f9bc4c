//! Tests of the commands of gripfleet as a person or a script meets them: arguments, files, output and exit code.
#![expect(clippy::unwrap_used, clippy::panic, reason = "test code")]

mod alone;
#[path = "../../../../bins/gripctl/tests/cli/daemon.rs"]
mod daemon;
mod fleet;
mod fleet_archive;
mod fleet_collect;
mod foxglove;
#[path = "../../../grip-fleet/tests/rig/mod.rs"]
#[expect(dead_code, reason = "the tests of grip-fleet need more of it")]
mod rig;
#[path = "../../../../bins/gripctl/tests/cli/run.rs"]
#[expect(dead_code, reason = "the tests of gripctl need more of it")]
mod run;

/// What is tested.
const PROGRAM: &str = env!("CARGO_BIN_EXE_gripfleet");
