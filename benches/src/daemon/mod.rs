//! A virtual gripper in; what gripd makes of it out: latency, lost samples, processor time, memory.
//!
//! Nothing here reads a clock of its own: the programs hand one in.

pub mod gripper;
pub mod process;
pub mod rig;
pub mod soak;
pub mod usage;

use anyhow::{Result, ensure};
use std::{env, path, path::PathBuf};

/// The daemon that is asked for, or the one beside this program.
///
/// # Errors
/// Where there is none.
pub fn program(given: Option<PathBuf>) -> Result<PathBuf> {
    let beside = || env::current_exe().map(|program| program.with_file_name("gripd"));
    let file = path::absolute(given.map_or_else(beside, Ok)?)?;
    ensure!(
        file.is_file(),
        "no program at {}; build it (cargo build --release -p gripd) or name it with --gripd",
        file.display()
    );
    Ok(file)
}
