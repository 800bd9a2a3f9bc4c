//! `gripfleet foxglove`: live view of the gripd at an address for any number of Foxglove apps, until it is stopped.

mod complaints;
mod talk;

use super::stopped;
use crate::{
    cli::foxglove::FoxgloveArgs,
    clock::{self, Clock},
    output,
};
use anyhow::bail;
use complaints::Complaints;
use core::{
    sync::atomic::{AtomicBool, Ordering},
    time::Duration,
};
use grip_daemon::clients::Listen;
use grip_fleet::live::{ServeError, Server, Translator};
use grip_port::Backoff;
use grip_session::exit::{Exit, WrongArgument};
use std::{sync::Arc, thread};
use talk::Talk;

/// Pauses between attempts to reach gripd grow from the one to the other.
const FIRST: Duration = Duration::from_millis(250);
const LONGEST: Duration = Duration::from_secs(5);
/// Longest wait between two looks at the signals.
const LOOK: Duration = Duration::from_millis(50);
/// Apps are left alone after this time at the end.
const FAREWELL: Duration = Duration::from_secs(2);
/// What is reported where other computers may connect.
const REMOTE: &str = "other computers can connect: nothing is encrypted and nobody is asked who he is; whoever reaches this port sees everything that the gripper sends";

pub(crate) fn run(args: &FoxgloveArgs) -> anyhow::Result<Exit> {
    if args.address == Listen::Off {
        bail!(WrongArgument("off: give the address where gripd listens".to_owned()));
    }
    let stopped = stopped()?;
    let complaints = Complaints::listen()?;
    let server = serve(args)?;
    if !args.listen.ip().to_canonical().is_loopback() {
        eprintln!("gripfleet: {REMOTE}");
    }
    output::line(&format!("Foxglove opens ws://{}", server.address()))?;
    let wall = Clock::start();
    let mut view = View { args, server, stopped, complaints, wall, lost: false };
    view.show();
    let lost = view.lost;
    view.server.stop(FAREWELL);
    Ok(if lost { Exit::DataLost } else { Exit::Done })
}

fn serve(args: &FoxgloveArgs) -> anyhow::Result<Server> {
    let name = format!("gripd at {}", args.address);
    Server::start(args.listen, args.allow_remote, &name).map_err(|error| match error {
        ServeError::Remote(_) => {
            WrongArgument(format!("--listen {error}; --allow-remote says that this is meant"))
                .into()
        }
        other => other.into(),
    })
}

/// What stays over all connections to the daemon.
struct View<'a> {
    args: &'a FoxgloveArgs,
    server: Server,
    stopped: Arc<AtomicBool>,
    complaints: Complaints,
    wall: Clock,
    lost: bool,
}

impl View<'_> {
    /// Shows what the daemon reports, however often it goes and comes.
    fn show(&mut self) {
        let mut translator = Translator::default();
        let mut backoff = Backoff::new(FIRST, LONGEST);
        let mut before = String::new();
        while !self.is_stopped() {
            let mut talk = Talk::new(self, &mut translator);
            let reason = talk.run();
            let was_greeted = talk.was_greeted();
            if self.is_stopped() {
                break;
            }
            if was_greeted {
                backoff.reset();
                translator.lost(&reason, self.wall.wall_ns(), &mut |topic, log_ns, bytes| {
                    self.server.publish(topic, log_ns, bytes);
                });
            }
            // New apps are informed as well; people once.
            self.server.warn("daemon", &format!("{reason}; trying again"));
            if was_greeted || reason != before {
                eprintln!("gripfleet: {reason}; trying again");
            }
            before = reason;
            self.pause(backoff.pause());
        }
    }

    fn is_stopped(&self) -> bool {
        self.stopped.load(Ordering::Relaxed)
    }

    fn pause(&mut self, time: Duration) {
        let end = clock::monotonic() + time;
        while !self.is_stopped() {
            let left = end.saturating_sub(clock::monotonic());
            if left.is_zero() {
                break;
            }
            thread::park_timeout(left.min(LOOK));
            self.pass_on_complaints();
        }
    }

    /// Informs people and apps that something is missing.
    fn missing(&mut self, name: &str, text: &str) {
        self.lost = true;
        eprintln!("gripfleet: {text}");
        self.server.warn(name, text);
    }

    fn pass_on_complaints(&mut self) {
        while let Some(complaint) = self.complaints.next() {
            match complaint {
                complaints::Complaint::TooSlow => self.missing(
                    "slow",
                    "an app takes less than comes, messages for it are dropped: --every N sends fewer samples",
                ),
                complaints::Complaint::Other(text) => eprintln!("gripfleet: {text}"),
            }
        }
    }
}
