//! Arguments of `gripctl command` and of `gripfleet command`: what a gripper is to do, as it is typed in and as it travels.

use clap::Subcommand;
use grip_link::message::{
    FaultCode,
    daemon::{Command, Operation},
};
use grip_session::exit::WrongArgument;

#[derive(Clone, Copy, Debug, Subcommand)]
pub(crate) enum What {
    /// Hold with at least this force; 0 takes it back.
    AtLeast {
        /// Force (N).
        #[arg(allow_negative_numbers = true)]
        force: f64,
    },
    /// Let go, until the command to grasp.
    Release,
    /// Close again after a release.
    Grasp,
    /// Stop in software, latched by the gripper.
    Stop,
    /// Clear the latched fault of this code, as `gripctl status` and `gripfleet list` show it.
    ClearFault {
        /// Four hexadecimal digits.
        #[arg(value_parser = fault)]
        code: u16,
    },
}

fn fault(text: &str) -> Result<u16, String> {
    u16::from_str_radix(text.trim_start_matches("0x"), 16)
        .map_err(|_| "expected up to four hexadecimal digits, such as 0103".to_owned())
}

impl What {
    /// What is to be done, as it travels.
    pub(crate) fn command(self) -> Result<Command, WrongArgument> {
        Ok(match self {
            Self::AtLeast { force } => {
                Command { force_mn: millinewtons(force)?, ..Command::new(Operation::AtLeast) }
            }
            Self::Release => Command::new(Operation::Release),
            Self::Grasp => Command::new(Operation::Grasp),
            Self::Stop => Command::new(Operation::Stop),
            Self::ClearFault { code } => {
                Command { fault: FaultCode(code), ..Command::new(Operation::ClearFault) }
            }
        })
    }
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

#[cfg(test)]
mod tests {
    use super::{What, millinewtons};
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
        let at_least = What::AtLeast { force: 1.25 }.command().unwrap();
        assert_eq!((at_least.operation, at_least.force_mn), (Operation::AtLeast, 1250));
        let clear = What::ClearFault { code: 0x0103 }.command().unwrap();
        assert_eq!((clear.operation, clear.fault), (Operation::ClearFault, FaultCode(0x0103)));
        assert_eq!(What::Stop.command().unwrap().operation, Operation::Stop);
        assert_eq!(What::Grasp.command().unwrap().operation, Operation::Grasp);
    }
}
