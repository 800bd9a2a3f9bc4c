//! What the microcontroller still has to report: short replies and events, oldest first.

use crate::message::{Ack, ConfigAck, Event, Nack, Ping};

/// An answer to one request.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Reply {
    Ident { session: u16 },
    Config(ConfigAck),
    Ack(Ack),
    Nack(Nack),
    Pong { ping: Ping, rx_tick: u64 },
}

/// A ring of N items that drops the oldest.
#[derive(Debug, Clone)]
pub(crate) struct Ring<T, const N: usize> {
    items: [Option<T>; N],
    first: usize,
    used: usize,
    dropped: u32,
}

impl<T: Copy, const N: usize> Ring<T, N> {
    pub(crate) const fn new() -> Self {
        Self { items: [None; N], first: 0, used: 0, dropped: 0 }
    }

    pub(crate) const fn dropped(&self) -> u32 {
        self.dropped
    }

    pub(crate) fn push(&mut self, item: T) {
        if self.used == N {
            self.pop();
            self.dropped = self.dropped.saturating_add(1);
        }
        if let Some(slot) = self.items.get_mut((self.first + self.used) % N) {
            *slot = Some(item);
            self.used += 1;
        }
    }

    pub(crate) fn peek(&self) -> Option<T> {
        self.items.get(self.first).copied().flatten()
    }

    pub(crate) fn pop(&mut self) {
        if let Some(slot) = self.items.get_mut(self.first)
            && slot.take().is_some()
        {
            self.first = (self.first + 1) % N;
            self.used -= 1;
        }
    }
}

/// Replies and events that wait.
#[derive(Debug, Clone)]
pub(crate) struct Outbox {
    pub(crate) replies: Ring<Reply, 8>,
    pub(crate) events: Ring<Event, 8>,
}

impl Outbox {
    pub(crate) const fn new() -> Self {
        Self { replies: Ring::new(), events: Ring::new() }
    }
}
