//! What the threads of a connection share: what is known of the gripper, and lines of the log.

use core::{
    sync::atomic::{AtomicBool, Ordering},
    time::Duration,
};
use grip_daemon::log::LogLevel;
use grip_fleet::{LastReceived, Part, Spool, Stamp, Uid};
use grip_link::message::{NackReason, daemon::Command};
use std::{
    sync::{Arc, Mutex, MutexGuard, PoisonError, mpsc::Sender},
    thread,
};

/// Pause between two looks at what was asked.
pub(crate) const PAUSE: Duration = Duration::from_millis(10);
/// A line of the log.
pub(crate) type Message = (LogLevel, String);

/// A publication on its way.
pub(crate) type Outgoing = (Part, Stamp, Vec<u8>);

/// A command from the network, by the number of its question.
pub(crate) type Order = (u64, Command);
/// What became of it.
pub(crate) type Answered = (u64, Result<(), NackReason>);

/// What is known of the gripper, for all threads.
#[derive(Debug, Default)]
pub(crate) struct Kept {
    /// Which one it is, and its events, as soon as it is known.
    pub(crate) gripper: Option<(Uid, Spool)>,
    /// The last frames of what does not go into the log.
    pub(crate) status: Vec<Vec<u8>>,
    /// What the gripper is made of, as JSON.
    pub(crate) about: String,
    /// What a RELEASE must bear, where gripd takes commands.
    pub(crate) token: Option<u32>,
    /// Latched fault of the gripper; 0 for none.
    pub(crate) fault: u16,
    /// Wall clock at the start of gripd (ns since 1970).
    pub(crate) start_ns: u64,
    /// Where gripd was when it was last received from.
    pub(crate) received: Option<LastReceived>,
}

/// What the threads share.
#[derive(Clone, Debug)]
pub(crate) struct Common {
    kept: Arc<Mutex<Kept>>,
    ended: Arc<AtomicBool>,
    messages: Sender<Message>,
}

impl Common {
    pub(crate) fn new(messages: Sender<Message>) -> Self {
        Self { kept: Arc::default(), ended: Arc::default(), messages }
    }

    /// What a thread that has panicked left is still data.
    pub(crate) fn kept(&self) -> MutexGuard<'_, Kept> {
        self.kept.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(crate) fn report(&self, level: LogLevel, text: impl Into<String>) {
        // A console that is gone reads nothing.
        let _gone = self.messages.send((level, text.into()));
    }

    pub(crate) fn has_ended(&self) -> bool {
        self.ended.load(Ordering::Relaxed)
    }

    pub(crate) fn end(&self) {
        self.ended.store(true, Ordering::Relaxed);
    }
}

#[expect(
    clippy::disallowed_methods,
    reason = "the driver may wait; nobody waits for these threads"
)]
pub(crate) fn pause(time: Duration) {
    thread::sleep(time);
}
