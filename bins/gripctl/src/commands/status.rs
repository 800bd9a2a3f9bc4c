//! `gripctl status`: how the gripd at an address does, once, every second, or event by event.

use super::{clock, command::PATIENCE};
use crate::{cli::StatusArgs, output};
use anyhow::bail;
use core::{
    sync::atomic::{AtomicBool, Ordering},
    time::Duration,
};
use grip_daemon::client::{self, Client, Report};
use grip_daemon::clients::Listen;
use grip_link::message::Versions;
use grip_link::message::daemon::{NoticeKind, Subscribe, ToClient, Topics};
use grip_port::nonce;
use grip_session::exit::{Exit, WrongArgument};
use grip_session::status::EventReport;

/// Time between two questions of `--watch`.
const INTERVAL: Duration = Duration::from_secs(1);
/// Longest wait between two looks at the signals.
const LOOK: Duration = Duration::from_millis(100);

pub(crate) fn run(args: &StatusArgs) -> anyhow::Result<Exit> {
    if args.address == Listen::Off {
        bail!(WrongArgument("off: give the address where gripd listens".to_owned()));
    }
    let stopped = output::stopped()?;
    let topics = if args.events { Topics::SLIP.and(Topics::NEWS) } else { Topics::default() };
    let wanted = Subscribe { versions: Versions::OURS, topics, every_nth: 0, state_ms: 0 };
    let mut client = Client::connect(&args.address, nonce(), wanted, PATIENCE)?;
    let report = greet(&mut client, args)?;
    if args.events {
        return follow(&mut client, args, &stopped);
    }
    show(&ask(&mut client, report, args)?, args)?;
    while args.watch && !rest(&mut client, &stopped)? {
        let report = ask(&mut client, Report::default(), args)?;
        if !args.json {
            output::line("")?;
        }
        show(&report, args)?;
    }
    Ok(Exit::Done)
}

/// Waits for WELCOME.
fn greet(client: &mut Client, args: &StatusArgs) -> anyhow::Result<Report> {
    let mut report = Report::default();
    collect(client, args, &mut report, |report| report.welcomed)?;
    Ok(report)
}

/// Asks for everything and waits for the answer.
fn ask(client: &mut Client, mut report: Report, args: &StatusArgs) -> anyhow::Result<Report> {
    client.query()?;
    collect(client, args, &mut report, |report| report.answered)?;
    report.judge_sensors();
    Ok(report)
}

/// Takes messages until `done`, at most [`PATIENCE`].
fn collect(
    client: &mut Client,
    args: &StatusArgs,
    report: &mut Report,
    done: impl Fn(&Report) -> bool,
) -> anyhow::Result<()> {
    let end = clock::monotonic() + PATIENCE;
    while !done(report) {
        let left = end.saturating_sub(clock::monotonic());
        if left.is_zero() {
            return Err(silence(client, args));
        }
        let closed = client.wait(left, &mut |message| report.take(message)).err();
        if let Some(reason) = report.goodbye.take() {
            bail!("{}: gripd closed the connection: {reason}", args.address);
        }
        if let Some(reason) = report.misfit() {
            bail!(reason);
        }
        if let Some(error) = closed {
            let bad = client.link().counters().bad_blocks();
            return Err(if bad > 0 { silence(client, args) } else { error.into() });
        }
    }
    Ok(())
}

/// Why nothing came, as far as the bytes show it.
fn silence(client: &Client, args: &StatusArgs) -> anyhow::Error {
    let counters = client.link().counters();
    let (bad, others) = (counters.bad_blocks(), counters.echo.saturating_add(counters.stale));
    let reported = if bad > 0 {
        format!("{bad} blocks came that are no frames: is this another program's port?")
    } else if others > 0 {
        "frames came, but none for this program: is this a gripper's line and not gripd?".to_owned()
    } else {
        format!("something listens, but no answer of a gripd came within {} s", PATIENCE.as_secs())
    };
    anyhow::anyhow!("{}: {reported}", args.address)
}

fn show(report: &Report, args: &StatusArgs) -> anyhow::Result<()> {
    if args.json {
        return output::json(report);
    }
    for line in client::lines(report) {
        output::line(&line)?;
    }
    Ok(())
}

/// Waits for the next question; whether the user has stopped it.
fn rest(client: &mut Client, stopped: &AtomicBool) -> anyhow::Result<bool> {
    let end = clock::monotonic() + INTERVAL;
    loop {
        let left = end.saturating_sub(clock::monotonic());
        if stopped.load(Ordering::Relaxed) || left.is_zero() {
            return Ok(stopped.load(Ordering::Relaxed));
        }
        client.wait(left.min(LOOK), &mut |_| {})?;
    }
}

/// Prints slips and notices until the user stops it.
fn follow(client: &mut Client, args: &StatusArgs, stopped: &AtomicBool) -> anyhow::Result<Exit> {
    let mut dropped = false;
    while !stopped.load(Ordering::Relaxed) {
        let mut failed = None;
        let waited = client.wait(LOOK, &mut |message| {
            dropped |= matches!(message, ToClient::Notice(n) if n.kind == NoticeKind::Dropped);
            let Some(event) = EventReport::of(message) else { return };
            let printed = if args.json {
                output::json(&event)
            } else {
                output::line(&client::event(&event)).map_err(Into::into)
            };
            failed = printed.err().or(failed.take());
        });
        if let Some(error) = failed {
            return Err(error);
        }
        waited?;
    }
    Ok(if dropped { Exit::DataLost } else { Exit::Done })
}
