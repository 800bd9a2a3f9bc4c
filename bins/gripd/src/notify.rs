//! Notifier of the service manager: datagrams with what it wants to know; nothing where none asked.

use core::time::Duration;
use sd_notify::NotifyState;

/// The line to the service manager.
#[derive(Debug)]
pub(crate) struct Notify {
    /// Pause between two signs of life (us); `None` where nobody waits for them.
    every_us: Option<u64>,
    next_us: u64,
    turns: u64,
}

impl Notify {
    /// Whether a service manager started this program.
    pub(crate) fn is_asked_for() -> bool {
        std::env::var_os("NOTIFY_SOCKET").is_some()
    }

    pub(crate) fn new() -> Self {
        let half = |time: Duration| u64::try_from(time.as_micros() / 2).unwrap_or(u64::MAX);
        Self { every_us: sd_notify::watchdog_enabled().map(half), next_us: 0, turns: 0 }
    }

    /// The daemon serves.
    pub(crate) fn ready(&self) {
        send(&[NotifyState::Ready]);
    }

    /// The settings are read again.
    pub(crate) fn reloading(&self) {
        if let Ok(now) = NotifyState::monotonic_usec_now() {
            send(&[NotifyState::Reloading, now]);
        }
    }

    /// The daemon ends.
    pub(crate) fn stopping(&self) {
        send(&[NotifyState::Stopping]);
    }

    /// The hot loop has made so many turns: a sign of life, if it has gone on since the last one.
    pub(crate) fn alive(&mut self, turns: u64, now_us: u64) {
        let Some(every_us) = self.every_us else { return };
        if turns > self.turns && now_us >= self.next_us {
            (self.turns, self.next_us) = (turns, now_us + every_us);
            send(&[NotifyState::Watchdog]);
        }
    }
}

/// A service manager that does not listen is no reason to stop: it will act on its own.
fn send(state: &[NotifyState<'_>]) {
    let _received = sd_notify::notify(state);
}
