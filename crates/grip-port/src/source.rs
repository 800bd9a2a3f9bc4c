//! The place the bytes come from: a serial port that was named or found.

use crate::{Finder, Line, Places, PortError, UsbFilter, Wanted, open::check_baud};
use core::time::Duration;

/// Bits per second where nothing is said: 10 kHz of three channels need 1.5 Mbit/s.
pub const DEFAULT_BAUD: u32 = 2_000_000;

/// Longest wait for bytes: requests and clock sync go on at this pace where no samples come.
pub const READ_TIMEOUT: Duration = Duration::from_millis(2);

/// Where the gripper is.
#[derive(Debug)]
pub struct Source {
    finder: Finder,
    baud: u32,
}

impl Source {
    /// Notes which port to look for, by the path of a serial device, or by `auto` for the only USB serial port that fits `usb`; nothing
    /// is opened or written yet.
    ///
    /// # Errors
    /// Where the baud rate is not used, or several ports fit `auto`. A port that is absent is none: [`Source::line`] reports that, and may be
    /// asked again.
    pub fn open(name: &str, baud: u32, usb: UsbFilter) -> Result<Self, PortError> {
        check_baud(baud)?;
        let finder = Finder::new(Places::default(), Wanted::new(name, usb));
        match finder.find() {
            Err(error) if !error.is_temporary() => Err(error),
            _ => Ok(Self { finder, baud }),
        }
    }

    /// Opens the line for this process alone; also after it was lost, and then only to the same device.
    ///
    /// # Errors
    /// Where the port is absent, busy, not allowed or no serial port. Where [`PortError::is_temporary`] holds, a later try may succeed.
    pub fn line(&mut self) -> Result<Line, PortError> {
        self.finder.open(self.baud)
    }

    /// What is looked for, and which device was chosen.
    #[must_use]
    pub fn finder(&self) -> &Finder {
        &self.finder
    }
}

#[cfg(test)]
mod tests {
    use super::{DEFAULT_BAUD, Source};
    use crate::{PortError, UsbFilter};

    #[test]
    fn the_order_to_enter_a_boot_loader_is_the_callers_mistake() {
        let error = Source::open("/dev/ttyACM0", 1200, UsbFilter::default()).unwrap_err();
        assert!(matches!(error, PortError::Argument(_)));
        assert!(error.to_string().contains("boot loader"), "{error}");
    }

    #[test]
    fn a_port_that_is_not_there_states_what_helps() {
        let mut source = Source::open("/nowhere/tty", DEFAULT_BAUD, UsbFilter::default()).unwrap();
        let error = source.line().unwrap_err();
        assert!(error.is_temporary());
        let PortError::Open { path, advice, .. } = error else { panic!() };
        assert!(path == "/nowhere/tty" && advice.contains("gripctl ports"), "{advice}");
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn the_simulator_answers_on_its_line_again_and_again_and_ends() {
        let mut now = 0;
        let clock = move || {
            now += 100;
            now
        };
        let simulator = grip_sim::port::Simulator::at("sim", None, clock).unwrap().unwrap();
        let mut source =
            Source::open(simulator.port(), DEFAULT_BAUD, UsbFilter::default()).unwrap();
        for _ in 0..3 {
            let mut line = source.line().unwrap();
            line.write_frame(&[0, 1, 2, 0]).unwrap();
            assert_eq!(
                line.read(&mut [0; 16], super::READ_TIMEOUT).unwrap(),
                0,
                "garbage is not answered"
            );
        }
        assert!(!simulator.stop().unwrap().lifted());
    }
}
