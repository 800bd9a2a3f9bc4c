//! Model of everything a scope shows, from what sources report: bounded history of each channel, events, spectra, health.
//!
//! Nothing here knows windows, threads or clocks. Memory is bounded: the oldest thousand samples of all channels go first.

mod axis;
mod crossing;
mod events;
#[cfg(test)]
mod gap_tests;
mod gaps;
mod health;
mod intake;
mod node;
mod series;
mod store;
#[cfg(test)]
mod tests;
mod timeline;

pub(crate) use axis::{Axis, Placed};
pub use events::{Doing, Events};
pub use health::HealthBoard;
pub use series::{Bucket, Series, Stats};
pub(crate) use store::Samples;
pub use timeline::{Stretch, TaxelFrame, Timed, Timeline};

use crate::channel::Channel;
use crate::feed::{
    DaemonInfo, EventKind, EventMark, ObserverSettings, SourceStatus, SpectrumColumn, Study,
    StylusInfo, Turn,
};
use crate::span::Span;
use gaps::Gaps;
use grip_link::device::Truth;
use grip_link::message::{Unit, daemon::Gripper};
use slip_core::PipelineState;
use std::collections::{BTreeMap, VecDeque};
use std::path::PathBuf;

/// Lines for people kept; the oldest go first.
const MOST_NOTICES: usize = 200;

/// Who and what is being watched.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Info {
    /// The daemon.
    pub daemon: Option<DaemonInfo>,
    /// The gripper.
    pub gripper: Option<Gripper>,
    /// What the stylus is, once that is known.
    pub stylus: Option<StylusInfo>,
    /// The last state of the pipeline.
    pub state: Option<PipelineState>,
    /// Whose settings the scope's own observer has.
    pub observer: Option<ObserverSettings>,
    /// The recording, and where it begins and ends once it is loaded.
    pub recording: Option<(PathBuf, Span)>,
}

impl Info {
    /// Wanted time between false alarms (s): evidence of so much is a slip.
    #[must_use]
    pub fn interval_s(&self) -> f32 {
        self.observer.unwrap_or_default().interval_s()
    }

    /// Ends of an axis of evidence (s): from a fifth of a block of samples, which is less than rest, to ten intervals.
    #[must_use]
    pub fn evidence_axis(&self) -> [f64; 2] {
        [1e-4, 10.0 * f64::from(self.interval_s())]
    }

    /// Unit of a channel of this source: E_sc has that of the reading that is shown, a stylus metres, a vibration none.
    #[must_use]
    pub fn unit(&self, channel: Channel) -> &'static str {
        match (channel, &self.stylus) {
            (Channel::Esc | Channel::OwnEsc | Channel::EscLow | Channel::EscHigh, _) => {
                self.state.map_or("W", |state| state.esc_kind.unit())
            }
            (Channel::Stylus | Channel::SecondStylus, Some(stylus))
                if stylus.unit == Unit::Metre =>
            {
                "m"
            }
            _ => channel.unit(),
        }
    }

    /// What a channel of this source is called: no stylus where there is none.
    #[must_use]
    pub fn name(&self, channel: Channel) -> &'static str {
        match channel {
            Channel::Stylus if self.vibrates() => "vibration",
            Channel::SecondStylus if self.vibrates() => "second vibration",
            _ => channel.name(),
        }
    }

    /// What stands over the curve of the stylus; of several axes which one it is.
    #[must_use]
    pub fn stylus_title(&self) -> String {
        let name = if self.vibrates() { "Vibration, own units" } else { "Stylus" };
        match self.stylus.as_ref().map(|stylus| stylus.axes.as_slice()) {
            Some([first, rest @ ..]) if !rest.is_empty() => {
                format!("{name}: {first} of {} axes", rest.len() + 1)
            }
            _ => name.to_owned(),
        }
    }

    fn vibrates(&self) -> bool {
        self.stylus.as_ref().is_some_and(|stylus| stylus.unit != Unit::Metre)
    }
}

/// Everything that is known.
#[derive(Clone, Debug, Default)]
pub struct Model {
    limit_bytes: usize,
    series: BTreeMap<Channel, Series>,
    events: Events,
    turns: Timeline<Turn>,
    spectrogram: Timeline<SpectrumColumn>,
    taxels: Timeline<TaxelFrame>,
    health: HealthBoard,
    status: SourceStatus,
    info: Info,
    notices: VecDeque<String>,
    study: Option<Study>,
    axis: Axis,
    /// The next rows do not join the last ones.
    restarted: bool,
    /// The next state belongs to another run than the last: nothing that has changed is reported.
    afresh: bool,
    /// What a simulator knows at the time of the next state.
    truth: Option<Truth>,
    /// Where curves that are no rows do not go on.
    gaps: Gaps,
    revision: u64,
}

impl Model {
    /// A model that takes at most `memory_bytes` for its history (some MB more for what is being worked on).
    #[must_use]
    pub fn new(memory_bytes: usize) -> Self {
        Self { limit_bytes: memory_bytes, ..Self::default() }
    }

    /// From the first to the last sample of all channels; `None` while there is none.
    #[must_use]
    pub fn span(&self) -> Option<Span> {
        let spans = self.series.values().filter_map(Series::span);
        let known = spans.reduce(|a, b| a.union(b));
        match (known, &self.info.recording) {
            (Some(known), Some((_, all))) if self.axis.is_plain() => Some(known.union(*all)),
            (known, _) => known,
        }
    }

    /// The channels that have data, in the order of [`Channel`].
    pub fn channels(&self) -> impl Iterator<Item = Channel> {
        self.series.keys().copied()
    }

    /// The history of a channel.
    #[must_use]
    pub fn series(&self, channel: Channel) -> Option<&Series> {
        self.series.get(&channel)
    }

    /// What happened.
    #[must_use]
    pub const fn events(&self) -> &Events {
        &self.events
    }

    /// Peaks and valleys in the span, where they are at most `most`; otherwise none.
    #[must_use]
    pub fn turns(&self, span: Span, most: usize) -> Vec<Turn> {
        let found = self.turns.within(span);
        if found.len() > most { Vec::new() } else { found.copied().collect() }
    }

    /// The spectra of the stylus.
    #[must_use]
    pub const fn spectrogram(&self) -> &Timeline<SpectrumColumn> {
        &self.spectrogram
    }

    /// The health of the link.
    #[must_use]
    pub const fn health(&self) -> &HealthBoard {
        &self.health
    }

    /// How the source is.
    #[must_use]
    pub const fn status(&self) -> &SourceStatus {
        &self.status
    }

    /// Who and what is being watched.
    #[must_use]
    pub const fn info(&self) -> &Info {
        &self.info
    }

    /// Lines for people, in order.
    #[must_use]
    pub fn notices(&self) -> impl DoubleEndedIterator<Item = &str> + ExactSizeIterator {
        self.notices.iter().map(String::as_str)
    }

    /// The report of a study.
    #[must_use]
    pub const fn study(&self) -> Option<&Study> {
        self.study.as_ref()
    }

    /// The last frame of the pressure array at or before `t_s`.
    #[must_use]
    pub fn taxels(&self, t_s: f64) -> Option<&TaxelFrame> {
        self.taxels.at(t_s)
    }

    /// The frames of the pressure array in the span, its ends included.
    pub fn taxel_frames(&self, span: Span) -> impl Iterator<Item = &TaxelFrame> {
        self.taxels.within(span)
    }

    /// Changes where something that can be seen has changed.
    #[must_use]
    pub const fn revision(&self) -> u64 {
        self.revision
    }

    /// The end of the axis (s): where live data come.
    #[must_use]
    pub const fn end_s(&self) -> f64 {
        self.axis.end_s()
    }

    /// Whether times on the axis are those of the device; they are not after it has restarted.
    #[must_use]
    pub fn is_device_time(&self) -> bool {
        self.axis.is_plain()
    }

    /// Sets a mark of the user.
    pub fn mark(&mut self, t_s: f64, text: impl Into<String>) {
        if t_s.is_finite() {
            self.events.push(EventMark::plain(t_s, EventKind::Marker, text));
            self.revision += 1;
        }
    }

    /// Bytes of the whole history.
    #[must_use]
    pub fn bytes(&self) -> usize {
        let series: usize = self.series.values().map(Series::bytes).sum();
        let rest = self.events.bytes() + self.taxels.bytes() + self.turns.bytes();
        series + rest + self.spectrogram.bytes()
    }

    /// Drops the oldest samples until the history fits its memory.
    fn shed(&mut self) {
        let mut bytes = self.bytes();
        while bytes > self.limit_bytes {
            let aged = self.series.values_mut();
            let aged = aged.filter_map(|series| Some((series.store.oldest_s()?, series)));
            let Some((_, oldest)) = aged.min_by(|a, b| a.0.total_cmp(&b.0)) else { return };
            let before = oldest.bytes();
            oldest.store.drop_oldest();
            bytes -= before.saturating_sub(oldest.bytes());
        }
    }
}

/// What a piece of memory takes with what an allocator keeps beside it.
const fn allocated(bytes: usize) -> usize {
    if bytes == 0 { 0 } else { bytes + 16 }
}
