//! The model and the trigger that watches it: what a source fills and the window looks at, and when that is worth a frame.
//!
//! Where nobody looks (a view that stands still, a hidden window) data go on being taken in, and nothing is painted; while a file is loaded a
//! view that stands still is painted a few times a second, as how far it is can be seen there.

use core::mem::Discriminant;
use core::time::Duration;
use grip_scope::source::Orders;
use grip_scope::trigger::{Found, TriggerSettings};
use grip_scope::{Model, Refused, SourceStatus, Trigger};
use slip_core::ClientCommand;

/// Time between two frames of live data (30 a second).
pub const FRAME: Duration = Duration::from_millis(33);
/// The same of a view that stands still while a file is loaded (5 a second).
pub const PROGRESS: Duration = Duration::from_millis(200);

/// Data, and the way to where they come from.
#[derive(Debug)]
pub struct Engine {
    /// The data.
    pub model: Model,
    /// The way of commands, where the data have a source.
    pub orders: Option<Orders>,
    /// The view stands still.
    pub paused: bool,
    /// Nobody can see the window.
    pub hidden: bool,
    trigger: Option<Trigger>,
    found: Option<Found>,
    seen: (u64, Discriminant<SourceStatus>),
}

impl Engine {
    /// A model with the way to its source, or one that is filled by hand.
    #[must_use]
    pub const fn new(model: Model, orders: Option<Orders>) -> Self {
        let seen = (model.revision(), core::mem::discriminant(model.status()));
        Self { model, orders, paused: false, hidden: false, trigger: None, found: None, seen }
    }

    /// Looks at what the source has brought: how soon it is worth a frame; `None` where it is not.
    pub fn look(&mut self) -> Option<Duration> {
        let found = self.trigger.as_mut().and_then(|trigger| trigger.poll(&self.model));
        let triggered = matches!(found, Some(Found::Hit(_)));
        if triggered || !matches!(self.found, Some(Found::Hit(_))) {
            self.found = found.or(self.found);
        }
        // States that differ in kind; shares and times that only go on do not.
        let now = (self.model.revision(), core::mem::discriminant(self.model.status()));
        let (revision, kind) = core::mem::replace(&mut self.seen, now);
        let changed = now.0 != revision;
        // A view that stands still is painted where the source's state is another, or the trigger has found something.
        let urgent = triggered || now.1 != kind;
        match self.model.status() {
            _ if self.hidden => None,
            _ if urgent || (changed && !self.paused) => Some(FRAME),
            SourceStatus::Loading { .. } if changed => Some(PROGRESS),
            _ => None,
        }
    }

    /// What the trigger has found since the last call: the last hit, else the last sweep.
    pub const fn triggered(&mut self) -> Option<Found> {
        self.found.take()
    }

    /// Arms a trigger, or takes it away; one that has these settings already goes on.
    pub fn watch(&mut self, settings: Option<TriggerSettings>) {
        if self.trigger.map(|trigger| trigger.settings) != settings {
            (self.trigger, self.found) = (settings.map(Trigger::new), None);
        }
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
    use super::{Engine, FRAME, PROGRESS};
    use grip_scope::feed::{EventKind, EventMark, Feed, RowBlock};
    use grip_scope::trigger::{Found, TriggerMode, TriggerSettings};
    use grip_scope::{Channel, Model, SourceStatus, Span};

    #[test]
    fn only_what_is_new_is_worth_a_frame_and_the_progress_of_a_file_a_few_in_a_second() {
        let mut engine = Engine::new(Model::new(1 << 20), None);
        assert_eq!(engine.look(), None);
        engine.model.mark(1.0, "here");
        assert_eq!((engine.look(), engine.look()), (Some(FRAME), None));
        engine.paused = true;
        engine.model.mark(1.0, "there");
        assert_eq!(engine.look(), None);
        // The first state is another one than before.
        for (done, wait) in [(0.1, FRAME), (0.2, PROGRESS), (0.21, PROGRESS)] {
            engine.model.take(Feed::Status(SourceStatus::Loading { done }));
            assert_eq!((engine.look(), engine.look()), (Some(wait), None));
        }
        engine.hidden = true;
        engine.model.take(Feed::Status(SourceStatus::Live));
        assert_eq!(engine.look(), None);
    }

    #[test]
    fn what_the_trigger_found_waits_to_be_shown() {
        let mut engine = Engine::new(Model::new(1 << 20), None);
        engine.watch(Some(TriggerSettings {
            event: EventKind::Marker,
            mode: TriggerMode::Auto,
            before_s: 0.0,
            window_s: 0.0,
            ..TriggerSettings::default()
        }));
        engine.paused = true;
        assert_eq!(engine.look(), None, "nothing was found");
        let columns = vec![(Channel::Stylus, vec![0.0])];
        let times_us = vec![3_000_000];
        engine.model.take(Feed::Rows(RowBlock { times_us, columns, ..RowBlock::default() }));
        engine.model.take(Feed::Event(EventMark::plain(2.0, EventKind::Marker, "x")));
        assert_eq!(engine.look(), Some(FRAME));
        // A sweep that comes before the next frame does not hide it.
        engine.look();
        assert_eq!(engine.triggered(), Some(Found::Hit(Span::new(2.0, 2.0))));
        assert_eq!(engine.triggered(), None);
    }
}
