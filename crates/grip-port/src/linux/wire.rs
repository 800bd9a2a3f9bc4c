//! Reads and writes of an open descriptor, in system calls of the hot path: poll(2), read(2) and write(2), none of which waits longer
//! than it is asked to, and no allocation.

use crate::{
    Line, LineKind, PortError,
    line::{Ready, Setup},
};
use core::time::Duration;
use rustix::{
    event::{PollFd, PollFlags, Timespec, poll},
    fs::{OFlags, fcntl_getfl, fcntl_setfl},
    io::{Errno, read, write},
    termios::ioctl_tiocnxcl,
};
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};

/// An open descriptor that does not block.
#[derive(Debug)]
pub(crate) struct Wire {
    fd: OwnedFd,
    /// Whether the driver was asked to refuse others, and must be asked again when that ends.
    exclusive: bool,
}

impl Wire {
    pub(crate) fn new(fd: OwnedFd, exclusive: bool) -> Self {
        Self { fd, exclusive }
    }

    /// Waits at most `timeout` for bytes, and where `to_write` for room.
    pub(crate) fn wait(&mut self, timeout: Duration, to_write: bool) -> Result<Ready, PortError> {
        let wanted = if to_write { PollFlags::IN | PollFlags::OUT } else { PollFlags::IN };
        let mut polled = [PollFd::new(&self.fd, wanted)];
        match poll(&mut polled, Some(&timespec(timeout))) {
            Ok(0) | Err(Errno::INTR) => return Ok(Ready::default()),
            Ok(_) => {}
            Err(error) => return Err(PortError::Read(error.into())),
        }
        let seen = polled.iter().fold(PollFlags::empty(), |seen, fd| seen | fd.revents());
        Ok(Ready {
            read: seen.contains(PollFlags::IN),
            write: seen.contains(PollFlags::OUT) && !seen.contains(PollFlags::HUP),
            gone: seen.intersects(PollFlags::HUP | PollFlags::ERR | PollFlags::NVAL),
        })
    }

    /// Reads what is there.
    pub(crate) fn take(&mut self, input: &mut [u8]) -> Result<usize, PortError> {
        match read(&self.fd, input) {
            Ok(0) => Err(PortError::Closed),
            Ok(count) => Ok(count),
            Err(Errno::AGAIN | Errno::INTR) => Ok(0),
            Err(error) if is_gone(error) => Err(PortError::Closed),
            Err(error) => Err(PortError::Read(error.into())),
        }
    }

    /// Writes what the system takes at once.
    pub(crate) fn push(&mut self, bytes: &[u8]) -> Result<usize, PortError> {
        match write(&self.fd, bytes) {
            Ok(count) => Ok(count),
            Err(Errno::AGAIN | Errno::INTR) => Ok(0),
            Err(error) if is_gone(error) => Err(PortError::Closed),
            Err(error) => Err(PortError::Write(error.into())),
        }
    }
}

impl Drop for Wire {
    fn drop(&mut self) {
        if self.exclusive {
            // The device may be gone, and the mark with it.
            let _ = ioctl_tiocnxcl(&self.fd);
        }
    }
}

impl Line {
    /// A line over a stream that is open already, such as one end of a socket pair; it is made non-blocking.
    ///
    /// # Errors
    /// [`PortError::Read`] where the stream cannot be made so.
    pub fn from_fd(fd: OwnedFd) -> Result<Self, PortError> {
        fcntl_getfl(&fd)
            .and_then(|flags| fcntl_setfl(&fd, flags | OFlags::NONBLOCK))
            .map_err(|error| PortError::Read(error.into()))?;
        let setup = Setup { kind: LineKind::Socket, baud: 0, latency_timer_ms: None };
        Ok(Self::new(Wire::new(fd, false), setup))
    }
}

/// For waiting on the line together with other things; bytes pass through [`Line`] alone.
impl AsFd for Line {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.wire().fd.as_fd()
    }
}

/// Whether an error means that nobody is at the other end any more: a device that was unplugged, a terminal or socket that was closed.
fn is_gone(error: Errno) -> bool {
    matches!(
        error,
        Errno::IO
            | Errno::NXIO
            | Errno::NODEV
            | Errno::PIPE
            | Errno::CONNRESET
            | Errno::NOTCONN
            | Errno::TIMEDOUT
            | Errno::HOSTUNREACH
            | Errno::NETUNREACH
    )
}

fn timespec(time: Duration) -> Timespec {
    // At most what every width holds; the wait may end early anyway.
    let tv_sec = i64::try_from(time.as_secs()).unwrap_or(i64::MAX).min(1_000_000);
    Timespec { tv_sec, tv_nsec: time.subsec_nanos().into() }
}
