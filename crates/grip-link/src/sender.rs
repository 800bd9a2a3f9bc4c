//! Payloads in, numbered frames of one direction out.

use crate::frame::{self, Direction, Header, MAX_PAYLOAD};
use crate::message::{Kind, PayloadError};

/// Counts and addresses outgoing frames.
#[derive(Debug, Clone)]
pub(crate) struct Sender {
    direction: Direction,
    seq: u16,
    sent: u32,
    /// Session written into frames.
    pub(crate) session: u16,
}

impl Sender {
    pub(crate) const fn new(direction: Direction) -> Self {
        Self { direction, seq: 0, sent: 0, session: 0 }
    }

    /// Number that the next frame gets.
    pub(crate) const fn next_seq(&self) -> u16 {
        self.seq
    }

    pub(crate) const fn sent(&self) -> u32 {
        self.sent
    }

    /// Writes a frame; `None`, and no number used, when it does not fit `out`.
    pub(crate) fn send(
        &mut self,
        kind: Kind,
        ack_req: bool,
        payload: &[u8],
        out: &mut [u8],
    ) -> Option<usize> {
        let header =
            Header { ack_req, ..Header::new(self.direction, kind, self.seq, self.session) };
        let len = frame::encode(&header, payload, out).ok()?;
        self.seq = self.seq.wrapping_add(1);
        self.sent = self.sent.saturating_add(1);
        Some(len)
    }

    /// As [`Sender::send`], with a message that writes its own payload.
    pub(crate) fn message(
        &mut self,
        kind: Kind,
        write: impl FnOnce(&mut [u8]) -> Result<usize, PayloadError>,
        out: &mut [u8],
    ) -> Option<usize> {
        let mut payload = [0; MAX_PAYLOAD];
        let len = write(&mut payload).ok()?;
        self.send(kind, false, payload.get(..len)?, out)
    }

    /// Sends in another session.
    pub(crate) fn within<T>(&mut self, session: u16, send: impl FnOnce(&mut Self) -> T) -> T {
        let own = core::mem::replace(&mut self.session, session);
        let sent = send(self);
        self.session = own;
        sent
    }
}
