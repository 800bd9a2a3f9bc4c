//! Why there is no line to a gripper, in words that state what to do about it.

use core::fmt::Display;
use std::{io, path::Path};

/// Why a port cannot be opened or used.
#[derive(Debug, thiserror::Error)]
pub enum PortError {
    /// The port or the rate named by the user makes no sense here.
    #[error("{0}")]
    Argument(String),
    /// The serial ports cannot be listed.
    #[error("cannot list the serial ports: {0}")]
    List(#[source] io::Error),
    /// No port fits, or the chosen one is gone: it may come.
    #[error("{0}")]
    Absent(String),
    /// The port cannot be opened.
    #[error("{path}: {advice}")]
    Open {
        /// The port.
        path: String,
        /// What is wrong and what helps.
        advice: String,
        /// What the system said.
        reason: io::ErrorKind,
    },
    /// The other end is gone.
    #[error("the port was closed: the gripper was unplugged")]
    Closed,
    /// Reading failed.
    #[error("the port failed: the gripper was unplugged: {0}")]
    Read(#[source] io::Error),
    /// Writing failed.
    #[error("cannot write to the port: {0}")]
    Write(#[source] io::Error),
}

impl PortError {
    /// Whether the same try may succeed later without anybody changing settings: the port may be plugged in, let go by another program, or
    /// get its group from udev a moment after it came.
    #[must_use]
    pub fn is_temporary(&self) -> bool {
        match self {
            Self::Absent(_) | Self::Closed | Self::Read(_) | Self::Write(_) => true,
            Self::Open { reason, .. } => matches!(
                reason,
                io::ErrorKind::NotFound
                    | io::ErrorKind::PermissionDenied
                    | io::ErrorKind::ResourceBusy
            ),
            _ => false,
        }
    }

    /// What the system's refusal to open `path` means: its kind, and `error` in its own words.
    pub(crate) fn refused(path: &Path, reason: io::ErrorKind, error: &dyn Display) -> Self {
        let advice = match reason {
            io::ErrorKind::NotFound => {
                "there is no such port; `gripctl ports` lists those there are".to_owned()
            }
            io::ErrorKind::PermissionDenied => {
                "access denied; add your user to the group of the device (often dialout) and log in again; `gripctl doctor` names it".to_owned()
            }
            io::ErrorKind::ResourceBusy => {
                "the port is busy: another program holds it (ModemManager, a serial monitor, another gripd?); `gripctl doctor` names it".to_owned()
            }
            _ if path.is_file() => format!(
                "no serial port but a file; `gripctl replay '{}'` finds the slips of a recording, `gripctl ports` lists the ports",
                path.display().to_string().replace('\'', r"'\''")
            ),
            _ => format!(
                "no serial port, or one that cannot be set up ({error}); `gripctl ports` lists those there are"
            ),
        };
        Self::Open { path: path.display().to_string(), advice, reason }
    }

    /// The driver of `path` does not do the baud rate `wanted`, but `given` if anything.
    pub(crate) fn baud(path: &Path, wanted: u32, given: Option<u32>) -> Self {
        let given = given.map_or_else(String::new, |given| format!(" (it offers {given})"));
        let advice = format!(
            "its driver cannot do {wanted} bits per second{given}; choose another --baud, and set the gripper to it"
        );
        Self::Open { path: path.display().to_string(), advice, reason: io::ErrorKind::InvalidInput }
    }
}
