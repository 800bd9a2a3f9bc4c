//! The command line of `gripfleet foxglove`.

use clap::Args;
use core::net::SocketAddr;

#[derive(Clone, Debug, Args)]
pub(crate) struct FoxgloveArgs {
    /// Where gripd listens: `tcp:ADDRESS:PORT` or `unix:PATH`.
    #[arg(default_value = grip_daemon::clients::Listen::DEFAULT)]
    pub(crate) address: grip_daemon::clients::Listen,
    /// Where Foxglove connects, as ws://IP:PORT; port 0 takes a free one.
    #[arg(long, value_name = "IP:PORT", default_value = "127.0.0.1:8765")]
    pub(crate) listen: SocketAddr,
    /// Show every n-th sample; 1 for all of them, which apps may be too slow for.
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u16).range(1..))]
    pub(crate) every: u16,
    /// Let other computers connect: nothing is encrypted, and nobody is asked who he is.
    #[arg(long)]
    pub(crate) allow_remote: bool,
}
