//! The roster and the network that fills it, shared by the pump and the window.

use crate::grippers::{FleetFeed, Roster};
use crate::source::FleetHandle;
use grip_scope::SourceStatus;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// All grippers.
#[derive(Debug)]
pub struct Hall(Mutex<Inside>);

#[derive(Debug)]
struct Inside {
    roster: Roster,
    handle: Option<FleetHandle>,
    seen_revision: u64,
}

/// What one look at the network brought.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Brought {
    /// Something that can be seen is new.
    pub changed: bool,
    /// More is waiting.
    pub more: bool,
}

impl Hall {
    /// A roster with a network, or one that is filled by hand.
    #[must_use]
    pub fn new(roster: Roster, handle: Option<FleetHandle>) -> Self {
        let seen_revision = roster.revision();
        Self(Mutex::new(Inside { roster, handle, seen_revision }))
    }

    /// Begins to watch a network.
    pub fn watch(&self, handle: FleetHandle) {
        self.inside().handle = Some(handle);
    }

    /// Moves at most `budget` items into the roster. Never waits.
    pub fn take_in(&self, budget: usize) -> Brought {
        let mut inside = self.inside();
        let Inside { roster, handle, seen_revision } = &mut *inside;
        let moved = handle.as_mut().map_or(0, |handle| handle.drain(roster, budget));
        let changed = core::mem::replace(seen_revision, roster.revision()) != roster.revision();
        Brought { changed, more: moved >= budget }
    }

    /// Takes one item, as if it came from the network.
    pub fn take(&self, feed: FleetFeed) {
        self.inside().roster.take(feed);
    }

    /// The network is of no use any more: a sentence.
    pub fn fail(&self, sentence: String) {
        self.take(FleetFeed::Status(SourceStatus::Failed { sentence }));
    }

    /// Looks at the roster.
    pub fn look<T>(&self, look: impl FnOnce(&Roster) -> T) -> T {
        look(&self.inside().roster)
    }

    /// What a thread that has panicked left is still data.
    fn inside(&self) -> MutexGuard<'_, Inside> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
