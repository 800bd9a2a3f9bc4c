//! The model in, the span that a person wanted to stop at out.

use crate::model::{Model, Series};
use crate::{channel::Channel, feed::EventKind, span::Span};

/// What is waited for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TriggerSource {
    /// A channel passes a level.
    Edge {
        /// The channel.
        channel: Channel,
        /// The level, in its unit.
        level: f32,
        /// Whether upwards; otherwise downwards.
        rising: bool,
    },
    /// A channel is beyond a level, however it came there.
    Level {
        /// The channel.
        channel: Channel,
        /// The level, in its unit.
        level: f32,
        /// Whether above it; otherwise below.
        above: bool,
    },
    /// Something happens.
    Event(EventKind),
}

/// How often it shows what it found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TriggerMode {
    /// Once, until it is armed again.
    Single,
    /// Every time.
    #[default]
    Normal,
    /// Every time; and the newest data where nothing was found for a while.
    Auto,
}

/// What a look brought.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Found {
    /// What was waited for, with what is shown around it.
    Hit(Span),
    /// The newest data, where nothing was found for a while ([`TriggerMode::Auto`]).
    Sweep(Span),
}

impl Found {
    /// What is to be shown.
    #[must_use]
    pub const fn span(self) -> Span {
        match self {
            Self::Hit(span) | Self::Sweep(span) => span,
        }
    }
}

/// A trigger as oscilloscopes have one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trigger {
    /// What is waited for.
    pub source: TriggerSource,
    /// How often.
    pub mode: TriggerMode,
    /// How much is shown before it (s).
    pub pre_s: f64,
    /// How much is shown at all (s).
    pub window_s: f64,
    /// Up to where it has looked (s): at the end of the axis for events, at the newest sample of its channel else.
    looked_s: Option<f64>,
    /// How many events had come when it looked last.
    looked_at: u64,
    /// Where it was found, until all of its window is there.
    found_s: Option<f64>,
    shown_s: Option<f64>,
    done: bool,
}

impl Trigger {
    /// A trigger that looks from now on.
    #[must_use]
    pub const fn new(source: TriggerSource, mode: TriggerMode, pre_s: f64, window_s: f64) -> Self {
        let (looked_s, found_s, shown_s) = (None, None, None);
        let (looked_at, done) = (0, false);
        Self { source, mode, pre_s, window_s, looked_s, looked_at, found_s, shown_s, done }
    }

    /// Looks again, from now on.
    pub const fn arm(&mut self) {
        *self = Self::new(self.source, self.mode, self.pre_s, self.window_s);
    }

    /// Whether a single trigger has shown what it found.
    #[must_use]
    pub const fn is_done(&self) -> bool {
        self.done
    }

    /// Where it was found last (s).
    #[must_use]
    pub const fn at_s(&self) -> Option<f64> {
        match self.found_s {
            Some(at_s) => Some(at_s),
            None => self.shown_s,
        }
    }

    /// The first place after `from_s` among what is there already (s).
    #[must_use]
    pub fn first_after(&self, model: &Model, from_s: f64) -> Option<f64> {
        self.find(model, from_s, self.newest_s(model))
    }

    /// Where to look on behind a place that was found (s): a level goes on behind what is shown around it, else each window would be
    /// followed by one that begins a sample later.
    #[must_use]
    pub fn behind(&self, at_s: f64) -> f64 {
        match self.source {
            TriggerSource::Level { .. } => self.around(at_s).to_s,
            TriggerSource::Edge { .. } | TriggerSource::Event(_) => at_s,
        }
    }

    /// What is shown around a place (s).
    #[must_use]
    pub fn around(&self, at_s: f64) -> Span {
        Span::new(at_s - self.pre_s, at_s - self.pre_s + self.window_s)
    }

    /// Looks at what is new: what to show, once all of it is there.
    pub fn poll(&mut self, model: &Model) -> Option<Found> {
        let end_s = model.end_s();
        let newest_s = self.newest_s(model);
        if self.looked_s.is_none() {
            self.looked_at = model.events().arrived();
        }
        let from_s = *self.looked_s.get_or_insert(newest_s);
        if self.done {
            return None;
        }
        if self.found_s.is_none() {
            self.found_s = match self.source {
                TriggerSource::Event(kind) => self.next_arrival(model, kind),
                TriggerSource::Edge { .. } | TriggerSource::Level { .. } => {
                    // What comes within the window that was shown last belongs to it.
                    let free_s =
                        self.shown_s.map_or(from_s, |at_s| at_s + self.window_s - self.pre_s);
                    self.find(model, from_s.max(free_s), newest_s)
                }
            };
            self.looked_s = Some(newest_s);
        }
        let behind_s = self.window_s - self.pre_s;
        match self.found_s {
            Some(at_s) if end_s >= at_s + behind_s => {
                self.found_s = None;
                self.shown_s = Some(at_s);
                self.done = self.mode == TriggerMode::Single;
                Some(Found::Hit(self.around(at_s)))
            }
            None if self.mode == TriggerMode::Auto => {
                let idle = self.shown_s.is_none_or(|at_s| end_s > at_s + 2.0 * self.window_s);
                idle.then(|| Found::Sweep(Span::new(end_s - self.window_s, end_s)))
            }
            _ => None,
        }
    }

    /// The next event that has come since the last look. Its time may be before that: a gap is reported when it is over, a mark may be set anywhere.
    fn next_arrival(&mut self, model: &Model, kind: EventKind) -> Option<f64> {
        let shown = self.shown_s.map(|at_s| self.around(at_s));
        let found = model.events().arrivals_after(self.looked_at).find(|(_, other, t_s)| {
            // What comes within the window that was shown last belongs to it.
            *other == kind && !shown.is_some_and(|span| span.holds(*t_s))
        });
        self.looked_at = found.map_or_else(|| model.events().arrived(), |(number, ..)| number);
        found.map(|(_, _, t_s)| t_s)
    }

    /// Up to where there is anything to look at (s). States, and what is derived, come behind the rows of their time: the end of the axis
    /// shows nothing about them.
    fn newest_s(&self, model: &Model) -> f64 {
        match self.source {
            TriggerSource::Event(_) => model.end_s(),
            TriggerSource::Edge { channel, .. } | TriggerSource::Level { channel, .. } => {
                let newest = model.series(channel).and_then(Series::latest);
                newest.map_or(f64::NEG_INFINITY, |(t_s, _)| t_s)
            }
        }
    }

    /// The first place behind the one time and up to the other (s).
    fn find(&self, model: &Model, behind_s: f64, to_s: f64) -> Option<f64> {
        let from_s = behind_s.max(f64::MIN).next_up();
        if from_s > to_s {
            return None;
        }
        let span = Span { from_s, to_s };
        match self.source {
            TriggerSource::Event(kind) => {
                let mut marks = model.events().in_span(span);
                marks.find(|mark| mark.kind == kind).map(|mark| mark.t_s)
            }
            TriggerSource::Edge { channel, level, rising } => {
                model.series(channel)?.crossing(span, level, rising)
            }
            TriggerSource::Level { channel, level, above } => {
                model.series(channel)?.beyond(span, level, above)
            }
        }
    }
}
