//! `tcp:ADDRESS:PORT`, `unix:PATH` or `off` in, listening and connected sockets out.

use core::fmt;
use core::net::SocketAddr;
use core::str::FromStr;
use core::time::Duration;
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

/// Where the daemon listens and its clients connect.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Listen {
    /// Nowhere.
    Off,
    /// At a TCP port.
    Tcp(SocketAddr),
    /// At a socket in the file system.
    Unix(PathBuf),
}

impl Listen {
    /// Where gripd listens unless it is told otherwise.
    pub const DEFAULT: &'static str = "tcp:127.0.0.1:7747";

    /// Whether only programs of this computer can connect.
    #[must_use]
    pub fn is_local(&self) -> bool {
        match self {
            Self::Off | Self::Unix(_) => true,
            Self::Tcp(address) => address.ip().to_canonical().is_loopback(),
        }
    }
}

impl fmt::Display for Listen {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Off => f.write_str("off"),
            Self::Tcp(address) => write!(f, "tcp:{address}"),
            Self::Unix(path) => write!(f, "unix:{}", path.display()),
        }
    }
}

/// A text that is no place to listen.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error(
    "{text:?} is no address: expected tcp:ADDRESS:PORT such as tcp:127.0.0.1:7747 or tcp:[::1]:7747, unix:PATH, or off"
)]
pub struct ListenSyntax {
    /// The text.
    pub text: String,
}

impl FromStr for Listen {
    type Err = ListenSyntax;

    fn from_str(text: &str) -> Result<Self, ListenSyntax> {
        let wrong = || ListenSyntax { text: text.to_owned() };
        if text == "off" {
            return Ok(Self::Off);
        }
        match text.split_once(':') {
            Some(("unix", path)) if !path.is_empty() => Ok(Self::Unix(path.into())),
            Some(("tcp", address)) => {
                let address = address.replacen("localhost:", "127.0.0.1:", 1);
                address.parse().map(Self::Tcp).map_err(|_| wrong())
            }
            _ => Err(wrong()),
        }
    }
}

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
    #[error("cannot listen at {listen}: {source}")]
    System {
        /// Where.
        listen: Listen,
        /// Why.
        source: io::Error,
    },
}

/// What is told where other computers may connect.
pub const REMOTE_WARNING: &str = "other computers can connect: nothing is encrypted and nobody is asked who he is; whoever reaches this port can read everything and, where commands are allowed, move the gripper";

/// A socket that takes connections.
#[derive(Debug)]
pub(super) enum Listener {
    Tcp(TcpListener),
    Unix(UnixListener, PathBuf),
}

impl Listener {
    /// Opens the socket; `None` for [`Listen::Off`].
    pub(super) fn open(listen: &Listen) -> Result<Option<Self>, ListenError> {
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

    pub(super) fn accept(&self) -> io::Result<Stream> {
        let stream = match self {
            Self::Tcp(listener) => Stream::Tcp(listener.accept()?.0),
            Self::Unix(listener, _) => Stream::Unix(listener.accept()?.0),
        };
        stream.prepare()?;
        Ok(stream)
    }

    pub(super) fn fd(&self) -> BorrowedFd<'_> {
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
pub(crate) enum Stream {
    Tcp(TcpStream),
    Unix(UnixStream),
}

impl Stream {
    /// Connects to a daemon and waits for it at most so long.
    pub(crate) fn connect(listen: &Listen, patience: Duration) -> io::Result<Self> {
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
    fn places_are_read_and_written_alike() {
        for text in ["off", "tcp:127.0.0.1:7747", "tcp:[::1]:7747", "unix:/run/gripd/gripd.sock"] {
            assert_eq!(text.parse::<Listen>().unwrap().to_string(), text);
        }
        assert_eq!("tcp:localhost:1".parse(), "tcp:127.0.0.1:1".parse::<Listen>());
        for text in ["", "tcp", "tcp:7747", "tcp:1.2.3.4", "unix:", "Off", "127.0.0.1:7747"] {
            let told = text.parse::<Listen>().unwrap_err().to_string();
            assert!(told.contains("unix:PATH"), "{told}");
        }
    }

    #[test]
    fn what_other_computers_can_reach_is_not_local() {
        let local = |text: &str| text.parse::<Listen>().unwrap().is_local();
        assert!(
            local("tcp:127.3.0.1:1") && local("tcp:[::1]:1") && local("unix:x") && local("off")
        );
        assert!(local("tcp:[::ffff:127.0.0.1]:1"));
        assert!(!local("tcp:0.0.0.0:1") && !local("tcp:[::]:1") && !local("tcp:192.168.1.2:1"));
    }

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
