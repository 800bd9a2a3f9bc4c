//! The command line of whoever looks after many grippers.

use super::{command::What, foxglove::FoxgloveArgs};
use clap::{Args, Subcommand};
use grip_fleet::{Member, Selector};
use grip_session::config::{Site, Uid};
use std::path::PathBuf;

#[derive(Clone, Debug, Subcommand)]
pub(crate) enum Command {
    /// Say who is there and how each does.
    List(PlaceArgs),
    /// Show slips and notices of all grippers as they come, each once.
    ///
    /// Without --all, what happens from the first message of each gripper on; what was kept from before, also from an outage, needs --all.
    ///
    /// Exit codes: 0 done, 1 failed, 2 wrong arguments, 3 events are missing.
    Events(EventsArgs),
    /// Show what one gripper does: events, and its state five times a second. Exit code 1 where it is not there within 10 s.
    Tail(TailArgs),
    /// Give a model to one gripper, then to some, then to all, and take it back where it is worse.
    ///
    /// Everybody is asked first whether it would take it; where somebody would not, nobody gets it. Then the number of grasps of a stage is
    /// computed and printed. The grasps with the model are compared with those before it, of all grippers together: where objects are lost
    /// or slip more, or are held with too much force, all go back. Nobody keeps it before all have tried it. Ctrl-C takes it back; a second
    /// one leaves the trials to their lease. A gripper that nobody watches goes back by itself after the lease; the same command within it
    /// takes the roll-out up again.
    ///
    /// Exit codes: 0 all have it, 1 stopped and rolled back, 2 wrong arguments.
    Deploy(DeployArgs),
    /// Give back the model that came over the network: the one before it is in force again.
    ///
    /// On trial or accepted, whatever was counted with it. Once more leads to the one before that, and at last to the model of the
    /// configuration. Exit codes: 0 done, 1 somebody did not answer, 2 wrong arguments.
    Back(BackArgs),
    /// Let roll-outs pause at some grippers.
    ///
    /// A roll-out with one of them gives the model to nobody and judges no grasp until all of them go on. Trials that run keep their model and
    /// their lease. A pause survives a restart of gripfleet and gripd. The way back stays open. Exit codes: 0 done, 1 somebody did not
    /// answer, 2 wrong arguments.
    Pause(BackArgs),
    /// Let roll-outs go on at some grippers.
    Resume(SelectArgs),
    /// List the roll-outs that some grippers know, the oldest first: model, who and when; of each gripper stage, grasps and how it ended.
    History(SelectArgs),
    /// Command one gripper, where its gripd takes commands from the network.
    ///
    /// Its own limits hold, and it goes on to answer slips by itself. Events show when it was carried out; while a stop is latched it is
    /// not, and no event shows that. "stop" is no emergency stop.
    #[command(name = "command")]
    Control(CommandArgs),
    /// List the recordings that grippers have and give away (fleet.recordings of their gripd).
    Recordings(RecordingsArgs),
    /// Copy finished recordings of all grippers to DIR/SITE/UID/NAME.mcap.
    ///
    /// What an earlier run has copied stays as it is, what it left half done goes on, and a file that differs is never written to. Exit codes: 0 all that
    /// is given away is here, 1 failed, 2 wrong arguments, 3 something could not be fetched.
    Collect(CollectArgs),
    /// Write events and HEALTH of all grippers to MCAP files by day (UTC), DIR/2026-11-26.mcap, until it is stopped.
    ///
    /// Each event once, also over restarts, kills and outages; archive.json in DIR keeps the place. The messages are JSON with their schema. Exit codes:
    /// 0 stopped, 1 failed, 2 wrong arguments, 3 events are missing.
    Archive(ArchiveArgs),
    /// Be a router until it is stopped, where none is installed.
    Router(RouterArgs),
    /// Show a running gripd live in Foxglove, until it is stopped.
    ///
    /// Topics and schemas are those of a recording, so that one layout shows both; nobody can command the gripper this way. Exit codes: 0
    /// done, 1 failed, 2 wrong arguments, 3 something was dropped.
    Foxglove(FoxgloveArgs),
}

/// The network.
#[derive(Clone, Debug, Args)]
pub(crate) struct ReachArgs {
    /// Where a Zenoh router listens, for example tcp/10.0.0.1:7447.
    #[arg(long, value_name = "ENDPOINT", env = "GRIP_ROUTER", global = true)]
    pub(crate) router: Option<String>,
    /// Zenoh configuration file, for certificates, names, retries and the rest.
    #[arg(long, value_name = "FILE", env = "GRIP_NETWORK", global = true)]
    pub(crate) network: Option<PathBuf>,
}

/// Where the grippers are.
#[derive(Clone, Debug, Args)]
pub(crate) struct PlaceArgs {
    #[command(flatten)]
    pub(crate) reach: ReachArgs,
    /// Only grippers of this site.
    #[arg(long)]
    pub(crate) site: Option<Site>,
    /// One JSON object a line.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Clone, Debug, Args)]
pub(crate) struct EventsArgs {
    #[command(flatten)]
    pub(crate) place: PlaceArgs,
    /// Only this gripper (32 hexadecimal digits).
    #[arg(long)]
    pub(crate) uid: Option<Uid>,
    /// First everything that the grippers have kept.
    #[arg(long)]
    pub(crate) all: bool,
    /// Keep in this file what was shown, and go on there at the next start.
    #[arg(long, value_name = "FILE")]
    pub(crate) state: Option<PathBuf>,
    /// Stop after this time (s).
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub(crate) seconds: Option<f64>,
}

#[derive(Clone, Debug, Args)]
pub(crate) struct TailArgs {
    /// The gripper (32 hexadecimal digits).
    pub(crate) uid: Uid,
    #[command(flatten)]
    pub(crate) place: PlaceArgs,
    /// Stop after this time (s).
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub(crate) seconds: Option<f64>,
}

#[derive(Clone, Debug, Args)]
pub(crate) struct DeployArgs {
    /// The model file.
    pub(crate) model: PathBuf,
    /// To whom: all, a site, a gripper, SITE/GRIPPER, or several of these with commas between.
    #[arg(long, value_name = "SELECTOR")]
    pub(crate) to: Selection,
    #[command(flatten)]
    pub(crate) place: PlaceArgs,
    /// Print the number of grasps of a stage, and give the model to nobody.
    #[arg(long)]
    pub(crate) plan: bool,
    /// Grasps of a stage; computed from the two differences below, where absent.
    #[arg(long, value_name = "COUNT", conflicts_with_all = ["notice_lost", "notice_force"])]
    pub(crate) grasps: Option<u16>,
    /// Do not let the grippers replay their own recordings with the model first.
    #[arg(long)]
    pub(crate) no_replay: bool,
    /// Grasps with a slip in which the model is asked beside those in force, before a finger moves; computed where absent, 0: none.
    #[arg(long, value_name = "COUNT")]
    pub(crate) shadow: Option<u16>,
    /// Share of the grasps that may not be lost beside those that were before, noticed nine times in ten.
    #[arg(long, value_name = "SHARE", default_value_t = 0.1, allow_negative_numbers = true)]
    pub(crate) notice_lost: f64,
    /// Force over that of before that is noticed nine times in ten; more than 1.2, which is let pass.
    #[arg(long, value_name = "FACTOR", default_value_t = 1.5, allow_negative_numbers = true)]
    pub(crate) notice_force: f32,
    /// Share of the grippers in the second stage.
    #[arg(long, value_name = "SHARE", default_value_t = 0.2, allow_negative_numbers = true)]
    pub(crate) some: f64,
    /// Probability that a model that is as good is rolled back all the same.
    #[arg(long, value_name = "SHARE", default_value_t = 0.05, allow_negative_numbers = true)]
    pub(crate) error: f64,
    /// A gripper on trial that nobody has watched for so long goes back by itself (s).
    #[arg(long, value_name = "S", default_value_t = 60)]
    pub(crate) lease: u32,
    /// How long a gripper may answer nothing before the roll-out is stopped (s).
    #[arg(long, value_name = "S", default_value_t = 60.0, allow_negative_numbers = true)]
    pub(crate) patience: f64,
    /// How long a gripper that tries the model may finish no grasp before the roll-out is stopped (s).
    #[arg(long, value_name = "S", default_value_t = 3600.0, allow_negative_numbers = true)]
    pub(crate) idle: f64,
    /// Send a model that is broken or made for something else: each gripper should refuse it.
    #[arg(long)]
    pub(crate) force: bool,
    #[command(flatten)]
    pub(crate) operator: OperatorArgs,
}

#[derive(Clone, Debug, Args)]
pub(crate) struct SelectArgs {
    /// Whose: all, a site, a gripper, SITE/GRIPPER, or several of these with commas between.
    #[arg(long, value_name = "SELECTOR")]
    pub(crate) to: Selection,
    #[command(flatten)]
    pub(crate) place: PlaceArgs,
}

#[derive(Clone, Debug, Args)]
pub(crate) struct BackArgs {
    #[command(flatten)]
    pub(crate) select: SelectArgs,
    #[command(flatten)]
    pub(crate) operator: OperatorArgs,
}

/// Who orders it.
#[derive(Clone, Debug, Args)]
pub(crate) struct OperatorArgs {
    /// Who orders it, for the history.
    #[arg(
        long,
        value_name = "NAME",
        env = "USER",
        default_value = "unknown",
        hide_env_values = true,
        hide_default_value = true
    )]
    pub(crate) by: String,
}

#[derive(Clone, Debug, Args)]
pub(crate) struct CommandArgs {
    /// The gripper, as `gripfleet list` shows it: site/uid.
    pub(crate) gripper: Member,
    #[command(subcommand)]
    pub(crate) what: What,
    #[command(flatten)]
    pub(crate) place: ReachArgs,
}

#[derive(Clone, Debug, Args)]
pub(crate) struct RouterArgs {
    /// Where grippers and gripfleet reach it [default: tcp/127.0.0.1:7447, or that of the file].
    ///
    /// Without access control in the file, whoever can reach it may listen in and publish.
    #[arg(long, value_name = "ENDPOINT")]
    pub(crate) listen: Option<String>,
    /// Zenoh configuration file: certificates, who may do what, and the rest.
    #[arg(long, value_name = "FILE")]
    pub(crate) network: Option<PathBuf>,
}

#[derive(Clone, Debug, Args)]
pub(crate) struct RecordingsArgs {
    #[command(flatten)]
    pub(crate) place: PlaceArgs,
    /// Only this gripper (32 hexadecimal digits).
    #[arg(long)]
    pub(crate) uid: Option<Uid>,
}

#[derive(Clone, Debug, Args)]
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

#[derive(Clone, Debug, Args)]
pub(crate) struct ArchiveArgs {
    /// Where to write them; folders are made.
    pub(crate) directory: PathBuf,
    #[command(flatten)]
    pub(crate) reach: ReachArgs,
    /// Only grippers of this site.
    #[arg(long)]
    pub(crate) site: Option<Site>,
    /// Only this gripper (32 hexadecimal digits).
    #[arg(long)]
    pub(crate) uid: Option<Uid>,
}

/// Which grippers: `all`, a site, a gripper, SITE/UID, or several of these.
#[derive(Clone, Debug)]
pub(crate) struct Selection(pub(crate) Vec<Selector>);

impl core::str::FromStr for Selection {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        text.split(',').map(|word| selector(word.trim())).collect::<Result<_, _>>().map(Self)
    }
}

fn selector(word: &str) -> Result<Selector, String> {
    let site = |text: &str| text.parse::<Site>().map_err(|error| error.to_string());
    let uid = |text: &str| text.parse::<Uid>().map_err(|error| error.to_string());
    match word.split_once('/') {
        _ if word == "all" => Ok(Selector::default()),
        Some((place, which)) => Ok(Selector { site: Some(site(place)?), uid: Some(uid(which)?) }),
        None => match uid(word) {
            Ok(uid) => Ok(Selector { site: None, uid: Some(uid) }),
            Err(_) => Ok(Selector { site: Some(site(word)?), uid: None }),
        },
    }
}
