//! What a user asks for: the only thing that views give back.

use crate::form::TriggerForm;
use crate::layout::Panel;
use crate::plot::Scale;
use crate::strip::StripId;
use grip_scope::Span;

/// One of the two cursors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cursor {
    /// The first.
    A,
    /// The second.
    B,
}

/// A command to the gripper, as its panel gives it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Order {
    /// Hold with at least this force (N).
    AtLeast(f64),
    /// Let go.
    Release,
    /// Close again.
    Grasp,
    /// Stop in software.
    Stop,
    /// Clear the fault that is latched.
    ClearFault,
}

/// What is wanted of the label of a recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Labelling {
    /// It begins to slip at cursor A.
    Onset,
    /// It slips all the time.
    Steady,
    /// It never slips.
    Rest,
    /// Take the label away.
    Remove,
}

/// A request of the user. [`crate::apply`] is the one place that carries them out.
#[derive(Clone, Debug, PartialEq)]
pub enum Action {
    /// Hold the view where it is, or follow the newest data.
    TogglePause,
    /// Follow the newest data.
    Follow,
    /// Show all data.
    ShowAll,
    /// Move the view by this share of its length; later for positive ones.
    PanShare(f64),
    /// Move the view (s).
    Pan(f64),
    /// Show so many times as much, around the pointer.
    ZoomKey(f64),
    /// Show so many times as much, this time unmoved.
    Zoom {
        /// The time that stays (s).
        at_s: f64,
        /// Times as much.
        factor: f64,
    },
    /// Show this.
    Show(Span),
    /// Show so many seconds.
    Length(f64),
    /// Show the first event after what was looked at.
    NextEvent,
    /// Show the last event before it.
    PreviousEvent,
    /// Show this time.
    JumpTo(f64),
    /// The pointer is at this time of the plots, or away.
    Hover(Option<f64>),
    /// A stretch is being dragged over, from here.
    Select(Option<f64>),
    /// Put a cursor where the pointer is, else in the middle.
    CursorHere(Cursor),
    /// Put a cursor at a time (s).
    PlaceCursor(Cursor, f64),
    /// Take both away.
    ClearCursors,
    /// Show what lies between them.
    ZoomToCursors,
    /// Put a marker where the pointer is, else at the newest sample.
    MarkHere,
    /// Arm the trigger, or disarm it.
    ToggleTrigger,
    /// Other settings of the trigger.
    SetTrigger(TriggerForm),
    /// Scale the values of every plot to what is seen.
    AutoValues,
    /// Show these values of a plot; `None`: what is seen decides.
    Values(StripId, Option<Scale>),
    /// Show a plot, or hide it.
    ToggleStrip(StripId),
    /// Make a plot higher, relative to the others.
    Height(StripId, f32),
    /// Move a plot up by so many places.
    MoveStrip(StripId, i8),
    /// Show a panel, or close it.
    TogglePanel(Panel),
    /// The panel is so wide now (points).
    PanelWidth(f32),
    /// Light or dark.
    ToggleTheme,
    /// Show the keys, or close them.
    ToggleHelp,
    /// Explain the slip that was looked at last, or close the explanation.
    ToggleExplain,
    /// Show this hint of the tour, from 0 on; the tour ends without one, or behind the last.
    Tour(Option<usize>),
    /// Close what lies over the plots.
    Dismiss,
    /// Another beginning of the names of exported files.
    ExportStem(String),
    /// A picture of the window.
    ExportPicture,
    /// The samples that are seen, as CSV.
    ExportCsv,
    /// What is seen as a recording.
    ExportMcap,
    /// What is seen as a page.
    ExportReport,
    /// Label the recording that is open.
    Label(Labelling),
    /// Take the commands' lock off, or put it on again.
    Arm(bool),
    /// The force that is being entered (N).
    ForceEntry(f64),
    /// Ask whether the gripper shall really let go; `false` takes it back.
    AskRelease(bool),
    /// Send a command.
    Send(Order),
}
