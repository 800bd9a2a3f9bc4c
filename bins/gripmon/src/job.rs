//! A place to go to, and what the window has to do for it in a frame.

use crate::state::ViewState;
use crate::view_file::ViewFile;
use core::time::Duration;
use grip_scope::{Model, SourceStatus};
use std::path::PathBuf;

/// Frames between the last change and a picture: sizes of panels need one to settle.
const SETTLE: u64 = 4;
/// Time between two looks for a picture, which does not wait for data.
const LOOK: Duration = Duration::from_millis(50);

/// A place to go to, and perhaps a picture to make there.
#[derive(Clone, Debug)]
pub struct Job {
    /// The place.
    pub view: ViewFile,
    /// The picture.
    pub picture: Option<PathBuf>,
    /// The frame at which the place was reached.
    placed: Option<u64>,
}

/// What is to be done.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Step {
    /// Look again after this time; new data may bring it earlier.
    Wait(Duration),
    /// The place is reached, and no picture wanted.
    Done,
    /// Make the picture.
    Picture(PathBuf),
    /// It is not reached: a sentence.
    Failed(String),
}

impl Job {
    /// A job that has not begun.
    #[must_use]
    pub const fn new(view: ViewFile, picture: Option<PathBuf>) -> Self {
        Self { view, picture, placed: None }
    }

    /// Goes there where the data have come so far; `frames` were painted and `time_s` has passed since the window was opened. A view that the
    /// user holds is left where it is.
    pub fn step(&mut self, state: &mut ViewState, model: &Model, frames: u64, time_s: f64) -> Step {
        let may_move = self.picture.is_some() || !state.is_paused();
        if self.placed.is_none() && may_move && self.view.place(state, model) {
            self.placed = Some(frames);
        }
        match (self.placed, &self.picture) {
            (Some(_), None) => Step::Done,
            (Some(placed), Some(path)) if frames >= placed.saturating_add(SETTLE) => {
                Step::Picture(path.clone())
            }
            (Some(_), Some(_)) => Step::Wait(LOOK),
            (None, picture) => self.missed(model.status(), time_s, picture.is_some()),
        }
    }

    fn missed(&self, status: &SourceStatus, time_s: f64, pictured: bool) -> Step {
        let patience_s = self.view.look.patience_s;
        let what = if pictured { "no picture" } else { "the view is not there" };
        if let SourceStatus::Failed { sentence } = status {
            return Step::Failed(format!("{what}: {sentence}"));
        }
        if time_s >= patience_s {
            let sentence = "what the view asks for did not come within";
            return Step::Failed(format!("{what}: {sentence} {patience_s} s"));
        }
        let rest = Duration::try_from_secs_f64(patience_s - time_s).unwrap_or(Duration::MAX);
        Step::Wait(if pictured { LOOK } else { rest })
    }
}

#[cfg(test)]
mod tests {
    use super::{Job, Step};
    use crate::layout::Layout;
    use crate::state::ViewState;
    use crate::view_file::ViewFile;
    use core::time::Duration;
    use grip_scope::feed::{EventKind, EventMark, Feed, RowBlock};
    use grip_scope::{Channel, Model, SourceStatus};

    fn parts() -> (Job, ViewState, Model) {
        let mut view = ViewFile::default();
        view.look.event = Some(EventKind::Gross);
        view.look.length_s = Some(0.3);
        view.look.patience_s = 10.0;
        let mut model = Model::new(1 << 20);
        let times_us: Vec<u64> = (0..1000).map(|i| i * 1000).collect();
        let columns = vec![(Channel::Stylus, vec![0.0; 1000])];
        model.take(Feed::Rows(RowBlock { times_us, columns, ..RowBlock::default() }));
        model.take(Feed::Status(SourceStatus::Live));
        (Job::new(view, None), ViewState::new(Layout::default()), model)
    }

    #[test]
    fn an_event_that_never_comes_is_waited_for_without_frames_and_then_reported() {
        let (mut job, mut state, model) = parts();
        let step = job.step(&mut state, &model, 1, 4.0);
        assert_eq!(step, Step::Wait(Duration::from_secs(6)));
        let step = job.step(&mut state, &model, 2, 10.0);
        let reported = "the view is not there: what the view asks for did not come within 10 s";
        assert_eq!(step, Step::Failed(reported.to_owned()));
    }

    #[test]
    fn a_view_that_the_user_holds_is_left_alone() {
        let (mut job, mut state, mut model) = parts();
        model.take(Feed::Event(EventMark::plain(0.5, EventKind::Gross, "x")));
        state.window.hold(model.span());
        let held = state.window;
        assert!(matches!(job.step(&mut state, &model, 1, 1.0), Step::Wait(_)));
        assert_eq!(state.window, held);
        state.window.follow();
        assert_eq!(job.step(&mut state, &model, 2, 2.0), Step::Done);
        assert!((state.window.visible(model.span()).from_s - 0.4).abs() < 1e-9);
    }
}
