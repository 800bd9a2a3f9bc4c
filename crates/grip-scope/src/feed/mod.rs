//! What a source reports, one item after the other: the only thing that passes from its thread to the model.

mod event;
mod state;
mod status;
mod study;

pub use event::{EventKind, EventMark};
pub use slip_core::PipelineState;
pub use state::{
    DB_BASE, DB_STEP, DerivedBlock, DerivedValue, ObserverSettings, SpectrumColumn, Turn, esc_flags,
};
pub use status::{DaemonInfo, SourceStatus};
pub use study::{LearningCurve, Study, StudyNet, StudyResult};

use crate::channel::Channel;
use grip_link::device::Truth;
use grip_link::message::{
    Unit,
    daemon::{Gripper, Health},
};
use std::path::PathBuf;

/// One item. All times are device times (s) as the source has them; the model puts them on its axis.
#[derive(Clone, Debug, PartialEq)]
pub enum Feed {
    /// How the source is; reported on every change.
    Status(SourceStatus),
    /// A conversation with a daemon begins.
    Welcome(DaemonInfo),
    /// What comes next is another run of the source: nothing joins it to what came before.
    Restart,
    /// Samples.
    Rows(RowBlock),
    /// Samples from somewhere later in a recording that is still being loaded, for a first picture.
    Preview(RowBlock),
    /// What the pipeline thinks.
    State(PipelineState),
    /// What a simulator knows of the object, at the time of the next state.
    Truth(Truth),
    /// Whose settings the scope's own observer has from now on.
    Observes(ObserverSettings),
    /// What the scope's own observer makes of the samples.
    Derived(Box<DerivedBlock>),
    /// Something happened.
    Event(EventMark),
    /// Figures of the daemon.
    Health(Box<Health>),
    /// What the stylus of a recording is.
    Stylus(StylusInfo),
    /// Which gripper it is.
    Gripper(Gripper),
    /// A line for people.
    Notice(String),
    /// The report of a study.
    Study(Box<Study>),
    /// Where a recording begins and ends (device time, s), before all of it is loaded; what file it is.
    Extent {
        /// Its first sample (s).
        from_s: f64,
        /// Its last one (s).
        to_s: f64,
        /// The file.
        file: PathBuf,
    },
}

/// What the channel of the stylus holds.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StylusInfo {
    /// Metres; none for a vibration in a unit of its own.
    pub unit: Unit,
    /// The axes of the sensor where it has several; the first one is shown.
    pub axes: Vec<String>,
}

impl StylusInfo {
    /// One axis in this unit.
    #[must_use]
    pub const fn one(unit: Unit) -> Self {
        Self { unit, axes: Vec::new() }
    }
}

/// Samples in order of time, column by column.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RowBlock {
    /// Times (us of the device), one for each row; a row that is not later than the one before begins a new run.
    pub times_us: Vec<u64>,
    /// Values of each channel, one for each row; NaN: no reading.
    pub columns: Vec<(Channel, Vec<f32>)>,
    /// Whether rows are missing before the first one.
    pub broken: bool,
    /// Rows that are missing there, where that is known.
    pub lost: u32,
    /// The array's frames, where there is one.
    pub taxels: Option<TaxelBlock>,
}

/// Frames of the taxel array, one for each row.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TaxelBlock {
    /// Taxels of a frame.
    pub count: usize,
    /// Readings, frame by frame.
    pub values: Vec<f32>,
}
