//! What a host is asked in, lines for its peer in Python out: `new T`, `open T SESSION`, `close T`, `rx T HEX`, `tx T`,
//! `grip T MODE FLAGS TTL FORCE SLEW CAUSE`, `beat T TURNS LONGEST LATE FLAGS`, `estop T`, `config T` with the fields of
//! CONFIG, `start T`, `stop T`, `clear T FAULT`.

use super::host_words::state_words;
use super::words::hex;
use grip_link::host::{GripCommand, HostLink};
use grip_link::message::{Config, FaultCode, Heartbeat};

/// One call of a host.
#[derive(Debug, Clone, Copy)]
pub enum Call<'a> {
    /// Another host, closed.
    New,
    /// The port is open.
    Open(u16),
    /// The port is gone.
    Close,
    /// Bytes come, or time goes on.
    Receive(&'a [u8]),
    /// All that is due is written.
    Transmit,
    /// A force command.
    Grip(GripCommand),
    /// Health of the hot loop.
    Heartbeat(Heartbeat),
    /// A stop.
    Estop,
    /// Other limits.
    Reconfigure(Config),
    /// Samples again.
    Start,
    /// No more samples.
    Stop,
    /// A fault is to be cleared.
    ClearFault(FaultCode),
}

impl Call<'_> {
    /// The call in the language of the peer.
    pub fn line(&self, now_us: u64) -> String {
        match self {
            Self::New => format!("new {now_us}"),
            Self::Open(session) => format!("open {now_us} {session:04x}"),
            Self::Close => format!("close {now_us}"),
            Self::Receive(bytes) => format!("rx {now_us} {}", hex(bytes)),
            Self::Transmit => format!("tx {now_us}"),
            Self::Grip(c) => format!(
                "grip {now_us} {} {} {} {} {} {}",
                c.mode.code(),
                u8::from(c.answers_slip),
                c.ttl_ms,
                c.force_mn,
                c.slew_mn_s,
                c.cause_sample
            ),
            Self::Heartbeat(b) => {
                format!("beat {now_us} {} {} {} {}", b.turns, b.longest_us, b.late, b.flags)
            }
            Self::Estop => format!("estop {now_us}"),
            Self::Reconfigure(c) => format!("config {now_us} {}", config_words(c)),
            Self::Start => format!("start {now_us}"),
            Self::Stop => format!("stop {now_us}"),
            Self::ClearFault(fault) => format!("clear {now_us} {:04x}", fault.0),
        }
    }
}

/// The fields of a CONFIG in their order on the wire.
pub fn config_words(c: &Config) -> String {
    format!(
        "{} {} {} {} {} {} {} {} {} {}",
        c.sample_rate_hz,
        c.batch,
        c.format.code(),
        c.ttl_ms,
        c.channel_mask,
        c.force_max_mn,
        c.slew_mn_s,
        c.hold_cap_mn,
        c.loss_after_ms,
        c.loss_action.code()
    )
}

/// The calls of a life, and all that the host reports to them, each with how it stands afterwards.
#[derive(Debug, Default)]
pub struct Talk {
    /// The calls in the language of the peer.
    pub lines: Vec<String>,
    /// What the peer has to answer.
    pub stated: Vec<String>,
}

/// Keeps a [`Talk`], where somebody wants it.
#[derive(Debug)]
pub struct Notes(pub Option<Talk>);

impl Notes {
    /// One more call; nothing has happened to `host` since the one before.
    pub fn take(&mut self, host: &HostLink, now_us: u64, call: &Call<'_>) {
        self.stands(host);
        if let Some(talk) = &mut self.0 {
            talk.lines.push(call.line(now_us));
        }
    }

    /// An answer to the call.
    pub fn line(&mut self, words: impl FnOnce() -> String) {
        if let Some(talk) = &mut self.0 {
            talk.stated.push(words());
        }
    }

    /// A frame that was asked for.
    pub fn wrote(&mut self, len: Option<usize>, out: &[u8]) {
        self.line(|| len.map_or("none".to_owned(), |len| format!("frame {}", hex(&out[..len]))));
    }

    /// How `host` stands after the last call.
    pub fn stands(&mut self, host: &HostLink) {
        if let Some(talk) = self.0.as_mut().filter(|talk| !talk.lines.is_empty()) {
            talk.stated.push(state_words(host));
        }
    }
}
