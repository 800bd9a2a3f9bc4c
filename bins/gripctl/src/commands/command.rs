//! `gripctl command`: a command for the gripper of a running gripd; whether gripd takes it, and what it does.

use super::clock;
use crate::{cli::CommandArgs, output};
use anyhow::bail;
use core::time::Duration;
use grip_daemon::{client::Client, clients::Listen};
use grip_link::message::{
    Kind, NackReason, Versions,
    daemon::{Command, NoticeKind, Operation, Subscribe, ToClient, Topics},
};
use grip_port::nonce;
use grip_session::exit::Exit;

/// A daemon that is there answers within this time.
pub(super) const PATIENCE: Duration = Duration::from_secs(3);
/// The sentence where the configuration is missing.
pub(super) const FORBIDDEN: &str =
    "gripd takes no commands of clients: set allow_commands = true in gripd.toml";
/// What is carried out so soon is printed.
const CARRIED_OUT: Duration = Duration::from_secs(1);

pub(crate) fn run(args: &CommandArgs) -> anyhow::Result<Exit> {
    let command = args.what.command()?;
    let wanted =
        Subscribe { versions: Versions::OURS, topics: Topics::NEWS, every_nth: 0, state_ms: 0 };
    let mut client = Client::connect(&args.address, nonce(), wanted, PATIENCE)?;
    let token = first(&mut client, PATIENCE, |message| match message {
        ToClient::Welcome(welcome) => Some(welcome.token),
        _ => None,
    })?;
    let Some(token) = token else { bail!(silent(&args.address)) };
    // Of a release, which is for this start of gripd.
    let token = if command.operation == Operation::Release { token } else { 0 };
    client.command(&Command { token, ..command })?;
    let carried_out = |message: &ToClient<'_>| match message {
        ToClient::Notice(notice) if notice.kind == NoticeKind::Client => {
            (notice.code == command.operation.code()).then(|| notice.as_str().to_owned())
        }
        _ => None,
    };
    let mut done = None;
    let answer = first(&mut client, PATIENCE, |message| match message {
        ToClient::Ack(ack) if ack.kind == Kind::COMMAND => Some(Ok(())),
        ToClient::Nack(nack) if nack.kind == Kind::COMMAND => Some(Err(nack.reason)),
        // It may come with the answer.
        message => {
            done = done.take().or_else(|| carried_out(message));
            None
        }
    })?;
    match answer {
        None => bail!(silent(&args.address)),
        Some(Err(reason)) => bail!(refusal(reason)),
        Some(Ok(())) if done.is_none() => done = first(&mut client, CARRIED_OUT, carried_out)?,
        Some(Ok(())) => {}
    }
    output::line(done.as_deref().unwrap_or("gripd has taken the command"))?;
    Ok(Exit::Done)
}

/// What `take` makes of the first message that it makes something of; `None` where none comes in time.
pub(super) fn first<T>(
    client: &mut Client,
    patience: Duration,
    mut take: impl FnMut(&ToClient<'_>) -> Option<T>,
) -> anyhow::Result<Option<T>> {
    let end = clock::monotonic() + patience;
    let mut found = None;
    while found.is_none() {
        let left = end.saturating_sub(clock::monotonic());
        if left.is_zero() {
            break;
        }
        client.wait(left, &mut |message| {
            let made = take(message);
            found = found.take().or(made);
        })?;
    }
    Ok(found)
}

/// The sentence about a gripd that does not answer in time.
pub(super) fn silent(address: &Listen) -> String {
    format!("{address}: no answer within {} s", PATIENCE.as_secs())
}

/// A sentence with what to do.
fn refusal(reason: NackReason) -> String {
    match reason {
        NackReason::Forbidden => FORBIDDEN.to_owned(),
        NackReason::WrongState => {
            "not in this state: `gripctl status` shows link and gripper".to_owned()
        }
        NackReason::Latched => {
            "a fault or stop is latched: `gripctl status` shows its code, `gripctl command clear-fault CODE` clears it"
                .to_owned()
        }
        NackReason::OtherFault => {
            "another fault is latched: `gripctl status` shows its code".to_owned()
        }
        NackReason::Malformed => {
            "the force is above the largest one of the controller, grip.f_max_n in gripd.toml"
                .to_owned()
        }
        reason => format!("gripd refuses the command: {}", reason.name()),
    }
}
