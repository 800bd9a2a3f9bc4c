//! The command line of gripfleet. The names are a contract.

#[path = "../../../../bins/gripctl/src/cli/command.rs"]
pub(crate) mod command;
pub(crate) mod fleet;
pub(crate) mod foxglove;

use clap::Parser;
use std::path::PathBuf;

/// Makes the gripper of a gripd one of many: events, models, commands and recordings over a Zenoh network, and a node of
/// ROS 2.
///
/// Without a command it reads gripd's configuration, of which the table `fleet` is for it, and connects to gripd as any other
/// client. It waits for a gripd that is not there yet, or starts again. The commands are the other end: they list many grippers,
/// follow their events, roll out models.
///
/// Exit codes: 0 done, 1 failed, 2 wrong arguments or configuration.
#[derive(Clone, Debug, Parser)]
#[command(name = "gripfleet", version, args_conflicts_with_subcommands = true)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Option<fleet::Command>,
    /// Configuration file of gripd; ./gripd.toml, the user's and /etc/gripd/gripd.toml are not read then.
    #[arg(long, env = "GRIPD_CONFIG", value_name = "FILE")]
    pub(crate) config: Option<PathBuf>,
    /// Where gripd listens: tcp:IP:PORT or unix:PATH.
    #[arg(long, env = "GRIPD_LISTEN", value_name = "ADDRESS")]
    pub(crate) listen: Option<String>,
    /// Where gripd records; with fleet.recordings these are given away.
    #[arg(long, env = "GRIPD_RECORD", value_name = "FILE")]
    pub(crate) record: Option<PathBuf>,
    /// How much to report on standard error: error, warn, info or debug.
    #[arg(long, env = "GRIPD_LOG", value_name = "LEVEL")]
    pub(crate) log_level: Option<String>,
    /// Check the configuration and stop.
    #[arg(long)]
    pub(crate) check_config: bool,
}
