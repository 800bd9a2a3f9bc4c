//! The exit codes of the contract.

use crate::{config::HostConfigError, model::ModelError};
use core::error::Error;
use std::process::ExitCode;

/// Arguments that the parser of the command line cannot check.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct WrongArgument(pub String);

/// How a command ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exit {
    /// 0: done.
    Done,
    /// 1: failed.
    Failed,
    /// 2: wrong arguments or configuration.
    WrongArguments,
    /// 3: done, but data were lost on the way.
    DataLost,
}

impl Exit {
    /// What an error means: arguments, configurations, models and scenes that cannot be used are the
    /// caller's to mend, everything else has failed.
    #[must_use]
    pub fn of(error: &(dyn Error + 'static)) -> Self {
        let mut cause = Some(error);
        while let Some(error) = cause {
            let wrong = error.is::<WrongArgument>()
                || error.is::<HostConfigError>()
                || error.is::<ModelError>()
                || error.is::<grip_sim::SceneError>();
            if wrong {
                return Self::WrongArguments;
            }
            cause = error.source();
        }
        Self::Failed
    }
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        Self::from(match exit {
            Exit::Done => 0,
            Exit::Failed => 1,
            Exit::WrongArguments => 2,
            Exit::DataLost => 3,
        })
    }
}
