//! The command line of `gripctl fleet`.

use clap::{Args, Subcommand};
use grip_host::config::{Site, Uid};
use std::path::PathBuf;

#[derive(Debug, Args)]
pub(crate) struct FleetArgs {
    #[command(subcommand)]
    pub(crate) command: FleetCommand,
}

#[derive(Debug, Subcommand)]
pub(crate) enum FleetCommand {
    /// Say who is there and how each does.
    List(ListArgs),
    /// Show slips and news of all grippers as they come, each once.
    ///
    /// Exit codes: 0 done, 1 failed, 2 wrong arguments, 3 events are missing.
    Events(EventsArgs),
    /// Show what one gripper does: events, and its state five times a second.
    Tail(TailArgs),
    /// List the recordings that grippers have and give away (fleet.recordings of their gripd).
    Recordings(RecordingsArgs),
    /// Copy finished recordings of all grippers to DIR/SITE/UID/NAME.mcap.
    ///
    /// What an earlier run has copied stays as it is, what it left half done goes on, and a file that differs is never written to. Exit codes: 0 all that
    /// is given away is here, 1 failed, 2 wrong arguments, 3 something could not be fetched.
    Collect(CollectArgs),
    /// Be a router until it is stopped, where none is installed.
    Router(RouterArgs),
}

/// Where the grippers are.
#[derive(Debug, Args)]
pub(crate) struct PlaceArgs {
    /// Where a Zenoh router listens, for example tcp/10.0.0.1:7447.
    #[arg(long, value_name = "ENDPOINT", env = "GRIP_ROUTER")]
    pub(crate) router: Option<String>,
    /// Zenoh configuration file, for names, retries and the rest.
    #[arg(long, value_name = "FILE", env = "GRIP_NETWORK")]
    pub(crate) network: Option<PathBuf>,
    /// Only grippers of this site.
    #[arg(long)]
    pub(crate) site: Option<Site>,
    /// One JSON object a line.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct ListArgs {
    #[command(flatten)]
    pub(crate) place: PlaceArgs,
}

#[derive(Debug, Args)]
pub(crate) struct EventsArgs {
    #[command(flatten)]
    pub(crate) place: PlaceArgs,
    /// Only this gripper (32 hexadecimal digits).
    #[arg(long)]
    pub(crate) uid: Option<Uid>,
    /// First everything that the grippers have kept.
    #[arg(long)]
    pub(crate) all: bool,
    /// Stop after this time (s).
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub(crate) seconds: Option<f64>,
}

#[derive(Debug, Args)]
pub(crate) struct TailArgs {
    /// The gripper (32 hexadecimal digits).
    pub(crate) uid: Uid,
    #[command(flatten)]
    pub(crate) place: PlaceArgs,
    /// Stop after this time (s).
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub(crate) seconds: Option<f64>,
}

#[derive(Debug, Args)]
pub(crate) struct RouterArgs {
    /// Where grippers and gripctl reach it; whoever can, may listen in and publish.
    #[arg(long, value_name = "ENDPOINT", default_value = "tcp/127.0.0.1:7447")]
    pub(crate) listen: String,
}

#[derive(Debug, Args)]
pub(crate) struct RecordingsArgs {
    #[command(flatten)]
    pub(crate) place: PlaceArgs,
    /// Only this gripper (32 hexadecimal digits).
    #[arg(long)]
    pub(crate) uid: Option<Uid>,
}

#[derive(Debug, Args)]
pub(crate) struct CollectArgs {
    /// Where to copy them; folders are made.
    pub(crate) directory: PathBuf,
    #[command(flatten)]
    pub(crate) place: PlaceArgs,
    /// Only this gripper (32 hexadecimal digits).
    #[arg(long)]
    pub(crate) uid: Option<Uid>,
    /// Only what was written to in the last HOURS.
    #[arg(long, value_name = "HOURS", allow_negative_numbers = true)]
    pub(crate) since: Option<f64>,
    /// How long to wait for a gripper that has stopped to answer (s).
    #[arg(long, value_name = "S", default_value_t = 30.0, allow_negative_numbers = true)]
    pub(crate) patience: f64,
}
