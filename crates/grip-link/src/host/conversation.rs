//! What the host's side remembers of one link, and the notices that wait for the caller.

use super::link::HostEvent;
use super::loss::RowCount;
use super::request::Request;
use super::{CloseReason, HostConfig, LinkState};
use crate::clock::ClockSync;
use crate::decoder::{Counters, Decoder};
use crate::frame::Direction;
use crate::message::{Config, Grip, Ident, Layout};
use crate::sender::Sender;

#[derive(Debug, Clone)]
pub(super) struct Conversation {
    pub(super) config: HostConfig,
    pub(super) sender: Sender,
    pub(super) state: LinkState,
    pub(super) announced: LinkState,
    /// An event that waits for the caller.
    pub(super) notice: Option<HostEvent>,
    pub(super) session: u16,
    pub(super) greet_again: bool,
    pub(super) hello_since_us: u64,
    pub(super) hello_due_us: u64,
    pub(super) hellos: u32,
    pub(super) bytes: u64,
    pub(super) at_open: Counters,
    pub(super) ident: Option<Ident>,
    pub(super) in_force: Option<Config>,
    pub(super) layout: Layout,
    pub(super) request: Option<Request>,
    pub(super) rows: RowCount,
    pub(super) clock: Option<ClockSync>,
    pub(super) pings: u8,
    pub(super) ping_due_us: u64,
    pub(super) samples_us: u64,
    pub(super) frame_us: u64,
    pub(super) cmd_id: u32,
    /// Force of the last GRIP of this session.
    pub(super) force_sent_mn: Option<i32>,
    pub(super) last_grip: Option<Grip>,
    pub(super) malformed: u32,
    pub(super) unexpected: u32,
    pub(super) failures: u8,
}

impl Conversation {
    pub(super) fn new(config: HostConfig) -> Self {
        Self {
            config,
            sender: Sender::new(Direction::ToDevice),
            state: LinkState::Closed,
            announced: LinkState::Closed,
            notice: None,
            session: 0,
            greet_again: false,
            hello_since_us: 0,
            hello_due_us: 0,
            hellos: 0,
            bytes: 0,
            at_open: Counters::default(),
            ident: None,
            in_force: None,
            layout: Layout::EMPTY,
            request: None,
            rows: RowCount::default(),
            clock: None,
            pings: 0,
            ping_due_us: 0,
            samples_us: 0,
            frame_us: 0,
            cmd_id: 0,
            force_sent_mn: None,
            last_grip: None,
            malformed: 0,
            unexpected: 0,
            failures: 0,
        }
    }

    pub(super) fn greet(&mut self, now_us: u64, session: u16, decoder: &mut Decoder) {
        self.session = session;
        self.sender.session = session;
        decoder.open_session(session, None);
        self.hello_since_us = now_us;
        self.hello_due_us = now_us;
        self.hellos = 0;
        self.in_force = None;
        self.request = None;
        self.force_sent_mn = None;
        self.frame_us = now_us;
    }

    pub(super) fn forget_loss(&mut self) {
        self.rows = RowCount::default();
    }

    pub(super) fn close(&mut self, reason: CloseReason) {
        self.state = LinkState::Closed;
        self.request = None;
        self.in_force = None;
        if reason != CloseReason::Requested {
            self.failures = self.failures.saturating_add(1);
        }
        self.notice = Some(HostEvent::Closed(reason));
    }

    pub(super) const fn is_linked(&self) -> bool {
        matches!(self.state, LinkState::Config | LinkState::Stream | LinkState::Degraded)
    }

    pub(super) const fn is_streaming(&self) -> bool {
        matches!(self.state, LinkState::Stream | LinkState::Degraded)
    }

    pub(super) fn pending(&mut self) -> Option<HostEvent> {
        if let Some(notice) = self.notice.take() {
            return Some(notice);
        }
        let (from, to) = (self.announced, self.state);
        self.announced = to;
        (from != to).then_some(HostEvent::State { from, to })
    }
}
