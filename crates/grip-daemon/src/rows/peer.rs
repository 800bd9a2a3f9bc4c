//! Opened source of rows: bytes from it and lines back to it, without waiting for either.

use super::{RowsAddress, RowsFault};
use crate::clients::{ListenError, Listener, Stream};
use core::net::SocketAddr;
use grip_session::config::Listen;
use rustix::{
    event::{PollFd, PollFlags, Timespec, poll},
    io::Errno,
    stdio::{stdin, stdout},
};
use std::{
    io::{self, Read as _, Write as _},
    net::UdpSocket,
    os::{
        fd::{AsFd as _, BorrowedFd},
        unix::net::UnixDatagram,
    },
};

/// Bytes back that may wait; further lines are left out.
const UNSENT: usize = 64 * 1024;

/// The other program.
#[derive(Debug)]
pub(super) enum Peer {
    /// Standard input; commands go to standard output, beside the events.
    Stdin,
    /// Nobody has connected yet.
    Expected(Listener),
    /// Somebody has; others can connect until its header is there.
    Connected { stream: Stream, unsent: Vec<u8>, listener: Option<Listener> },
    /// Datagrams, of the sender of the header alone.
    Udp { socket: UdpSocket, sender: Option<SocketAddr> },
    /// A thread of this program that reads a sensor; it wants nothing back.
    Fed(UnixDatagram),
}

/// What came.
#[derive(Debug)]
pub(super) enum Received<'a> {
    Nothing,
    Bytes(&'a [u8]),
    Datagram(&'a [u8]),
    End,
    /// The connection broke, which is the end of its rows too.
    Broken(io::Error),
}

impl Peer {
    pub(super) fn open(address: &RowsAddress) -> Result<Self, RowsFault> {
        match address {
            RowsAddress::Stdin => Ok(Self::Stdin),
            RowsAddress::Stream(listen) => {
                let listener = Listener::open(listen)?;
                // Never off: the address was parsed.
                let off = || ListenError::Remote { listen: Listen::Off };
                Ok(Self::Expected(listener.ok_or_else(off)?))
            }
            RowsAddress::Udp(address) => {
                let place = format!("udp:{address}");
                let system = |source| RowsFault::System { place: place.clone(), source };
                let socket = UdpSocket::bind(address).map_err(system)?;
                socket.set_nonblocking(true).map_err(system)?;
                Ok(Self::Udp { socket, sender: None })
            }
        }
    }

    /// What to wait for.
    pub(super) fn fd(&self) -> BorrowedFd<'_> {
        match self {
            Self::Stdin => stdin(),
            Self::Expected(listener) => listener.fd(),
            Self::Connected { stream, .. } => stream.fd(),
            Self::Udp { socket, .. } => socket.as_fd(),
            Self::Fed(socket) => socket.as_fd(),
        }
    }

    /// Whether rows come from a thread of this program.
    pub(super) fn is_fed(&self) -> bool {
        matches!(self, Self::Fed(_))
    }

    pub(super) fn has_unsent(&self) -> bool {
        matches!(self, Self::Connected { unsent, .. } if !unsent.is_empty())
    }

    /// Takes what is there. After [`Received::End`] or [`Received::Broken`] nothing comes any more.
    pub(super) fn receive<'a>(&mut self, input: &'a mut [u8]) -> io::Result<Received<'a>> {
        let count = match self {
            Self::Stdin => return receive_stdin(input),
            Self::Expected(listener) => {
                match listener.accept() {
                    Ok(stream) => {
                        if let Self::Expected(listener) = core::mem::replace(self, Self::Stdin) {
                            let listener = Some(listener);
                            *self = Self::Connected { stream, unsent: Vec::new(), listener };
                        }
                    }
                    Err(error) if is_nothing(&error) => {}
                    Err(error) => return Err(error),
                }
                return Ok(Received::Nothing);
            }
            Self::Connected { stream, .. } => match stream.read(input) {
                Ok(count @ 1..) => count,
                Err(error) if is_nothing(&error) => return Ok(Received::Nothing),
                Ok(0) => return Ok(Received::End),
                Err(error) => return Ok(Received::Broken(error)),
            },
            Self::Fed(socket) => {
                return match socket.recv(input) {
                    Ok(count) => Ok(Received::Datagram(input.get(..count).unwrap_or(&[]))),
                    Err(error) if is_nothing(&error) => Ok(Received::Nothing),
                    Err(error) => Err(error),
                };
            }
            Self::Udp { socket, sender } => {
                let (count, from) = match socket.recv_from(input) {
                    Ok(received) => received,
                    Err(error) if is_nothing(&error) => return Ok(Received::Nothing),
                    // An answer that found nobody, or no way.
                    Err(error)
                        if matches!(
                            error.kind(),
                            io::ErrorKind::ConnectionRefused
                                | io::ErrorKind::HostUnreachable
                                | io::ErrorKind::NetworkUnreachable
                                | io::ErrorKind::PermissionDenied
                        ) =>
                    {
                        return Ok(Received::Nothing);
                    }
                    Err(error) => return Err(error),
                };
                if *sender.get_or_insert(from) != from {
                    return Ok(Received::Nothing);
                }
                if count == 0 {
                    return Ok(Received::End);
                }
                return Ok(Received::Datagram(input.get(..count).unwrap_or(&[])));
            }
        };
        Ok(Received::Bytes(input.get(..count).unwrap_or(&[])))
    }

    /// The header is there: nobody else is waited for. Without one (`is_source` is not set) the next program is; `false` where there can
    /// be none.
    pub(super) fn settle(&mut self, is_source: bool) -> bool {
        match self {
            Self::Connected { listener, .. } if is_source => *listener = None,
            Self::Connected { listener, .. } => match listener.take() {
                Some(listener) => *self = Self::Expected(listener),
                None => return false,
            },
            Self::Udp { sender, .. } if !is_source => *sender = None,
            // What others send fills the queue of the system no more; where it cannot be so, `receive` leaves it out. A socket of every
            // address stays as it is: connected, it would hear one of them alone.
            Self::Udp { socket, sender } => {
                let one = socket.local_addr().is_ok_and(|local| !local.ip().is_unspecified());
                let _refused = sender.filter(|_| one).map(|sender| socket.connect(sender));
            }
            Self::Stdin | Self::Expected(_) | Self::Fed(_) => return is_source,
        }
        true
    }

    /// Whether somebody has connected who has sent no header, and whether another one takes his place now.
    pub(super) fn replace_silent(&mut self) -> bool {
        let Self::Connected { stream, unsent, listener: Some(listener) } = self else {
            return false;
        };
        let next = listener.accept();
        let replaced = next.is_ok();
        if let Ok(next) = next {
            (*stream, *unsent) = (next, Vec::new());
        }
        replaced
    }

    /// A line about what happened; standard output has it already.
    pub(super) fn line(&mut self, line: &str) {
        if !matches!(self, Self::Stdin) {
            self.command(line);
        }
    }

    /// A line that nobody else writes; left out where the program does not take it.
    pub(super) fn command(&mut self, line: &str) {
        let line = format!("{line}\n");
        match self {
            Self::Stdin => write_stdout(line.as_bytes()),
            Self::Expected(_) | Self::Fed(_) => {}
            Self::Connected { unsent, .. } if unsent.len() + line.len() > UNSENT => {}
            Self::Connected { unsent, .. } => unsent.extend_from_slice(line.as_bytes()),
            Self::Udp { socket, sender } => {
                if let Some(sender) = sender {
                    let _lost = socket.send_to(line.as_bytes(), *sender);
                }
            }
        }
    }

    /// Writes what the program takes.
    pub(super) fn write(&mut self) {
        let Self::Connected { stream, unsent, .. } = self else { return };
        while !unsent.is_empty() {
            match stream.write(unsent) {
                Ok(count @ 1..) => drop(unsent.drain(..count)),
                Err(error) if is_nothing(&error) => return,
                // It does not listen: its rows may go on.
                Ok(0) | Err(_) => unsent.clear(),
            }
        }
    }
}

/// Whether a call only states that there is nothing to do yet.
fn is_nothing(error: &io::Error) -> bool {
    matches!(error.kind(), io::ErrorKind::WouldBlock | io::ErrorKind::Interrupted)
}

/// Whether `fd` is ready now; others may share it, so it cannot be made non-blocking.
fn is_ready(fd: BorrowedFd<'_>, flags: PollFlags) -> bool {
    let now = Timespec { tv_sec: 0, tv_nsec: 0 };
    poll(&mut [PollFd::from_borrowed_fd(fd, flags)], Some(&now)).is_ok_and(|ready| ready > 0)
}

fn receive_stdin(input: &mut [u8]) -> io::Result<Received<'_>> {
    if !is_ready(stdin(), PollFlags::IN) {
        return Ok(Received::Nothing);
    }
    match rustix::io::read(stdin(), &mut *input) {
        Ok(0) => Ok(Received::End),
        Ok(count) => Ok(Received::Bytes(input.get(..count).unwrap_or(&[]))),
        Err(Errno::AGAIN | Errno::INTR) => Ok(Received::Nothing),
        Err(error) => Err(error.into()),
    }
}

/// Writes a line that a pipe takes whole or not at all.
fn write_stdout(line: &[u8]) {
    if is_ready(stdout(), PollFlags::OUT) {
        let _lost = rustix::io::write(stdout(), line);
    }
}

#[cfg(test)]
mod tests {
    use super::Peer;
    use std::net::UdpSocket;

    /// Rows may come to any address of a socket that is bound to all of them, after the header too.
    #[test]
    fn only_a_socket_of_one_address_is_connected() {
        let source = UdpSocket::bind("127.0.0.1:0").unwrap();
        for (address, connected) in [("127.0.0.1:0", true), ("0.0.0.0:0", false)] {
            let socket = UdpSocket::bind(address).unwrap();
            let mut peer = Peer::Udp { socket, sender: source.local_addr().ok() };
            assert!(peer.settle(true));
            let Peer::Udp { socket, .. } = peer else { panic!("it stays what it is") };
            assert_eq!(socket.peer_addr().is_ok(), connected, "{address}");
        }
    }
}
