//! Opening of a port by its path: a raw descriptor that no other program may take.

use super::{Places, Wire, places};
use crate::{Line, LineKind, PortError, line::Setup, open::is_near};
use core::time::Duration;
use rustix::{
    fs::{FileType, FlockOperation, Mode, OFlags, Stat, flock, fstat, major},
    io::Errno,
    net::sockopt::set_tcp_user_timeout,
    termios::{
        ControlModes, OptionalActions, QueueSelector, SpecialCodeIndex, Termios, ioctl_tiocexcl,
        isatty, tcflush, tcgetattr, tcsetattr,
    },
};
use std::{
    fs, io,
    net::{TcpStream, ToSocketAddrs as _},
    os::fd::OwnedFd,
    path::{Path, PathBuf},
};

/// Major numbers of the host's sides of pseudo-terminals.
const PTY_MAJORS: core::ops::RangeInclusive<u32> = 136..=143;
/// Major number of USB devices that are serial ports themselves (ttyACM).
const ACM_MAJOR: u32 = 166;
/// A forwarder that is not reached within this time is not there.
const CONNECT: Duration = Duration::from_secs(1);
/// What is sent and not acknowledged for this long (ms) ends a connection: a robot that was switched off closes none.
const UNACKNOWLEDGED_MS: u32 = 3000;

/// As [`crate::Line::open_in`].
pub(crate) fn open(places: &Places, path: &Path, baud: u32) -> Result<(Wire, Setup), PortError> {
    let refused = |error: Errno| refused(path, error);
    let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::NONBLOCK | OFlags::CLOEXEC;
    let fd = rustix::fs::open(path, flags, Mode::empty()).map_err(refused)?;
    if !isatty(&fd) {
        return Err(refused(Errno::NOTTY));
    }
    let kind = kind_of(&fstat(&fd).map_err(refused)?);
    // TIOCEXCL does not stop root, the lock stops whoever asks for it.
    flock(&fd, FlockOperation::NonBlockingLockExclusive).map_err(refused)?;
    // A pseudo-terminal keeps the mark of a program that was killed, so there the lock must do.
    let exclusive = kind != LineKind::Pty;
    if exclusive {
        ioctl_tiocexcl(&fd).map_err(refused)?;
    }
    set_up(&fd, path, baud, kind)?;
    tcflush(&fd, QueueSelector::IFlush).map_err(refused)?;
    let latency_timer_ms = places.latency_timer(path).as_ref().and_then(quicken);
    Ok((Wire::new(fd, exclusive), Setup { kind, baud, latency_timer_ms }))
}

/// As [`Line::connect`].
pub(crate) fn connect(address: &str) -> Result<Line, PortError> {
    let failed = |error: io::Error| PortError::Open {
        path: format!("tcp:{address}"),
        advice: format!(
            "nothing that forwards a serial port answers there ({error}); is the robot on, its forwarder started, and the address right?"
        ),
        reason: io::ErrorKind::NotFound,
    };
    let mut found = Err(io::Error::from(io::ErrorKind::AddrNotAvailable));
    for place in address.to_socket_addrs().map_err(failed)? {
        found = TcpStream::connect_timeout(&place, CONNECT);
        if found.is_ok() {
            break;
        }
    }
    let stream = found.map_err(failed)?;
    stream.set_nodelay(true).map_err(failed)?;
    set_tcp_user_timeout(&stream, UNACKNOWLEDGED_MS).map_err(|error| failed(error.into()))?;
    Line::from_fd(stream.into())
}

fn refused(path: &Path, error: Errno) -> PortError {
    let reason = match error {
        // Rights to the file give EACCES.
        Errno::PERM => {
            let advice = "not permitted, whatever the group: the device is closed to this service (DeviceAllow= of its unit, and \
                          the driver loaded before it starts: restart it) or container (start it with --device)";
            let path = path.display().to_string();
            return PortError::Open {
                path,
                advice: advice.to_owned(),
                reason: io::ErrorKind::PermissionDenied,
            };
        }
        Errno::NOENT | Errno::NODEV | Errno::NXIO | Errno::IO => io::ErrorKind::NotFound,
        // What TIOCEXCL and the lock of another program give.
        Errno::BUSY | Errno::AGAIN => io::ErrorKind::ResourceBusy,
        _ => io::Error::from(error).kind(),
    };
    PortError::refused(path, reason, &error)
}

fn kind_of(stat: &Stat) -> LineKind {
    match major(stat.st_rdev) {
        _ if FileType::from_raw_mode(stat.st_mode) != FileType::CharacterDevice => LineKind::Socket,
        number if PTY_MAJORS.contains(&number) => LineKind::Pty,
        ACM_MAJOR => LineKind::UsbDevice,
        _ => LineKind::Uart,
    }
}

fn set_up(fd: &OwnedFd, path: &Path, baud: u32, kind: LineKind) -> Result<(), PortError> {
    let refused = |error: Errno| refused(path, error);
    let mut wanted = tcgetattr(fd).map_err(refused)?;
    make_raw(&mut wanted);
    wanted.set_speed(baud).map_err(refused)?;
    let given = tcsetattr(fd, OptionalActions::Now, &wanted).and_then(|()| tcgetattr(fd));
    let given = match given {
        Ok(given) => given,
        Err(Errno::INVAL | Errno::RANGE) => return Err(PortError::baud(path, baud, None)),
        Err(error) => return Err(refused(error)),
    };
    if kind == LineKind::Uart && !is_near(given.output_speed(), baud) {
        return Err(PortError::baud(path, baud, Some(given.output_speed())));
    }
    Ok(())
}

fn make_raw(line: &mut Termios) {
    line.make_raw();
    line.control_modes |= ControlModes::CLOCAL | ControlModes::CREAD;
    line.control_modes -= ControlModes::HUPCL | ControlModes::CSTOPB | ControlModes::CRTSCTS;
    // A read that finds nothing must report it, and not look like the end of the line.
    line.special_codes[SpecialCodeIndex::VMIN] = 1;
    line.special_codes[SpecialCodeIndex::VTIME] = 0;
}

/// Asks an FTDI converter to hold bytes back for 1 ms only; gives what it then does. Where that is not allowed (the rule of udev in
/// the package allows it), the caller sees it in the value.
fn quicken(file: &PathBuf) -> Option<u16> {
    if places::number(file)? > 1 {
        drop(fs::write(file, "1"));
    }
    places::number(file)
}

#[cfg(test)]
mod tests {
    use super::{Errno, quicken, refused};
    use crate::{Line, LineKind, PortError, Written};
    use core::time::Duration;
    use grip_sim::Pty;
    use rustix::termios::{ControlModes, InputModes, LocalModes, tcgetattr};
    use std::{fs, os::fd::AsFd as _, path::Path};

    const BAUD: u32 = 2_000_000;

    #[test]
    fn a_line_is_raw_stays_up_and_drops_what_is_stale() {
        let pty = Pty::open(None).unwrap();
        assert_eq!(pty.write(b"stale").unwrap(), 5);
        let mut line = Line::open(pty.port(), BAUD).unwrap();
        assert_eq!(line.kind(), LineKind::Pty);
        let state = tcgetattr(line.as_fd()).unwrap();
        assert_eq!(state.output_speed(), BAUD);
        assert!(state.control_modes.contains(ControlModes::CLOCAL | ControlModes::CREAD));
        assert!(!state.control_modes.contains(ControlModes::HUPCL));
        assert!(!state.local_modes.intersects(LocalModes::ECHO | LocalModes::ICANON));
        assert!(!state.input_modes.intersects(InputModes::IXON | InputModes::ICRNL));
        assert_eq!(line.read(&mut [0; 16], Duration::ZERO).unwrap(), 0);
        let all: Vec<u8> = (0..=255).collect();
        assert_eq!(line.write_frame(&all).unwrap(), Written::Whole);
        let mut got = Vec::new();
        while got.len() < all.len() {
            assert!(pty.wait(20_000_000, false).unwrap().read);
            let mut input = [0; 64];
            let count = pty.read(&mut input).unwrap();
            got.extend_from_slice(&input[..count]);
        }
        assert_eq!(got, all);
    }

    #[test]
    fn a_line_is_held_alone_also_against_root_and_again_after_its_end() {
        let pty = Pty::open(None).unwrap();
        let line = Line::open(pty.port(), BAUD).unwrap();
        let refused = Line::open(pty.port(), BAUD).unwrap_err();
        assert!(refused.to_string().contains("busy"), "{refused}");
        assert!(refused.is_temporary());
        drop(line);
        assert!(Line::open(pty.port(), BAUD).is_ok());
    }

    #[test]
    fn a_device_that_is_closed_to_the_service_is_no_matter_of_groups() {
        let path = Path::new("/dev/ttyACM0");
        let closed = refused(path, Errno::PERM);
        assert!(closed.to_string().contains("DeviceAllow") && closed.is_temporary(), "{closed}");
        assert!(!closed.to_string().contains("add your user"), "{closed}");
        assert!(refused(path, Errno::ACCESS).to_string().contains("add your user"));
    }

    #[test]
    fn a_terminal_that_goes_away_closes_the_line() {
        let pty = Pty::open(None).unwrap();
        let mut line = Line::open(pty.port(), BAUD).unwrap();
        drop(pty);
        let patience = Duration::from_secs(20);
        assert!(matches!(line.read(&mut [0; 16], patience), Err(PortError::Closed)));
    }

    #[test]
    fn baud_rates_that_are_refused() {
        let pty = Pty::open(None).unwrap();
        for baud in [0, 1200] {
            let error = Line::open(pty.port(), baud).unwrap_err();
            assert!(matches!(error, PortError::Argument(_)), "{error}");
        }
        for baud in [9600, 115_200, 921_600, 1_234_567, 3_000_000] {
            assert!(Line::open(pty.port(), baud).is_ok(), "{baud}");
        }
    }

    #[test]
    fn no_serial_ports() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        fs::write(&file, "kept").unwrap();
        for path in [file.as_path(), folder.path(), Path::new("/dev/null")] {
            let error = Line::open(path, BAUD).unwrap_err().to_string();
            assert!(error.contains("no serial port"), "{error}");
        }
        assert_eq!(fs::read(&file).unwrap(), b"kept");
        let error = Line::open(&folder.path().join("none"), BAUD).unwrap_err();
        assert!(error.to_string().contains("no such port") && error.is_temporary(), "{error}");
    }

    #[test]
    fn the_latency_timer_is_set_and_read_back() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("latency_timer");
        assert_eq!(quicken(&file), None);
        fs::write(&file, "16\n").unwrap();
        assert_eq!(quicken(&file), Some(1));
        assert_eq!(quicken(&file), Some(1));
        fs::write(&file, "rubbish").unwrap();
        assert_eq!(quicken(&file), None);
    }
}
