//! Everything that a user has changed since the start, and that is no data.

use crate::apply::Effect;
use crate::labels::Labelled;
use crate::layout::Layout;
use crate::plot::Scale;
use crate::strip::StripId;
use crate::time::{Following, TimeWindow};
use core::mem::Discriminant;
use grip_link::message::daemon::{GripState, Scene};
use grip_scope::{Model, SourceStatus, Span};

/// The command panel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CommandForm {
    /// Whether the lock is off.
    pub armed: bool,
    /// The force entered (N).
    pub force_n: f64,
    /// Whether the question before a release stands.
    pub asks_release: bool,
}

/// A sentence over the plots, until it is closed or replaced.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Message {
    /// The sentence.
    pub text: String,
    /// Whether something failed.
    pub is_error: bool,
}

/// How gripper and source were when a command was sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Standing {
    source: Discriminant<SourceStatus>,
    gripper: Option<(Scene, GripState, u16)>,
}

impl Standing {
    /// How they are now.
    #[must_use]
    pub fn now(model: &Model) -> Self {
        let gripper = model.info().state.map(|state| (state.scene, state.grip, state.fault.0));
        Self { source: core::mem::discriminant(model.status()), gripper }
    }
}

/// What a user has changed.
#[derive(Clone, Debug, Default)]
pub struct ViewState {
    /// What is remembered.
    pub layout: Layout,
    /// What part of the time is seen.
    pub window: TimeWindow,
    /// Cursors A and B (s).
    pub cursors: [Option<f64>; 2],
    /// Where the pointer is (s).
    pub hover_s: Option<f64>,
    /// Where it is in this frame (s).
    pub pointed_s: Option<f64>,
    /// Where the stretch that is being dragged over begins (s).
    pub select_s: Option<f64>,
    /// The event that was jumped to last (s).
    pub event_s: Option<f64>,
    /// Values that were chosen by hand.
    pub values: Vec<(StripId, Scale)>,
    /// Whether the keys are shown.
    pub help: bool,
    /// The slip at or before this time (s) is explained.
    pub explain: Option<f64>,
    /// The hint of the tour that is shown, from 0 on.
    pub tour: Option<usize>,
    /// Whether the trigger waits. It is not remembered: a window that is opened shows what comes.
    pub armed: bool,
    /// How often the trigger has found what it waits for.
    pub triggered: u64,
    /// The view stands at what an automatic trigger has found, until its next sweep: the user did not pause it.
    pub stands_at_hit: bool,
    /// Where the trigger has found something in a recording (s).
    pub hit_s: Option<f64>,
    /// The commands.
    pub command: CommandForm,
    /// Beginning of the names of exported files.
    pub stem: String,
    /// The recording that is open, with its label.
    pub recording: Option<Labelled>,
    /// The pointer is not looked at: for pictures.
    pub no_pointer: bool,
    /// What was done or failed last.
    pub message: Option<Message>,
    /// What was reported of a command, until gripper or source are otherwise.
    pub sent: Option<(Message, Standing)>,
    /// What is to be done after this frame.
    pub asked: Vec<Effect>,
}

impl ViewState {
    /// A fresh state with a layout.
    #[must_use]
    pub fn new(layout: Layout) -> Self {
        Self {
            window: TimeWindow::new(layout.seconds),
            layout,
            command: CommandForm { force_n: 5.0, ..CommandForm::default() },
            stem: "gripmon".to_owned(),
            ..Self::default()
        }
    }

    /// Whether the user holds the view where it is.
    #[must_use]
    pub fn is_paused(&self) -> bool {
        self.window.following() == Following::Held && !self.stands_at_hit
    }

    /// Begins the tour, where it was never shown; from then on it was.
    pub fn tour_once(&mut self) {
        if !core::mem::replace(&mut self.layout.toured, true) {
            self.tour = Some(0);
        }
    }

    /// Whether a dialog lies over the plots.
    #[must_use]
    pub const fn has_dialog(&self) -> bool {
        self.help || self.explain.is_some() || self.command.asks_release
    }

    /// The stretch between both cursors, where there are both.
    #[must_use]
    pub fn between(&self) -> Option<Span> {
        let [Some(a), Some(b)] = self.cursors else { return None };
        Some(Span::new(a, b))
    }

    /// The values that were chosen by hand for a plot.
    #[must_use]
    pub fn chosen(&self, strip: StripId) -> Option<Scale> {
        self.values.iter().find(|(id, _)| *id == strip).map(|(_, scale)| *scale)
    }

    /// Reports what was done.
    pub fn report(&mut self, text: impl Into<String>) {
        self.message = Some(Message { text: text.into(), is_error: false });
    }

    /// Reports what was sent, until gripper or source are otherwise.
    pub fn report_sent(&mut self, text: impl Into<String>, model: &Model) {
        self.report(text);
        self.sent = self.message.clone().map(|message| (message, Standing::now(model)));
    }

    /// Takes away what was reported of a command where gripper or source are otherwise since.
    pub fn forget_sent(&mut self, model: &Model) {
        let now = Standing::now(model);
        if let Some((message, _)) = self.sent.take_if(|(_, then)| *then != now)
            && self.message.as_ref() == Some(&message)
        {
            self.message = None;
        }
    }

    /// Reports what failed.
    pub fn complain(&mut self, text: impl Into<String>) {
        self.message = Some(Message { text: text.into(), is_error: true });
    }
}

#[cfg(test)]
mod tests {
    use super::ViewState;
    use crate::layout::Layout;
    use grip_scope::feed::Feed;
    use grip_scope::{Model, SourceStatus};

    #[test]
    fn what_was_sent_is_reported_until_the_status_is_another() {
        let mut model = Model::new(1 << 20);
        model.take(Feed::Status(SourceStatus::Live));
        let mut state = ViewState::new(Layout::default());
        state.report_sent("Sent: stop.", &model);
        state.forget_sent(&model);
        assert!(state.message.is_some());
        model.take(Feed::Status(SourceStatus::Stalled { for_s: 1.0 }));
        state.forget_sent(&model);
        assert_eq!(state.message, None);
        state.report_sent("Sent: stop.", &model);
        state.complain("Something else.");
        model.take(Feed::Status(SourceStatus::Live));
        state.forget_sent(&model);
        assert!(state.message.is_some());
    }
}
