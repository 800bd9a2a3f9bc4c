//! Retry of a request (CONFIG, START, STOP, CLEAR_FAULT): when to send it again and whether an answer is its own.

use crate::message::Kind;

/// Times that a request is sent.
pub(crate) const TRIES: u8 = 3;
/// Time from try to try \[us\].
pub(crate) const RETRY_US: u64 = 50_000;

/// What was asked and not answered yet.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Request {
    pub(crate) kind: Kind,
    /// For CLEAR_FAULT: the fault.
    pub(crate) fault: u16,
    tries: u8,
    first_seq: u16,
    last_seq: u16,
    next_us: u64,
}

/// What is to be done about a request now.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Due {
    Wait,
    Send,
    GiveUp,
}

impl Request {
    pub(crate) const fn new(kind: Kind, fault: u16, now_us: u64) -> Self {
        Self { kind, fault, tries: 0, first_seq: 0, last_seq: 0, next_us: now_us }
    }

    pub(crate) const fn due(&self, now_us: u64) -> Due {
        if now_us < self.next_us {
            Due::Wait
        } else if self.tries < TRIES {
            Due::Send
        } else {
            Due::GiveUp
        }
    }

    pub(crate) const fn sent(&mut self, seq: u16, now_us: u64) {
        if self.tries == 0 {
            self.first_seq = seq;
        }
        self.last_seq = seq;
        self.tries += 1;
        self.next_us = now_us.saturating_add(RETRY_US);
    }

    pub(crate) const fn was_sent(&self) -> bool {
        self.tries > 0
    }

    /// Whether an answer with this type and seq belongs to one of the tries.
    pub(crate) const fn answered_by(&self, kind: Kind, seq: u16) -> bool {
        let since = seq.wrapping_sub(self.first_seq);
        self.kind.0 == kind.0
            && self.tries > 0
            && since <= self.last_seq.wrapping_sub(self.first_seq)
    }
}
