//! Ports of every system but Linux, by `serialport` alone: its list, its exclusive open, reads and writes with a short timeout.
//!
//! What is worse than on Linux: waits are whole milliseconds; a write waits for room up to 20 ms, or as long as the driver
//! blocks; a read that finds nothing allocates; all ports count as UARTs, so commands are spaced for the baud rate; a device is not
//! distinguished from another one at the same name where it has neither a serial number nor a known socket.

use crate::{
    Line, LineKind, PortError, PortInfo,
    line::{Ready, Setup},
    list,
    open::is_near,
};
use core::time::Duration;
use serialport::{ClearBuffer, ErrorKind, SerialPort};
use std::{
    io,
    path::{Path, PathBuf},
};

/// Shortest timeout of a port: Windows takes none to mean for ever.
const SHORTEST: Duration = Duration::from_millis(1);
/// Longest timeout of a port, so that a write does not wait as long as a patient read.
const LONGEST: Duration = Duration::from_millis(20);

/// The system's ports; there are no folders to choose.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Places(());

impl Places {
    /// All ports, in the order of their names.
    ///
    /// # Errors
    /// Where the system's list cannot be read.
    pub fn ports(&self) -> io::Result<Vec<PortInfo>> {
        let mut ports = list::listed()?;
        ports.retain(|port| !is_double(&port.path));
        list::sort(&mut ports);
        Ok(ports)
    }

    /// What the system states of the port at `path`.
    #[must_use]
    pub fn look_up(&self, path: &Path) -> Option<PortInfo> {
        self.ports().ok()?.into_iter().find(|port| port.path == path)
    }

    /// The file with the latency timer of an FTDI converter: none, only Linux has one.
    #[must_use]
    pub fn latency_timer(&self, _path: &Path) -> Option<PathBuf> {
        None
    }
}

/// macOS shows every port twice. The one under `tty.` waits for a carrier when it is opened; `cu.` is meant for us.
fn is_double(path: &Path) -> bool {
    path.to_str().is_some_and(|path| path.starts_with("/dev/tty."))
}

/// As [`Line::connect`].
pub(crate) fn connect(address: &str) -> Result<Line, PortError> {
    Err(PortError::Argument(format!("tcp:{address}: ports over TCP are opened on Linux only")))
}

/// As [`crate::Line::open_in`].
pub(crate) fn open(_: &Places, path: &Path, baud: u32) -> Result<(Wire, Setup), PortError> {
    let refused = |error: serialport::Error| refused(path, &error);
    let port = serialport::new(path.to_string_lossy(), baud)
        .timeout(SHORTEST)
        // As Linux does by itself: many boards send nothing before.
        .dtr_on_open(true)
        .open()
        .map_err(refused)?;
    port.clear(ClearBuffer::Input).map_err(refused)?;
    let given = port.baud_rate().map_err(refused)?;
    if !is_near(given, baud) {
        return Err(PortError::baud(path, baud, Some(given)));
    }
    let setup = Setup { kind: LineKind::Uart, baud, latency_timer_ms: None };
    Ok((Wire { port, timeout: SHORTEST }, setup))
}

fn refused(path: &Path, error: &serialport::Error) -> PortError {
    let reason = match error.kind() {
        // The library states the same of a port that is held and, on Windows, of one that is absent.
        ErrorKind::NoDevice => {
            let advice = format!(
                "there is no such port, or another program holds it ({error}); `gripctl ports` lists those there are"
            );
            let path = path.display().to_string();
            return PortError::Open { path, advice, reason: io::ErrorKind::ResourceBusy };
        }
        ErrorKind::Io(reason) => reason,
        ErrorKind::InvalidInput => io::ErrorKind::InvalidInput,
        ErrorKind::Unknown => io::ErrorKind::Other,
    };
    PortError::refused(path, reason, error)
}

/// An open port with a timeout.
pub(crate) struct Wire {
    port: Box<dyn SerialPort>,
    timeout: Duration,
}

impl core::fmt::Debug for Wire {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Wire").field("timeout", &self.timeout).finish_non_exhaustive()
    }
}

impl Wire {
    /// Notes how long [`Wire::take`] may wait; asks the port only where it may not.
    pub(crate) fn wait(&mut self, timeout: Duration, to_write: bool) -> Result<Ready, PortError> {
        let wanted = timeout.clamp(SHORTEST, LONGEST);
        let failed = |error: serialport::Error| reading(error.into());
        if wanted != self.timeout {
            self.port.set_timeout(wanted).map_err(failed)?;
            self.timeout = wanted;
        }
        let read = !timeout.is_zero() || self.port.bytes_to_read().map_err(failed)? > 0;
        Ok(Ready { read, write: to_write, gone: false })
    }

    /// Reads what comes within the timeout.
    pub(crate) fn take(&mut self, input: &mut [u8]) -> Result<usize, PortError> {
        match self.port.read(input) {
            Ok(0) => Err(PortError::Closed),
            Ok(count) => Ok(count),
            Err(error) if is_early(&error) => Ok(0),
            Err(error) => Err(reading(error)),
        }
    }

    /// Writes what the system takes within the timeout.
    pub(crate) fn push(&mut self, bytes: &[u8]) -> Result<usize, PortError> {
        match self.port.write(bytes) {
            Ok(count) => Ok(count),
            Err(error) if is_early(&error) => Ok(0),
            Err(error) if is_gone(&error) => Err(PortError::Closed),
            Err(error) => Err(PortError::Write(error)),
        }
    }
}

fn reading(error: io::Error) -> PortError {
    if is_gone(&error) { PortError::Closed } else { PortError::Read(error) }
}

fn is_early(error: &io::Error) -> bool {
    use io::ErrorKind::{Interrupted, TimedOut, WouldBlock};
    matches!(error.kind(), TimedOut | WouldBlock | Interrupted)
}

fn is_gone(error: &io::Error) -> bool {
    use io::ErrorKind::{BrokenPipe, ConnectionAborted, ConnectionReset, NotConnected};
    matches!(error.kind(), BrokenPipe | ConnectionReset | ConnectionAborted | NotConnected)
}

// On Linux, where its tests run, over a pseudo-terminal.
#[cfg(test)]
#[cfg(target_os = "linux")]
mod tests {
    use super::{LONGEST, Places, SHORTEST, Wire, connect, is_double, open};
    use crate::PortError;
    use core::time::Duration;
    use grip_sim::Pty;
    use std::path::Path;

    const BAUD: u32 = 2_000_000;
    const PATIENCE: Duration = Duration::from_secs(20);

    fn wire(pty: &Pty) -> Wire {
        open(&Places::default(), pty.port(), BAUD).unwrap().0
    }

    /// What `Line` does for a read.
    fn read(wire: &mut Wire, input: &mut [u8], timeout: Duration) -> Result<usize, PortError> {
        if wire.wait(timeout, false)?.read { wire.take(input) } else { Ok(0) }
    }

    #[test]
    fn a_forwarder_is_refused() {
        assert!(matches!(connect("arm:54321"), Err(PortError::Argument(_))));
    }

    #[test]
    fn bytes_pass_both_ways_and_waits_end() {
        let pty = Pty::open(None).unwrap();
        assert_eq!(pty.write(b"stale").unwrap(), 5);
        let mut wire = wire(&pty);
        let mut input = [0; 64];
        assert_eq!(read(&mut wire, &mut input, Duration::ZERO).unwrap(), 0, "stale bytes are gone");
        assert_eq!(read(&mut wire, &mut input, SHORTEST).unwrap(), 0);
        assert_eq!(read(&mut wire, &mut input, PATIENCE).unwrap(), 0, "ends early");
        assert_eq!(wire.timeout, LONGEST);
        let all: Vec<u8> = (0..=255).collect();
        assert_eq!(pty.write(&all).unwrap(), all.len());
        let mut got = Vec::new();
        while got.len() < all.len() {
            let count = read(&mut wire, &mut input, PATIENCE).unwrap();
            got.extend_from_slice(&input[..count]);
        }
        assert_eq!(got, all);
        assert_eq!(wire.push(b"frame").unwrap(), 5);
        assert!(pty.wait(20_000_000, false).unwrap().read);
        assert_eq!(pty.read(&mut input).unwrap(), 5);
        assert_eq!(&input[..5], b"frame");
    }

    #[test]
    fn a_port_is_held_alone_and_its_end_closes_the_line() {
        let pty = Pty::open(None).unwrap();
        let mut wire = wire(&pty);
        let busy = open(&Places::default(), pty.port(), BAUD).unwrap_err();
        assert!(busy.to_string().contains("holds it") && busy.is_temporary(), "{busy}");
        drop(pty);
        let ended = read(&mut wire, &mut [0; 16], PATIENCE).unwrap_err();
        assert!(ended.is_temporary(), "{ended}");
        let absent = open(&Places::default(), Path::new("/nowhere/tty"), BAUD).unwrap_err();
        assert!(absent.to_string().contains("no such port") && absent.is_temporary(), "{absent}");
        let no_port = open(&Places::default(), Path::new("/dev/null"), BAUD).unwrap_err();
        assert!(no_port.to_string().contains("no serial port"), "{no_port}");
    }

    #[test]
    fn every_port_of_the_library_is_found_by_its_name() {
        let places = Places::default();
        for port in places.ports().unwrap() {
            assert_eq!(places.look_up(&port.path), Some(port));
        }
        assert_eq!(places.look_up(Path::new("COM999")), None);
        assert_eq!(places.latency_timer(Path::new("COM999")), None);
        assert!(is_double(Path::new("/dev/tty.usbmodem1")));
        assert!(
            !is_double(Path::new("/dev/cu.usbmodem1")) && !is_double(Path::new("/dev/ttyACM0"))
        );
    }
}
