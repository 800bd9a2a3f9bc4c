//! Listening and connected sockets of an address.

use core::time::Duration;
use grip_session::config::Listen;
use rustix::net::sockopt;
use std::fs;
use std::io::{self, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::os::fd::{AsFd, BorrowedFd};
use std::os::unix::fs::{FileTypeExt as _, PermissionsExt as _};
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Who may open a socket file: owner and group.
const SOCKET_MODE: u32 = 0o660;
/// A peer that is silent on TCP is asked for a sign of life after this time.
const KEEPALIVE_IDLE: Duration = Duration::from_secs(20);
/// Time between two such questions.
const KEEPALIVE_STEP: Duration = Duration::from_secs(5);
/// Questions without an answer after which the connection is gone.
const KEEPALIVE_COUNT: u32 = 3;

/// Why nothing listens.
#[derive(Debug, Error)]
pub enum ListenError {
    /// Other computers could connect, and nobody said that they may.
    #[error(
        "{listen}: other computers could connect; set allow_remote to true if they shall, and read there what this means"
    )]
    Remote {
        /// Where.
        listen: Listen,
    },
    /// A program answers there already.
    #[error("{listen}: another program listens there")]
    Answered {
        /// Where.
        listen: Listen,
    },
    /// The path leads to something that is no socket, and is left alone.
    #[error("{}: exists and is no socket", path.display())]
    NoSocket {
        /// The path.
        path: PathBuf,
    },
    /// The system refuses.
    #[error("cannot listen at {listen}: {source}; --listen, or the key listen, names another")]
    System {
        /// Where.
        listen: Listen,
        /// Why.
        source: io::Error,
    },
}

/// What is reported where other computers may connect.
pub const REMOTE_WARNING: &str = "other computers can connect: nothing is encrypted and nobody is asked who he is; whoever reaches this port can read everything and, where commands are allowed, move the gripper";

/// A socket that takes connections.
#[derive(Debug)]
pub(crate) enum Listener {
    Tcp(TcpListener),
    Unix(UnixListener, PathBuf),
}

impl Listener {
    /// Opens the socket; `None` for [`Listen::Off`].
    pub(crate) fn open(listen: &Listen) -> Result<Option<Self>, ListenError> {
        let system = |source: io::Error| match source.kind() {
            io::ErrorKind::AddrInUse => ListenError::Answered { listen: listen.clone() },
            _ => ListenError::System { listen: listen.clone(), source },
        };
        Ok(Some(match listen {
            Listen::Off => return Ok(None),
            Listen::Tcp(address) => {
                let listener = TcpListener::bind(address).map_err(system)?;
                listener.set_nonblocking(true).map_err(system)?;
                Self::Tcp(listener)
            }
            Listen::Unix(path) => {
                clear(path, listen)?;
                let listener = UnixListener::bind(path).map_err(system)?;
                let mode = fs::Permissions::from_mode(SOCKET_MODE);
                fs::set_permissions(path, mode).map_err(system)?;
                listener.set_nonblocking(true).map_err(system)?;
                Self::Unix(listener, path.clone())
            }
        }))
    }

    /// Where it really listens: with the port that the system chose for port 0.
    pub(super) fn place(&self) -> io::Result<Listen> {
        match self {
            Self::Tcp(listener) => listener.local_addr().map(Listen::Tcp),
            Self::Unix(_, path) => Ok(Listen::Unix(path.clone())),
        }
    }

    pub(crate) fn accept(&self) -> io::Result<Stream> {
        let stream = match self {
            Self::Tcp(listener) => Stream::Tcp(listener.accept()?.0),
            Self::Unix(listener, _) => Stream::Unix(listener.accept()?.0),
        };
        stream.prepare()?;
        Ok(stream)
    }

    pub(crate) fn fd(&self) -> BorrowedFd<'_> {
        match self {
            Self::Tcp(listener) => listener.as_fd(),
            Self::Unix(listener, _) => listener.as_fd(),
        }
    }
}

impl Drop for Listener {
    fn drop(&mut self) {
        if let Self::Unix(_, path) = self {
            // A file that stays is replaced at the next start.
            let _gone = fs::remove_file(path);
        }
    }
}

/// Removes the socket file of a daemon that has died; whatever else stands there is left alone.
fn clear(path: &Path, listen: &Listen) -> Result<(), ListenError> {
    let Ok(found) = fs::symlink_metadata(path) else { return Ok(()) };
    if !found.file_type().is_socket() {
        return Err(ListenError::NoSocket { path: path.to_owned() });
    }
    match UnixStream::connect(path) {
        Err(refused) if refused.kind() == io::ErrorKind::ConnectionRefused => {
            let system = |source| ListenError::System { listen: listen.clone(), source };
            fs::remove_file(path).map_err(system)
        }
        _ => Err(ListenError::Answered { listen: listen.clone() }),
    }
}

/// A connection, of either kind.
#[derive(Debug)]
pub enum Stream {
    /// TCP.
    Tcp(TcpStream),
    /// A socket file.
    Unix(UnixStream),
}

impl Stream {
    /// Connects to a daemon and waits for it at most so long.
    ///
    /// # Errors
    /// What the system states.
    pub fn connect(listen: &Listen, patience: Duration) -> io::Result<Self> {
        match listen {
            Listen::Off => Err(io::Error::new(io::ErrorKind::InvalidInput, "off is no address")),
            Listen::Tcp(address) => {
                let stream = TcpStream::connect_timeout(address, patience)?;
                stream.set_nodelay(true)?;
                Ok(Self::Tcp(stream))
            }
            Listen::Unix(path) => UnixStream::connect(path).map(Self::Unix),
        }
    }

    /// A read waits at most so long.
    ///
    /// # Errors
    /// What the system states.
    pub fn set_read_timeout(&self, timeout: Duration) -> io::Result<()> {
        match self {
            Self::Tcp(stream) => stream.set_read_timeout(Some(timeout)),
            Self::Unix(stream) => stream.set_read_timeout(Some(timeout)),
        }
    }

    /// Never waits from now on; small frames leave at once, and a peer that is gone is noticed.
    fn prepare(&self) -> io::Result<()> {
        match self {
            Self::Tcp(stream) => {
                stream.set_nodelay(true)?;
                sockopt::set_socket_keepalive(stream, true)?;
                sockopt::set_tcp_keepidle(stream, KEEPALIVE_IDLE)?;
                sockopt::set_tcp_keepintvl(stream, KEEPALIVE_STEP)?;
                sockopt::set_tcp_keepcnt(stream, KEEPALIVE_COUNT)?;
                stream.set_nonblocking(true)
            }
            Self::Unix(stream) => stream.set_nonblocking(true),
        }
    }

    pub(crate) fn fd(&self) -> BorrowedFd<'_> {
        match self {
            Self::Tcp(stream) => stream.as_fd(),
            Self::Unix(stream) => stream.as_fd(),
        }
    }
}

impl Read for Stream {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        match self {
            Self::Tcp(stream) => stream.read(bytes),
            Self::Unix(stream) => stream.read(bytes),
        }
    }
}

impl Write for Stream {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match self {
            Self::Tcp(stream) => stream.write(bytes),
            Self::Unix(stream) => stream.write(bytes),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::{Listen, ListenError, Listener};

    #[test]
    fn a_dead_socket_file_is_replaced_and_a_living_one_or_another_file_is_not() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("socket");
        let listen = Listen::Unix(path.clone());
        drop(std::os::unix::net::UnixListener::bind(&path).unwrap());
        assert!(path.exists());
        let first = Listener::open(&listen).unwrap();
        let second = Listener::open(&listen).unwrap_err();
        assert!(matches!(second, ListenError::Answered { .. }), "{second}");
        drop(first);
        assert!(!path.exists());
        std::fs::write(&path, "precious").unwrap();
        assert!(matches!(Listener::open(&listen), Err(ListenError::NoSocket { .. })));
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "precious");
    }
}
