//! Client of a daemon by its address, for gripctl and other programs: its messages, one after the other, and requests to it.
//!
//! [`ClientLink`] has no socket; [`Client`] is one at its socket. Neither reads a clock: how long to wait is an argument.

mod report;
mod text;

pub use report::{Report, misfit};
pub use text::{event, lines};

use crate::clients::{Listen, Stream};
use core::time::Duration;
use grip_link::decoder::{Counters, Decoder, Role, Verdict};
use grip_link::frame::{self, Direction, Header, MAX_PAYLOAD, MAX_WIRE};
use grip_link::message::daemon::{Command, Load, Object, Subscribe, ToClient};
use grip_link::message::{Kind, PayloadError, Versions};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::Errno;
use std::io::{self, Read as _, Write as _};
use thiserror::Error;

/// Bytes read at once.
const CHUNK: usize = 16 * 1024;

/// Why a client cannot go on.
#[derive(Debug, Error)]
pub enum ClientError {
    /// Nobody listens there.
    #[error("no daemon answers at {listen}: {source}")]
    NoDaemon {
        /// Where.
        listen: Listen,
        /// Why.
        source: io::Error,
    },
    /// The daemon closed the connection.
    #[error("{listen}: the daemon closed the connection")]
    Closed {
        /// Where.
        listen: Listen,
    },
    /// The connection broke.
    #[error("{listen}: {source}")]
    Broken {
        /// Where.
        listen: Listen,
        /// Why.
        source: io::Error,
    },
}

/// One client's side of the protocol: bytes in, messages out, and requests as bytes. No socket.
#[derive(Debug)]
pub struct ClientLink {
    decoder: Decoder,
    session: u16,
    seq: u16,
    malformed: u32,
}

impl ClientLink {
    /// A session of this nonce; 0 becomes 1.
    #[must_use]
    pub fn new(nonce: u16) -> Self {
        let session = nonce.max(1);
        let mut decoder = Decoder::new(Role::Client);
        decoder.open_session(session, None);
        Self { decoder, session, seq: 0, malformed: 0 }
    }

    /// Bytes of SUBSCRIBE; the protocol versions are those of this program.
    pub fn subscribe(&mut self, wanted: &Subscribe) -> Vec<u8> {
        let wanted = Subscribe { versions: Versions::OURS, ..*wanted };
        self.request(Kind::SUBSCRIBE, |out| wanted.write(out))
    }

    /// Bytes of COMMAND.
    pub fn command(&mut self, command: &Command) -> Vec<u8> {
        self.request(Kind::COMMAND, |out| command.write(out))
    }

    /// Bytes of QUERY.
    pub fn query(&mut self) -> Vec<u8> {
        self.request(Kind::QUERY, |_| Ok(0))
    }

    /// Bytes of LOAD, a piece of a model.
    pub fn load(&mut self, piece: &Load<'_>) -> Vec<u8> {
        self.request(Kind::LOAD, |out| piece.write(out))
    }

    /// Bytes of SHADOW, a piece of a model that estimates beside the one in force.
    pub fn shadow(&mut self, piece: &Load<'_>) -> Vec<u8> {
        self.request(Kind::SHADOW, |out| piece.write(out))
    }

    /// Bytes of OBJECT, the name of the next object.
    pub fn object(&mut self, name: &str) -> Vec<u8> {
        let object = Object { text: name.as_bytes() };
        self.request(Kind::OBJECT, |out| object.write(out))
    }

    /// Number of the last request, as ACK and NACK name it.
    #[must_use]
    pub const fn last_request(&self) -> u16 {
        self.seq.wrapping_sub(1)
    }

    fn request(
        &mut self,
        kind: Kind,
        write: impl FnOnce(&mut [u8]) -> Result<usize, PayloadError>,
    ) -> Vec<u8> {
        let (mut payload, mut wire) = ([0; MAX_PAYLOAD], [0; MAX_WIRE]);
        let header = Header::new(Direction::ToDevice, kind, self.seq, self.session);
        let header = Header { ack_req: true, ..header };
        self.seq = self.seq.wrapping_add(1);
        let payload = write(&mut payload).ok().and_then(|len| payload.get(..len));
        let len = frame::encode(&header, payload.unwrap_or_default(), &mut wire).unwrap_or(0);
        wire.get(..len).unwrap_or_default().to_vec()
    }

    /// Takes bytes and hands out the messages that they end; bad frames and payloads are counted.
    pub fn receive(&mut self, mut bytes: &[u8], on: &mut dyn FnMut(&ToClient<'_>)) {
        while let Some(verdict) = self.decoder.next(&mut bytes) {
            let Verdict::Frame(frame) = verdict else { continue };
            match ToClient::parse(&frame) {
                Ok(message) => on(&message),
                Err(_) => self.malformed = self.malformed.saturating_add(1),
            }
        }
    }

    /// What was received so far.
    #[must_use]
    pub const fn counters(&self) -> &Counters {
        self.decoder.counters()
    }

    /// Good frames whose payload could not be read.
    #[must_use]
    pub const fn malformed(&self) -> u32 {
        self.malformed
    }
}

/// A connection to a daemon.
#[derive(Debug)]
pub struct Client {
    listen: Listen,
    stream: Stream,
    link: ClientLink,
    wanted: Subscribe,
}

impl Client {
    /// Connects, waiting at most so long, and asks for what is wanted. The nonce should differ from that of other clients.
    ///
    /// # Errors
    /// [`ClientError`].
    pub fn connect(
        listen: &Listen,
        nonce: u16,
        wanted: Subscribe,
        patience: Duration,
    ) -> Result<Self, ClientError> {
        let stream = Stream::connect(listen, patience)
            .map_err(|source| ClientError::NoDaemon { listen: listen.clone(), source })?;
        let link = ClientLink::new(nonce);
        let mut client = Self { listen: listen.clone(), stream, link, wanted };
        let bytes = client.link.subscribe(&wanted);
        client.send(&bytes)?;
        Ok(client)
    }

    /// Connects again after an error, as before, in a session of another nonce.
    ///
    /// # Errors
    /// [`ClientError`]; the old connection is gone in any case.
    pub fn reconnect(&mut self, nonce: u16, patience: Duration) -> Result<(), ClientError> {
        *self = Self::connect(&self.listen, nonce, self.wanted, patience)?;
        Ok(())
    }

    /// Asks for something else.
    ///
    /// # Errors
    /// [`ClientError`].
    pub fn subscribe(&mut self, wanted: Subscribe) -> Result<(), ClientError> {
        self.wanted = wanted;
        let bytes = self.link.subscribe(&wanted);
        self.send(&bytes)
    }

    /// Asks for everything known now; ACK of QUERY follows it.
    ///
    /// # Errors
    /// [`ClientError`].
    pub fn query(&mut self) -> Result<(), ClientError> {
        let bytes = self.link.query();
        self.send(&bytes)
    }

    /// Asks the gripper to do something; ACK states that it was passed on, NOTICE that it was carried out.
    ///
    /// # Errors
    /// [`ClientError`].
    pub fn command(&mut self, command: &Command) -> Result<(), ClientError> {
        let bytes = self.link.command(command);
        self.send(&bytes)
    }

    /// Brings a piece of a model; ACK of the last one states that the model is in force.
    ///
    /// # Errors
    /// [`ClientError`].
    pub fn load(&mut self, piece: &Load<'_>) -> Result<(), ClientError> {
        let bytes = self.link.load(piece);
        self.send(&bytes)
    }

    /// Brings a piece of a model that estimates beside the one in force; ACK of the last one confirms that it does.
    ///
    /// # Errors
    /// [`ClientError`].
    pub fn shadow(&mut self, piece: &Load<'_>) -> Result<(), ClientError> {
        let bytes = self.link.shadow(piece);
        self.send(&bytes)
    }

    /// Names the object that is grasped next; ACK states that the name stands.
    ///
    /// # Errors
    /// [`ClientError`].
    pub fn object(&mut self, name: &str) -> Result<(), ClientError> {
        let bytes = self.link.object(name);
        self.send(&bytes)
    }

    /// Waits at most so long for bytes, reads once, and hands out the messages that are complete; `false` when nothing came.
    ///
    /// # Errors
    /// [`ClientError`] when the connection is gone.
    pub fn wait(
        &mut self,
        timeout: Duration,
        on: &mut dyn FnMut(&ToClient<'_>),
    ) -> Result<bool, ClientError> {
        if !self.is_readable(timeout)? {
            return Ok(false);
        }
        let mut bytes = [0; CHUNK];
        let count = match self.stream.read(&mut bytes) {
            Ok(0) => return Err(ClientError::Closed { listen: self.listen.clone() }),
            Ok(count) => count,
            Err(error) if error.kind() == io::ErrorKind::Interrupted => return Ok(false),
            Err(source) => return Err(self.broken(source)),
        };
        self.link.receive(bytes.get(..count).unwrap_or_default(), on);
        Ok(true)
    }

    /// The protocol's side: counters and numbers.
    #[must_use]
    pub const fn link(&self) -> &ClientLink {
        &self.link
    }

    fn is_readable(&self, timeout: Duration) -> Result<bool, ClientError> {
        let mut fds = [PollFd::from_borrowed_fd(self.stream.fd(), PollFlags::IN)];
        let limit = Timespec {
            tv_sec: i64::try_from(timeout.as_secs()).unwrap_or(i64::MAX),
            tv_nsec: timeout.subsec_nanos().into(),
        };
        match poll(&mut fds, Some(&limit)) {
            Ok(ready) => Ok(ready > 0),
            Err(Errno::INTR) => Ok(false),
            Err(error) => Err(self.broken(error.into())),
        }
    }

    fn send(&mut self, bytes: &[u8]) -> Result<(), ClientError> {
        self.stream.write_all(bytes).map_err(|source| self.broken(source))
    }

    fn broken(&self, source: io::Error) -> ClientError {
        ClientError::Broken { listen: self.listen.clone(), source }
    }
}
