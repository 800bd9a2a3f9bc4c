//! The command line of gripmon-fleet. The names are a contract.

use clap::Parser;
use grip_session::config::Site;
use gripmon::cli::WindowArgs;
use std::path::PathBuf;

/// Shows all grippers of a network in a table, and the one that is opened as gripmon does.
///
/// Exit codes: 0 done, 1 failed, 2 wrong arguments or configuration.
#[derive(Clone, Debug, Parser)]
#[command(name = "gripmon-fleet", version)]
pub struct Cli {
    /// Where a Zenoh router listens, for example tcp/10.0.0.1:7447.
    #[arg(value_name = "ENDPOINT", env = "GRIP_ROUTER")]
    pub router: Option<String>,
    /// Zenoh configuration file, for names, retries and the rest; without ENDPOINT its endpoints too.
    #[arg(long, value_name = "FILE", env = "GRIP_NETWORK")]
    pub network: Option<PathBuf>,
    /// Only grippers of this site.
    #[arg(long)]
    pub site: Option<Site>,
    /// The window.
    #[command(flatten)]
    pub window: WindowArgs,
}
