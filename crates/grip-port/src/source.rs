//! The place the bytes come from: a serial port that was named, or the simulator behind a pseudo-terminal.

use crate::{Line, PortError, simulator::Simulator};
use core::time::Duration;
use grip_host::{exit::WrongArgument, scene};
use grip_sim::{Scene, Truth};
use serialport::SerialPortType;

/// Bits per second where nothing is said: 10 kHz of three channels need 1.5 Mbit/s.
pub const DEFAULT_BAUD: u32 = 2_000_000;

/// Longest wait for bytes: requests and clock sync go on at this pace where no samples come.
const READ_TIMEOUT: Duration = Duration::from_millis(2);

/// Which port, as the user says it.
#[derive(Clone, Copy, Debug)]
pub struct PortArgs<'a> {
    /// A serial device, `auto` for the only USB serial port, or `sim` with an optional `:SCENE`.
    pub name: &'a str,
    /// Bits per second.
    pub baud: u32,
    /// Seed of the simulated scene, instead of its own.
    pub seed: Option<u64>,
}

impl PortArgs<'_> {
    /// The scene, where the port is the simulator.
    fn scene(&self) -> Result<Option<Scene>, PortError> {
        let Some(rest) = self.name.strip_prefix("sim") else { return Ok(None) };
        let name = match rest.strip_prefix(':') {
            Some(name) => name,
            None if rest.is_empty() => "default",
            None => return Ok(None),
        };
        let scene = scene::load(name)
            .map_err(|source| PortError::Scene { port: self.name.to_owned(), source })?;
        match self.seed {
            Some(seed) => scene.reseeded(seed).map(Some).map_err(PortError::Seed),
            None => Ok(Some(scene)),
        }
    }
}

/// Where the gripper is.
#[derive(Debug)]
pub struct Source {
    path: String,
    baud: u32,
    simulator: Option<Simulator>,
}

impl Source {
    /// Starts the simulator, or finds the port; nothing is written yet. `clock` gives the simulator microseconds and never goes back.
    ///
    /// # Errors
    /// Where there is no such scene, no USB port, or more than one.
    pub fn open(
        args: &PortArgs<'_>,
        clock: impl FnMut() -> u64 + Send + 'static,
    ) -> Result<Self, PortError> {
        let baud = args.baud;
        if let Some(scene) = args.scene()? {
            let simulator = Simulator::start(&scene, clock)?;
            let path = simulator.port().to_owned();
            return Ok(Self { path, baud, simulator: Some(simulator) });
        }
        let path = if args.name == "auto" { only_usb_port()? } else { args.name.to_owned() };
        Ok(Self { path, baud, simulator: None })
    }

    /// Opens the line for this process alone.
    ///
    /// # Errors
    /// Where the port is absent, busy, not allowed or no serial port.
    pub fn line(&self) -> Result<Line, PortError> {
        serialport::new(&self.path, self.baud)
            .timeout(READ_TIMEOUT)
            .open()
            .map(Line::new)
            .map_err(|error| PortError::refused(&self.path, &error))
    }

    /// Ends the simulator and asks what became of the object; `None` on a real port.
    ///
    /// # Errors
    /// Where the simulator failed.
    pub fn close(self) -> Result<Option<Truth>, PortError> {
        self.simulator.map(Simulator::stop).transpose()
    }
}

/// The USB serial port, if there is exactly one.
fn only_usb_port() -> Result<String, PortError> {
    let ports = serialport::available_ports().map_err(PortError::List)?;
    let usb: Vec<String> = ports
        .into_iter()
        .filter(|port| matches!(port.port_type, SerialPortType::UsbPort(_)))
        .map(|port| port.port_name)
        .collect();
    let refused = |text: String| Err(PortError::Argument(WrongArgument(text)));
    match usb.as_slice() {
        [one] => Ok(one.clone()),
        [] => refused(
            "--port auto: no USB serial port found; plug the gripper in, or name the port"
                .to_owned(),
        ),
        several => refused(format!(
            "--port auto: several USB serial ports ({}); name one with --port",
            several.join(", ")
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::{PortArgs, Source};
    use crate::PortError;
    use grip_host::exit::{Exit, message};

    fn args(name: &str) -> PortArgs<'_> {
        PortArgs { name, baud: super::DEFAULT_BAUD, seed: None }
    }

    #[test]
    fn an_unknown_scene_is_the_callers_mistake_and_named_once() {
        let error = Source::open(&args("sim:nope"), || 0).unwrap_err();
        let text = message(&error);
        assert!(text.starts_with("--port sim:nope: "), "{text}");
        assert_eq!(text.matches("built in are").count(), 1, "{text}");
        assert_eq!(Exit::of(&error), Exit::WrongArguments);
    }

    #[test]
    fn a_port_that_is_not_there_says_what_helps() {
        let source = Source::open(&args("/nowhere/tty"), || 0).unwrap();
        let PortError::Open { path, advice } = source.line().unwrap_err() else { panic!() };
        assert!(path == "/nowhere/tty" && advice.contains("gripctl ports"), "{advice}");
        assert!(source.close().unwrap().is_none(), "no simulator");
    }

    #[test]
    fn the_simulator_answers_on_its_line_and_ends() {
        let mut now = 0;
        let source = Source::open(&args("sim"), move || {
            now += 100;
            now
        });
        let source = source.unwrap();
        let mut line = source.line().unwrap();
        line.write(&[0, 1, 2, 0]).unwrap();
        assert_eq!(line.read(&mut [0; 16]).unwrap(), 0, "garbage is not answered");
        assert!(!source.close().unwrap().unwrap().lifted());
    }
}
