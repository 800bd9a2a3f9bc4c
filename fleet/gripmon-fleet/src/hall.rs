//! The roster, shared by the thread of the network and the window; and when a frame of it is worth painting.

use crate::grippers::{FleetFeed, Roster};
use core::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use core::time::Duration;
use eframe::egui::Context;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Time between two frames of the table: grippers report what they do five times a second.
pub const FRAME: Duration = Duration::from_millis(200);

/// All grippers.
#[derive(Debug, Default)]
pub struct Hall {
    roster: Mutex<Roster>,
    /// The revision at the last look.
    seen: AtomicU64,
    hidden: AtomicBool,
}

impl Hall {
    /// A roster that is filled already.
    #[must_use]
    pub fn new(roster: Roster) -> Self {
        let seen = AtomicU64::new(roster.revision());
        Self { roster: Mutex::new(roster), seen, hidden: AtomicBool::new(false) }
    }

    /// Takes one item.
    pub fn take(&self, feed: FleetFeed) {
        self.roster().take(feed);
    }

    /// Looks at the roster.
    pub fn look<T>(&self, look: impl FnOnce(&Roster) -> T) -> T {
        look(&self.roster())
    }

    /// Nobody can see the table, or somebody can.
    pub fn set_hidden(&self, hidden: bool) {
        self.hidden.store(hidden, Ordering::Relaxed);
    }

    /// Asks for a frame, where something is new and somebody can see it.
    pub fn paint(&self, ctx: &Context) {
        let revision = self.roster().revision();
        let changed = self.seen.swap(revision, Ordering::Relaxed) != revision;
        if changed && !self.hidden.load(Ordering::Relaxed) {
            ctx.request_repaint_after(FRAME);
        }
    }

    /// What a thread that has panicked left is still data.
    fn roster(&self) -> MutexGuard<'_, Roster> {
        self.roster.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
