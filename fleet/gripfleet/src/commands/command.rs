//! `gripfleet command`: a command for one gripper, and whether its daemon takes it.

use super::network;
use crate::{cli::fleet::CommandArgs, output};
use anyhow::Context as _;
use core::time::Duration;
use grip_fleet::{
    Member, Part,
    net::{Ask, Session, ask},
};
use grip_link::message::daemon::{Command, Operation};
use grip_session::exit::Exit;

/// How long a gripper may take to answer.
const PATIENCE: Duration = Duration::from_secs(5);

pub(super) fn run(args: &CommandArgs) -> anyhow::Result<Exit> {
    let command = args.what.command()?;
    let session = network(&args.place)?.open()?;
    let member = &args.gripper;
    let command = match command.operation {
        Operation::Release => Command { token: token(&session, member)?, ..command },
        _ => command,
    };
    let mut payload = [0; Command::SIZE];
    command.write(&mut payload)?;
    ask(&session, &question(member, Part::Command, &payload))?;
    output::line(&format!("{member}  has taken the command"))?;
    Ok(Exit::Done)
}

const fn question<'a>(member: &'a Member, part: Part, payload: &'a [u8]) -> Ask<'a> {
    Ask { member, part, parameters: &[], payload, patience: PATIENCE }
}

/// What letting go must bear, so that this start of the daemon is meant: only who may command gets it.
fn token(session: &Session, member: &Member) -> anyhow::Result<u32> {
    let answer = ask(session, &question(member, Part::Command, &[]))?.concat();
    let token = core::str::from_utf8(&answer).ok().and_then(|token| token.parse().ok());
    token.context("no token that this gripfleet knows")
}
