//! Opening of a port by its path: a raw line that no other program may take.

use crate::{Line, Places, PortError, system};
use std::path::Path;

/// Whether a baud rate may be asked for.
///
/// # Errors
/// For 0, and for 1200: many boards take the latter as the order to enter their boot loader.
pub fn check_baud(baud: u32) -> Result<(), PortError> {
    let wrong = match baud {
        0 => "baud 0: expected bits per second, more than 0",
        1200 => "baud 1200 is not used: it makes many boards restart into their boot loader",
        _ => return Ok(()),
    };
    Err(PortError::Argument(wrong.to_owned()))
}

/// Whether two rates are within the 2.5 % that a UART puts up with.
pub(crate) fn is_near(given: u32, wanted: u32) -> bool {
    u64::from(given.abs_diff(wanted)) * 40 <= u64::from(wanted)
}

impl Line {
    /// Opens a port of this computer for this process alone: raw, 8N1, no flow control. What it still held is thrown away. Opening may
    /// restart a board that listens to DTR; closing does not on Linux (HUPCL is off).
    ///
    /// # Errors
    /// Where the port is absent, busy, not allowed, no serial port, or cannot do `baud`.
    pub fn open(path: &Path, baud: u32) -> Result<Self, PortError> {
        Self::open_in(&Places::default(), path, baud)
    }

    /// As [`Line::open`], with the system's folders as arguments.
    ///
    /// # Errors
    /// As [`Line::open`].
    pub fn open_in(places: &Places, path: &Path, baud: u32) -> Result<Self, PortError> {
        check_baud(baud)?;
        let (wire, setup) = system::open(places, path, baud)?;
        Ok(Self::new(wire, setup))
    }

    /// Connects to what forwards a serial port at `HOST:PORT`. The rate of the port is a matter of the forwarder.
    ///
    /// # Errors
    /// Where nothing listens there, or it is not reached within a second.
    pub fn connect(address: &str) -> Result<Self, PortError> {
        system::connect(address)
    }
}

#[cfg(test)]
mod tests {
    use super::is_near;

    #[test]
    fn a_uart_puts_up_with_a_fortieth() {
        assert!(is_near(117_000, 115_200) && !is_near(9600, 115_200) && !is_near(0, 300));
    }
}
