//! Why there is no line to a gripper, in words that say what to do about it.

use grip_host::{exit::WrongArgument, scene::SceneFileError};
use grip_sim::{SceneError, mcu::DeviceConfigError, pty::PtyError};
use serialport::ErrorKind;
use std::{io, path::Path};

/// Why a port cannot be opened or used.
#[derive(Debug, thiserror::Error)]
pub enum PortError {
    /// The scene after `sim:` cannot be used.
    #[error("--port {port}: {source}")]
    Scene {
        /// The port as it was named.
        port: String,
        /// What is wrong with the scene.
        source: SceneFileError,
    },
    /// The scene cannot be drawn with that seed.
    #[error("{0}")]
    Seed(#[source] SceneError),
    /// The port named by the user makes no sense here.
    #[error("{0}")]
    Argument(#[source] WrongArgument),
    /// The scene makes no gripper.
    #[error("the scene makes no gripper: {0}")]
    Device(#[source] DeviceConfigError),
    /// No pseudo-terminal for the simulator.
    #[error("cannot open a pseudo-terminal: {0}")]
    Pty(#[source] PtyError),
    /// The simulator's end of the line failed.
    #[error("the simulator's line failed: {0}")]
    SimulatedLine(#[source] PtyError),
    /// The thread of the simulator failed, or could not be started.
    #[error("the simulator thread failed{}", .0.as_ref().map(|e| format!(": {e}")).unwrap_or_default())]
    Thread(#[source] Option<io::Error>),
    /// The serial ports cannot be listed.
    #[error("cannot list the serial ports: {0}")]
    List(#[source] serialport::Error),
    /// The port cannot be opened.
    #[error("{path}: {advice}")]
    Open {
        /// The port.
        path: String,
        /// What is wrong and what helps.
        advice: String,
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
    /// What the system's refusal to open `path` means.
    pub(crate) fn refused(path: &str, error: &serialport::Error) -> Self {
        let advice = match error.kind() {
            ErrorKind::NoDevice | ErrorKind::Io(io::ErrorKind::NotFound)
                if !Path::new(path).exists() =>
            {
                "there is no such port; `gripctl ports` lists those there are".to_owned()
            }
            ErrorKind::Io(io::ErrorKind::PermissionDenied) => {
                "access denied; add your user to the group of the device (often dialout) and log in again".to_owned()
            }
            ErrorKind::NoDevice | ErrorKind::Io(io::ErrorKind::ResourceBusy) => {
                "the port is busy: another program holds it (ModemManager, a serial monitor, another gripd?)".to_owned()
            }
            _ => format!(
                "no serial port, or one that cannot be set up ({error}); `gripctl ports` lists those there are"
            ),
        };
        Self::Open { path: path.to_owned(), advice }
    }
}
