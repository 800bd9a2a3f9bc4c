//! The model and the trigger that watches it: what a source fills and the window looks at.

use core::mem::Discriminant;
use grip_scope::source::Orders;
use grip_scope::trigger::Found;
use grip_scope::{Model, Refused, SourceStatus, Trigger};
use slip_core::ClientCommand;

/// Data, and the way to where they come from.
#[derive(Debug)]
pub struct Engine {
    /// The data.
    pub model: Model,
    /// The way of commands, where the data have a source.
    pub orders: Option<Orders>,
    trigger: Option<Trigger>,
    found: Option<Found>,
    seen: (u64, Discriminant<SourceStatus>),
}

/// What is new since the last look.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Brought {
    /// Something that can be seen is new.
    pub changed: bool,
    /// It is worth painting a view that stands still: the source's state is another, or the trigger has found something.
    pub urgent: bool,
    /// A file is on its way in: a view that stands still is worth painting now and then, for what is there and how far it is.
    pub loading: bool,
}

impl Engine {
    /// A model with the way to its source, or one that is filled by hand.
    #[must_use]
    pub const fn new(model: Model, orders: Option<Orders>) -> Self {
        let seen = (model.revision(), core::mem::discriminant(model.status()));
        Self { model, orders, trigger: None, found: None, seen }
    }

    /// Looks at what the source has brought.
    pub fn look(&mut self) -> Brought {
        let found = self.trigger.as_mut().and_then(|trigger| trigger.poll(&self.model));
        let triggered = matches!(found, Some(Found::Hit(_)));
        if triggered || !matches!(self.found, Some(Found::Hit(_))) {
            self.found = found.or(self.found);
        }
        // States that differ in kind; shares and times that only go on do not.
        let now = (self.model.revision(), core::mem::discriminant(self.model.status()));
        let (revision, kind) = core::mem::replace(&mut self.seen, now);
        let changed = now.0 != revision;
        let loading = changed && matches!(self.model.status(), SourceStatus::Loading { .. });
        Brought { changed, urgent: triggered || now.1 != kind, loading }
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

    /// Passes a command to the gripper.
    ///
    /// # Errors
    /// Where the source takes none.
    pub fn command(&self, action: ClientCommand) -> Result<(), Refused> {
        self.orders.as_ref().ok_or(Refused::NotLive)?.send(action)
    }
}

#[cfg(test)]
mod tests {
    use super::{Brought, Engine};
    use grip_scope::feed::{EventKind, EventMark, Feed, RowBlock};
    use grip_scope::trigger::{Found, TriggerMode, TriggerSettings};
    use grip_scope::{Channel, Model, SourceStatus, Span, Trigger};

    #[test]
    fn only_what_is_new_is_reported() {
        let mut engine = Engine::new(Model::new(1 << 20), None);
        assert_eq!(engine.look(), Brought::default());
        engine.model.mark(1.0, "here");
        assert_eq!(engine.look(), Brought { changed: true, ..Brought::default() });
        assert_eq!(engine.look(), Brought::default());
        for done in [0.1, 0.2] {
            engine.model.take(Feed::Status(SourceStatus::Loading { done }));
            assert!(engine.look().loading);
            assert!(!engine.look().loading);
        }
    }

    #[test]
    fn what_the_trigger_found_waits_to_be_shown() {
        let mut engine = Engine::new(Model::new(1 << 20), None);
        engine.watch(Some(Trigger::new(TriggerSettings {
            event: EventKind::Marker,
            mode: TriggerMode::Auto,
            before_s: 0.0,
            window_s: 0.0,
            ..TriggerSettings::default()
        })));
        assert!(!engine.look().urgent, "nothing was found");
        let columns = vec![(Channel::Stylus, vec![0.0])];
        let times_us = vec![3_000_000];
        engine.model.take(Feed::Rows(RowBlock { times_us, columns, ..RowBlock::default() }));
        engine.model.take(Feed::Event(EventMark::plain(2.0, EventKind::Marker, "x")));
        assert!(engine.look().urgent);
        // A sweep that comes before the next frame does not hide it.
        engine.look();
        assert_eq!(engine.triggered(), Some(Found::Hit(Span::new(2.0, 2.0))));
        assert_eq!(engine.triggered(), None);
    }
}
