//! The pseudo-terminal of Linux.

use super::{PtyError, Ready};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fs::{Mode, OFlags, fcntl_getfl, fcntl_setfl, open};
use rustix::io::{Errno, read, write};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{OptionalActions, tcgetattr, tcsetattr};
use std::ffi::OsString;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::os::unix::ffi::OsStringExt;
use std::path::{Path, PathBuf};

/// An open pseudo-terminal; dropping it removes the link.
#[derive(Debug)]
pub struct Pty {
    device: OwnedFd,
    /// Kept open: without any open host side the device side reads EIO.
    _host: OwnedFd,
    port: PathBuf,
    link: Option<PathBuf>,
}

impl Pty {
    /// Opens a pair and, where `link` is given, a symbolic link to the host's side. An old link at that
    /// path is replaced; any other file is left alone.
    ///
    /// # Errors
    /// [`PtyError`] names the system call or the path.
    pub fn open(link: Option<&Path>) -> Result<Self, PtyError> {
        let device = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC)
            .map_err(in_call("openpt"))?;
        grantpt(&device).map_err(in_call("grantpt"))?;
        unlockpt(&device).map_err(in_call("unlockpt"))?;
        let name = ptsname(&device, Vec::new()).map_err(in_call("ptsname"))?;
        let port = PathBuf::from(OsString::from_vec(name.into_bytes()));
        let host = open(&port, OFlags::RDWR | OFlags::NOCTTY | OFlags::CLOEXEC, Mode::empty())
            .map_err(in_call("open"))?;
        let mut line = tcgetattr(&host).map_err(in_call("tcgetattr"))?;
        line.make_raw();
        tcsetattr(&host, OptionalActions::Now, &line).map_err(in_call("tcsetattr"))?;
        let flags = fcntl_getfl(&device).map_err(in_call("fcntl_getfl"))?;
        fcntl_setfl(&device, flags | OFlags::NONBLOCK).map_err(in_call("fcntl_setfl"))?;
        if let Some(link) = link {
            make_link(link, &port)?;
        }
        Ok(Self { device, _host: host, port, link: link.map(Path::to_owned) })
    }

    /// The host's side, such as /dev/pts/3.
    #[must_use]
    pub fn port(&self) -> &Path {
        &self.port
    }

    /// Waits up to `timeout_us` microseconds for bytes from the host or, where `to_write`, for room to write.
    ///
    /// # Errors
    /// [`PtyError::Call`] when poll fails; an interrupted wait is an early end, not an error.
    pub fn wait(&self, timeout_us: u64, to_write: bool) -> Result<Ready, PtyError> {
        let events = if to_write { PollFlags::IN | PollFlags::OUT } else { PollFlags::IN };
        let mut polled = [PollFd::new(&self.device, events)];
        match poll(&mut polled, Some(&timespec(timeout_us))) {
            Ok(_) => {}
            Err(Errno::INTR) => return Ok(Ready::default()),
            Err(source) => return Err(in_call("poll")(source)),
        }
        let seen = polled.iter().fold(PollFlags::empty(), |seen, fd| seen | fd.revents());
        Ok(Ready { read: seen.contains(PollFlags::IN), write: seen.contains(PollFlags::OUT) })
    }

    /// Reads what the host wrote, at most `buffer.len()` bytes; 0 where there is nothing.
    ///
    /// # Errors
    /// [`PtyError::Call`] when read fails for another reason than having nothing.
    pub fn read(&self, buffer: &mut [u8]) -> Result<usize, PtyError> {
        or_nothing(read(&self.device, buffer), "read")
    }

    /// Writes as much of `bytes` as the line takes; 0 where the host does not read.
    ///
    /// # Errors
    /// [`PtyError::Call`] when write fails for another reason than a full line.
    pub fn write(&self, bytes: &[u8]) -> Result<usize, PtyError> {
        or_nothing(write(&self.device, bytes), "write")
    }
}

/// The device's side, for those that wait for other things too; it never blocks.
impl AsFd for Pty {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.device.as_fd()
    }
}

impl Drop for Pty {
    fn drop(&mut self) {
        // Only a link that still points here is ours to remove; a failure leaves a dangling link, which the
        // next `open` replaces.
        if let Some(link) = &self.link
            && std::fs::read_link(link).is_ok_and(|target| target == self.port)
        {
            drop(std::fs::remove_file(link));
        }
    }
}

fn make_link(link: &Path, port: &Path) -> Result<(), PtyError> {
    let failed = |source| PtyError::Link { link: link.to_owned(), port: port.to_owned(), source };
    match std::fs::symlink_metadata(link) {
        Ok(old) if old.is_symlink() => std::fs::remove_file(link).map_err(failed)?,
        Ok(_) => return Err(PtyError::Occupied(link.to_owned())),
        Err(source) if source.kind() == std::io::ErrorKind::NotFound => {}
        Err(source) => return Err(failed(source)),
    }
    std::os::unix::fs::symlink(port, link).map_err(failed)
}

fn in_call(call: &'static str) -> impl Fn(Errno) -> PtyError {
    move |source| PtyError::Call { call, source: source.into() }
}

fn or_nothing(result: Result<usize, Errno>, call: &'static str) -> Result<usize, PtyError> {
    match result {
        Ok(count) => Ok(count),
        Err(Errno::AGAIN | Errno::INTR) => Ok(0),
        Err(source) => Err(in_call(call)(source)),
    }
}

fn timespec(us: u64) -> Timespec {
    let seconds = i64::try_from(us / 1_000_000).unwrap_or(i64::MAX);
    // Below 1e9, which every width of tv_nsec holds.
    let nanos = u32::try_from(us % 1_000_000 * 1000).unwrap_or(0);
    Timespec { tv_sec: seconds, tv_nsec: nanos.into() }
}
