//! The place the bytes come from: a serial port that was named or found, or the simulator behind a pseudo-terminal.

use crate::{Finder, Line, Places, PortError, Wanted, open::check_baud, simulator::Simulator};
use core::time::Duration;
use grip_host::{config::UsbFilter, scene};
use grip_sim::{Scene, Truth};

/// Bits per second where nothing is said: 10 kHz of three channels need 1.5 Mbit/s.
pub const DEFAULT_BAUD: u32 = 2_000_000;

/// Longest wait for bytes: requests and clock sync go on at this pace where no samples come.
pub const READ_TIMEOUT: Duration = Duration::from_millis(2);

/// Which port, as the user says it.
#[derive(Clone, Copy, Debug)]
pub struct PortArgs<'a> {
    /// A serial device, `auto` for the only USB serial port that fits, or `sim` with an optional `:SCENE`.
    pub name: &'a str,
    /// Bits per second.
    pub baud: u32,
    /// Seed of the simulated scene, instead of its own.
    pub seed: Option<u64>,
    /// What `auto` looks for.
    pub usb: &'a UsbFilter,
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
    finder: Finder,
    baud: u32,
    simulator: Option<Simulator>,
}

impl Source {
    /// Starts the simulator, or notes which port to look for; nothing is opened or written yet. `clock` gives the simulator microseconds and never
    /// goes back.
    ///
    /// # Errors
    /// Where there is no such scene, the baud rate is not used, or several ports fit `auto`. A port that is absent is none:
    /// [`Source::line`] tells, and may be asked again.
    pub fn open(
        args: &PortArgs<'_>,
        clock: impl FnMut() -> u64 + Send + 'static,
    ) -> Result<Self, PortError> {
        let baud = args.baud;
        check_baud(baud).map_err(PortError::Argument)?;
        let places = Places::default();
        if let Some(scene) = args.scene()? {
            let simulator = Simulator::start(&scene, clock)?;
            let wanted = Wanted::Path(simulator.port().into());
            return Ok(Self {
                finder: Finder::new(places, wanted),
                baud,
                simulator: Some(simulator),
            });
        }
        let finder = Finder::new(places, Wanted::new(args.name, args.usb));
        match finder.find() {
            Err(error) if !error.is_temporary() => Err(error),
            _ => Ok(Self { finder, baud, simulator: None }),
        }
    }

    /// Opens the line for this process alone; also after it was lost, and then only to the same device.
    ///
    /// # Errors
    /// Where the port is absent, busy, not allowed or no serial port. Where [`PortError::is_temporary`] says so, a later try may succeed.
    pub fn line(&mut self) -> Result<Line, PortError> {
        self.finder.open(self.baud)
    }

    /// What is looked for, and which device was chosen.
    #[must_use]
    pub fn finder(&self) -> &Finder {
        &self.finder
    }

    /// Ends the simulator and asks what became of the object; `None` on a real port.
    ///
    /// # Errors
    /// Where the simulator failed.
    pub fn close(self) -> Result<Option<Truth>, PortError> {
        self.simulator.map(Simulator::stop).transpose()
    }
}

#[cfg(test)]
mod tests {
    use super::{PortArgs, Source};
    use crate::PortError;
    use grip_host::{
        config::UsbFilter,
        exit::{Exit, message},
    };

    fn args(name: &str) -> PortArgs<'_> {
        PortArgs { name, baud: super::DEFAULT_BAUD, seed: None, usb: &UsbFilter::ANY }
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
    fn the_order_to_enter_a_boot_loader_is_the_callers_mistake() {
        let error = Source::open(&PortArgs { baud: 1200, ..args("sim") }, || 0).unwrap_err();
        assert_eq!(Exit::of(&error), Exit::WrongArguments);
        assert!(error.to_string().contains("boot loader"), "{error}");
    }

    #[test]
    fn a_port_that_is_not_there_says_what_helps() {
        let mut source = Source::open(&args("/nowhere/tty"), || 0).unwrap();
        let error = source.line().unwrap_err();
        assert!(error.is_temporary());
        let PortError::Open { path, advice, .. } = error else { panic!() };
        assert!(path == "/nowhere/tty" && advice.contains("gripctl ports"), "{advice}");
        assert!(source.close().unwrap().is_none(), "no simulator");
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn the_simulator_answers_on_its_line_again_and_again_and_ends() {
        let mut now = 0;
        let source = Source::open(&args("sim"), move || {
            now += 100;
            now
        });
        let mut source = source.unwrap();
        for _ in 0..3 {
            let mut line = source.line().unwrap();
            line.write_frame(&[0, 1, 2, 0]).unwrap();
            assert_eq!(
                line.read(&mut [0; 16], super::READ_TIMEOUT).unwrap(),
                0,
                "garbage is not answered"
            );
        }
        assert!(!source.close().unwrap().unwrap().lifted());
    }
}
