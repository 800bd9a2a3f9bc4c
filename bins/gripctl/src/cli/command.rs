//! The command line of `gripctl command`, and what it shares with `gripctl fleet command`.

use clap::{Args, Subcommand};
use grip_daemon::clients::Listen;

#[derive(Debug, Args)]
pub(crate) struct CommandArgs {
    #[command(subcommand)]
    pub(crate) what: What,
    /// Where gripd listens: `tcp:ADDRESS:PORT` or `unix:PATH`.
    #[arg(long, default_value = Listen::DEFAULT, global = true)]
    pub(crate) address: Listen,
}

#[derive(Clone, Copy, Debug, Subcommand)]
pub(crate) enum What {
    /// Hold with at least this force; 0 takes it back.
    AtLeast {
        /// Force (N).
        #[arg(allow_negative_numbers = true)]
        force: f64,
    },
    /// Let go, until the command to grasp.
    Release,
    /// Close again after a release.
    Grasp,
    /// Stop in software, latched by the gripper.
    Stop,
    /// Clear the latched fault of this code, as `gripctl status` and `gripctl fleet list` show it.
    ClearFault {
        /// Four hexadecimal digits.
        #[arg(value_parser = fault)]
        code: u16,
    },
}

fn fault(text: &str) -> Result<u16, String> {
    u16::from_str_radix(text.trim_start_matches("0x"), 16)
        .map_err(|_| "expected up to four hexadecimal digits, such as 0103".to_owned())
}
