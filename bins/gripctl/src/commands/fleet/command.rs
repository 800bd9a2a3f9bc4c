//! `gripctl fleet command`: what one gripper is to do in; whether its daemon takes it out.

use super::network;
use crate::{
    cli::fleet::{CommandArgs, What},
    output,
};
use anyhow::Context as _;
use core::time::Duration;
use grip_fleet::{
    Member, Part,
    net::{Ask, Session, ask},
};
use grip_link::message::{
    FaultCode,
    daemon::{Command, Operation},
};
use grip_session::exit::{Exit, WrongArgument};

/// How long a gripper may take to answer.
const PATIENCE: Duration = Duration::from_secs(5);

pub(super) fn run(args: &CommandArgs) -> anyhow::Result<Exit> {
    let command = command(args.what)?;
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

fn command(what: What) -> Result<Command, WrongArgument> {
    Ok(match what {
        What::AtLeast { force } => {
            Command { force_mn: millinewtons(force)?, ..Command::new(Operation::AtLeast) }
        }
        What::Release => Command::new(Operation::Release),
        What::Grasp => Command::new(Operation::Grasp),
        What::Stop => Command::new(Operation::Stop),
        What::ClearFault { code } => {
            Command { fault: FaultCode(code), ..Command::new(Operation::ClearFault) }
        }
    })
}

/// A force as it travels.
fn millinewtons(force: f64) -> Result<i32, WrongArgument> {
    let force_mn = (force * 1e3).round();
    if !(0.0..=f64::from(i32::MAX)).contains(&force_mn) {
        return Err(WrongArgument(format!("{force} is no force; expected newtons, 0 or more")));
    }
    #[expect(clippy::cast_possible_truncation, reason = "whole and within the range")]
    let force_mn = force_mn as i32;
    Ok(force_mn)
}

/// What letting go must bear, so that this start of the daemon is meant: only who may command gets it.
fn token(session: &Session, member: &Member) -> anyhow::Result<u32> {
    let answer = ask(session, &question(member, Part::Command, &[]))?.concat();
    let token = core::str::from_utf8(&answer).ok().and_then(|token| token.parse().ok());
    token.context("no token that this gripctl knows")
}

#[cfg(test)]
mod tests {
    use super::{What, command, millinewtons};
    use grip_link::message::{FaultCode, daemon::Operation};

    #[test]
    fn forces_are_whole_millinewtons_and_never_negative() {
        assert_eq!(millinewtons(0.0).unwrap(), 0);
        assert_eq!(millinewtons(2.5004).unwrap(), 2500);
        for wrong in [-0.1, f64::NAN, f64::INFINITY, 3e6] {
            assert!(millinewtons(wrong).unwrap_err().to_string().contains("no force"), "{wrong}");
        }
    }

    #[test]
    fn what_is_stated_is_what_is_sent() {
        let at_least = command(What::AtLeast { force: 1.25 }).unwrap();
        assert_eq!((at_least.operation, at_least.force_mn), (Operation::AtLeast, 1250));
        let clear = command(What::ClearFault { code: 0x0103 }).unwrap();
        assert_eq!((clear.operation, clear.fault), (Operation::ClearFault, FaultCode(0x0103)));
        assert_eq!(command(What::Stop).unwrap().operation, Operation::Stop);
        assert_eq!(command(What::Grasp).unwrap().operation, Operation::Grasp);
    }
}
