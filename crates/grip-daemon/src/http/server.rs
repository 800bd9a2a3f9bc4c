//! A listener and its connections, looked after whenever the service thread comes by: nothing here waits.

use super::{
    exchange::{Exchange, Limits},
    request::{Page, Refusal},
};
use core::net::SocketAddr;
use rustix::net::sockopt::set_socket_send_buffer_size;
use std::{
    io::{self, Read as _, Write as _},
    net::{Shutdown, TcpListener, TcpStream},
    os::fd::{AsFd as _, BorrowedFd},
};

/// Connections at a time; more are informed that the server is busy and closed.
const MOST: usize = 16;
/// Streams among them.
const MOST_STREAMS: usize = 4;
/// A stream whose client has not caught up for so long makes room for a new one (us).
const STALLED_US: u64 = 1_000_000;
/// What the system keeps for a client (bytes; Linux takes twice as much): without a limit it is megabytes, and minutes of a stream that
/// nobody reads.
const SEND_BYTES: usize = 32 * 1024;
/// Accepted in one turn, so that a flood leaves time for other work.
const AT_ONCE: usize = 32;

/// Why a server does not start.
#[derive(Debug, thiserror::Error)]
pub enum ServeError {
    /// The address is open to other computers.
    #[error("{0} is open to other computers, which is not allowed")]
    Remote(SocketAddr),
    /// The address cannot be had.
    #[error("cannot listen on {address}: {source}; --metrics, or the key metrics, names another")]
    Bind {
        /// The address.
        address: SocketAddr,
        /// What the system said.
        source: io::Error,
    },
}

/// A descriptor and what it waits for.
#[derive(Clone, Copy, Debug)]
pub struct Interest<'a> {
    /// The descriptor.
    pub fd: BorrowedFd<'a>,
    /// Bytes to read, or connections.
    pub read: bool,
    /// Room to write.
    pub write: bool,
}

/// The server.
#[derive(Debug)]
pub struct HttpServer {
    listener: TcpListener,
    /// Whether only this computer reaches it.
    loopback: bool,
    limits: Limits,
    connections: Vec<Connection>,
    refused: u64,
}

#[derive(Debug)]
struct Connection {
    stream: TcpStream,
    exchange: Exchange,
}

impl HttpServer {
    /// Listens on `address`, which must be a loopback address unless `allow_remote`.
    ///
    /// # Errors
    /// Where that is not so, or the address is taken.
    pub fn bind(address: SocketAddr, allow_remote: bool) -> Result<Self, ServeError> {
        let loopback = address.ip().to_canonical().is_loopback();
        if !allow_remote && !loopback {
            return Err(ServeError::Remote(address));
        }
        let bind = |source| ServeError::Bind { address, source };
        let listener = TcpListener::bind(address).map_err(bind)?;
        listener.set_nonblocking(true).map_err(bind)?;
        let connections = Vec::with_capacity(MOST);
        Ok(Self { listener, loopback, limits: Limits::default(), connections, refused: 0 })
    }

    /// The address in use: the port is chosen by the system where it was 0.
    ///
    /// # Errors
    /// What the system states.
    pub fn address(&self) -> io::Result<SocketAddr> {
        self.listener.local_addr()
    }

    /// Connections now, and those turned away so far.
    #[must_use]
    pub fn counts(&self) -> (usize, u64) {
        (self.connections.len(), self.refused)
    }

    /// What `poll` should wake for. A client that has sent its last byte is no longer listened to, or it would wake without end.
    pub fn interests(&self) -> impl Iterator<Item = Interest<'_>> {
        let listener = Interest { fd: self.listener.as_fd(), read: true, write: false };
        core::iter::once(listener).chain(self.connections.iter().map(|connection| Interest {
            fd: connection.stream.as_fd(),
            read: connection.exchange.listens(),
            write: !connection.exchange.to_send().is_empty(),
        }))
    }

    /// Takes what came, answers, and closes what is over. `now_us` is host time (us); `page` gives the page of a path.
    pub fn serve(&mut self, now_us: u64, page: &mut dyn FnMut(&str) -> Page) {
        self.accept(now_us);
        let behind_us = |connection: &Connection| connection.exchange.behind_us(now_us);
        let stalled = self.connections.iter().filter(|one| behind_us(one) >= STALLED_US).count();
        let mut room = (MOST_STREAMS + stalled).saturating_sub(self.streams());
        let mut page = |path: &str| {
            let content = page(path)?;
            room = room.checked_sub(content.more.into()).ok_or(Refusal::Unavailable)?;
            Ok(content)
        };
        for connection in &mut self.connections {
            connection.serve(now_us, &mut page);
        }
        for _ in MOST_STREAMS..self.streams() {
            let slowest = self.connections.iter_mut().filter(|one| one.exchange.streams());
            if let Some(slowest) = slowest.max_by_key(|one| behind_us(one)) {
                slowest.exchange.failed();
            }
        }
        self.connections.retain(|connection| !connection.exchange.is_over());
    }

    /// Adds `text` to every stream. One whose client does not keep up is closed.
    pub fn publish(&mut self, now_us: u64, text: &str) {
        for connection in &mut self.connections {
            connection.exchange.append(now_us, text);
            connection.send();
        }
    }

    /// Streams now.
    #[must_use]
    pub fn streams(&self) -> usize {
        self.connections.iter().filter(|connection| connection.exchange.streams()).count()
    }

    fn accept(&mut self, now_us: u64) {
        for _ in 0..AT_ONCE {
            // Nobody waits, or has hung up already, or there are no descriptors left: the next turn tries again.
            let Ok((stream, _)) = self.listener.accept() else { return };
            if stream.set_nonblocking(true).is_err()
                || set_socket_send_buffer_size(&stream, SEND_BYTES).is_err()
            {
                continue;
            }
            let mut exchange = Exchange::new(now_us, self.limits, self.loopback);
            if self.connections.len() < MOST {
                self.connections.push(Connection { stream, exchange });
            } else {
                self.refused += 1;
                exchange.refuse(now_us, Refusal::Unavailable);
                // Reported if that goes at once, closed in any case.
                let mut connection = Connection { stream, exchange };
                connection.send();
            }
        }
    }
}

impl Connection {
    fn serve(&mut self, now_us: u64, page: &mut dyn FnMut(&str) -> Page) {
        let mut bytes = [0; 2048];
        match self.stream.read(&mut bytes) {
            Ok(0) => self.exchange.hung_up(),
            Ok(count) => {
                self.exchange.receive(now_us, bytes.get(..count).unwrap_or(&[]), page);
            }
            Err(error) if is_for_later(&error) => {}
            Err(_) => self.exchange.failed(),
        }
        self.exchange.tick(now_us);
        self.send();
    }

    fn send(&mut self) {
        while !self.exchange.to_send().is_empty() {
            match self.stream.write(self.exchange.to_send()) {
                Ok(0) => self.exchange.failed(),
                Ok(count) => {
                    if self.exchange.was_sent(count) {
                        // Where this fails, the client is gone already.
                        self.stream.shutdown(Shutdown::Write).unwrap_or_default();
                    }
                }
                Err(error) if is_for_later(&error) => return,
                Err(_) => self.exchange.failed(),
            }
        }
    }
}

fn is_for_later(error: &io::Error) -> bool {
    matches!(error.kind(), io::ErrorKind::WouldBlock | io::ErrorKind::Interrupted)
}
