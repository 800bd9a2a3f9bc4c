//! The place the bytes come from: a serial port that was named, or the simulator behind a pseudo-terminal.

use crate::{clock::Clock, settings::Settings, sim::Simulator};
use anyhow::{Context as _, anyhow};
use core::time::Duration;
use grip_host::exit::WrongArgument;
use grip_sim::Truth;
use serialport::{ErrorKind, SerialPort, SerialPortType};
use std::io;

/// Longest wait for bytes: requests and clock sync go on at this pace where no samples come.
const READ_TIMEOUT: Duration = Duration::from_millis(2);

/// Where the gripper is.
#[derive(Debug)]
pub(crate) struct Source {
    path: String,
    baud: u32,
    simulator: Option<Simulator>,
}

impl Source {
    /// Starts the simulator, or finds the port; nothing is written yet.
    pub(crate) fn open(settings: &Settings, clock: Clock) -> anyhow::Result<Self> {
        let baud = settings.baud;
        if let Some(scene) = settings.scene()? {
            let simulator = Simulator::start(&scene, clock)?;
            let path = simulator.port();
            return Ok(Self { path, baud, simulator: Some(simulator) });
        }
        let path = if settings.port == "auto" { only_usb_port()? } else { settings.port.clone() };
        Ok(Self { path, baud, simulator: None })
    }

    /// Opens the port for this process alone.
    pub(crate) fn port(&self) -> anyhow::Result<Box<dyn SerialPort>> {
        serialport::new(&self.path, self.baud)
            .timeout(READ_TIMEOUT)
            .open()
            .map_err(|error| explain(&self.path, &error))
    }

    /// Ends the simulator and asks what became of the object.
    pub(crate) fn close(self) -> anyhow::Result<Option<Truth>> {
        self.simulator.map(Simulator::stop).transpose()
    }
}

/// The USB serial port, if there is exactly one.
fn only_usb_port() -> anyhow::Result<String> {
    let ports = serialport::available_ports().context("cannot list the serial ports")?;
    let usb: Vec<String> = ports
        .into_iter()
        .filter(|port| matches!(port.port_type, SerialPortType::UsbPort(_)))
        .map(|port| port.port_name)
        .collect();
    match usb.as_slice() {
        [one] => Ok(one.clone()),
        [] => Err(WrongArgument(
            "--port auto: no USB serial port found; plug the gripper in, or name the port"
                .to_owned(),
        )
        .into()),
        several => Err(WrongArgument(format!(
            "--port auto: several USB serial ports ({}); name one with --port",
            several.join(", ")
        ))
        .into()),
    }
}

fn explain(path: &str, error: &serialport::Error) -> anyhow::Error {
    let advice = match error.kind() {
        ErrorKind::NoDevice | ErrorKind::Io(io::ErrorKind::NotFound)
            if !std::path::Path::new(path).exists() =>
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
    anyhow!("{path}: {advice}")
}
