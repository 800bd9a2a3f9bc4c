//! A source and the model that it fills, with the trigger that watches it: what the pump feeds and the window looks at.

use grip_scope::trigger::Found;
use grip_scope::{Model, Refused, SourceHandle, SourceStatus, Trigger};
use slip_core::ClientCommand;

/// Data and where they come from.
#[derive(Debug)]
pub struct Engine {
    /// The data.
    pub model: Model,
    source: Option<SourceHandle>,
    trigger: Option<Trigger>,
    found: Option<Found>,
    seen_revision: u64,
}

/// What one look at the source brought.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Brought {
    /// Something that can be seen is new.
    pub changed: bool,
    /// It is worth painting a view that stands still: the source's state is another, or the trigger has found something.
    pub urgent: bool,
    /// A file is on its way in: a view that stands still is worth painting now and then, for what is there and how far it is.
    pub loading: bool,
    /// More is waiting.
    pub more: bool,
}

impl Engine {
    /// A model with a source, or one that is filled by hand.
    #[must_use]
    pub const fn new(model: Model, source: Option<SourceHandle>) -> Self {
        let seen_revision = model.revision();
        Self { model, source, trigger: None, found: None, seen_revision }
    }

    /// Moves at most `budget` items into the model. Never waits.
    pub fn take_in(&mut self, budget: usize) -> Brought {
        let before = kind(self.model.status());
        let moved = self.source.as_mut().map_or(0, |source| source.drain(&mut self.model, budget));
        let found = self.trigger.as_mut().and_then(|trigger| trigger.poll(&self.model));
        let triggered = matches!(found, Some(Found::Hit(_)));
        if triggered || !matches!(self.found, Some(Found::Hit(_))) {
            self.found = found.or(self.found);
        }
        let revision = self.model.revision();
        let changed = core::mem::replace(&mut self.seen_revision, revision) != revision;
        let urgent = triggered || kind(self.model.status()) != before;
        let loading = changed && matches!(self.model.status(), SourceStatus::Loading { .. });
        Brought { changed, urgent, loading, more: moved >= budget }
    }

    /// What the trigger has found since the last call: the last hit, else the last sweep.
    pub const fn triggered(&mut self) -> Option<Found> {
        self.found.take()
    }

    /// Arms a trigger, or takes it away.
    pub fn watch(&mut self, trigger: Option<Trigger>) {
        self.trigger = trigger;
        self.found = None;
    }

    /// Whether a single trigger has done its work.
    #[must_use]
    pub fn is_trigger_done(&self) -> bool {
        self.trigger.as_ref().is_some_and(Trigger::is_done)
    }

    /// Items that found no room between the source and here.
    #[must_use]
    pub fn dropped(&self) -> u64 {
        self.source.as_ref().map_or(0, SourceHandle::dropped)
    }

    /// Passes a command to the gripper.
    ///
    /// # Errors
    /// Where the source takes none.
    pub fn command(&mut self, action: ClientCommand) -> Result<(), Refused> {
        self.source.as_mut().ok_or(Refused::NotLive)?.command(action)
    }
}

/// States that differ in kind; shares and times that only go on do not.
const fn kind(status: &SourceStatus) -> core::mem::Discriminant<SourceStatus> {
    core::mem::discriminant(status)
}

#[cfg(test)]
mod tests {
    use super::{Brought, Engine};
    use grip_scope::feed::{EventKind, EventMark, Feed, RowBlock};
    use grip_scope::trigger::{Found, TriggerMode, TriggerSource};
    use grip_scope::{Channel, Model, SourceStatus, Span, Trigger};

    #[test]
    fn only_what_is_new_is_reported() {
        let mut engine = Engine::new(Model::new(1 << 20), None);
        assert_eq!(engine.take_in(10), Brought::default());
        engine.model.mark(1.0, "here");
        assert_eq!(engine.take_in(10), Brought { changed: true, ..Brought::default() });
        assert_eq!(engine.take_in(10), Brought::default());
    }

    #[test]
    fn a_file_that_comes_in_is_worth_a_frame_while_there_is_more_of_it() {
        let mut engine = Engine::new(Model::new(1 << 20), None);
        for done in [0.1, 0.2] {
            engine.model.take(Feed::Status(SourceStatus::Loading { done }));
            assert!(engine.take_in(1).loading);
            assert!(!engine.take_in(1).loading);
        }
        engine.model.take(Feed::Status(SourceStatus::Live));
        engine.take_in(1);
        engine.model.mark(1.0, "here");
        assert!(!engine.take_in(1).loading);
    }

    #[test]
    fn what_the_trigger_found_waits_to_be_shown() {
        let mut engine = Engine::new(Model::new(1 << 20), None);
        engine.watch(Some(Trigger::new(
            TriggerSource::Event(EventKind::Marker),
            TriggerMode::Auto,
            0.0,
            0.0,
        )));
        assert!(!engine.take_in(1).urgent, "nothing was found");
        let columns = vec![(Channel::Stylus, vec![0.0])];
        let times_us = vec![3_000_000];
        engine.model.take(Feed::Rows(RowBlock { times_us, columns, ..RowBlock::default() }));
        engine.model.take(Feed::Event(EventMark::plain(2.0, EventKind::Marker, "x")));
        engine.model.take(Feed::Status(SourceStatus::Live));
        let brought = engine.take_in(1);
        assert!(brought.urgent, "{brought:?}");
        // A sweep that comes before the next frame does not hide it.
        engine.take_in(1);
        assert_eq!(engine.triggered(), Some(Found::Hit(Span::new(2.0, 2.0))));
        assert_eq!(engine.triggered(), None);
    }
}
