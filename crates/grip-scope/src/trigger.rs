//! The trigger: the span that a person wanted to stop at.

use crate::model::{Model, Series};
use crate::{channel::Channel, feed::EventKind, num, span::Span};
use serde::{Deserialize, Serialize};
use slip_core::detector::DetectorConfig;

/// What is waited for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Condition {
    /// Something happens.
    #[default]
    Event,
    /// A channel crosses a level upwards.
    RisingEdge,
    /// A channel crosses a level downwards.
    FallingEdge,
    /// A channel is above a level, however it came there.
    Above,
    /// A channel is below a level.
    Below,
}

impl Condition {
    /// Those of a channel.
    pub const OF_A_CHANNEL: [Self; 4] =
        [Self::RisingEdge, Self::FallingEdge, Self::Above, Self::Below];
}

/// How often it shows what it found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
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

/// What is waited for and what is shown then, as a layout remembers it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TriggerSettings {
    /// For what.
    pub condition: Condition,
    /// For which event.
    pub event: EventKind,
    /// Of which channel, as a CSV file calls it.
    #[serde(with = "column")]
    pub channel: Channel,
    /// At which level (unit of the channel, without prefix).
    pub level: f64,
    /// How often.
    pub mode: TriggerMode,
    /// How much is seen before it (s).
    pub before_s: f64,
    /// How much is seen in all (s).
    pub window_s: f64,
}

impl Default for TriggerSettings {
    fn default() -> Self {
        Self {
            condition: Condition::Event,
            event: EventKind::Gross,
            channel: Channel::Statistic,
            level: DetectorConfig::default().interval_s.into(),
            mode: TriggerMode::Normal,
            before_s: 0.1,
            window_s: 0.5,
        }
    }
}

impl TriggerSettings {
    /// The same with every number in its range.
    #[must_use]
    pub fn within_limits(mut self) -> Self {
        let usual = Self::default();
        let finite = |value: f64, usual: f64| if value.is_finite() { value } else { usual };
        let in_range = |value: f64, usual: f64| finite(value, usual).clamp(1e-3, 600.0);
        self.level = finite(self.level, usual.level);
        self.before_s = in_range(self.before_s, usual.before_s);
        self.window_s = in_range(self.window_s, usual.window_s).max(self.before_s);
        self
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
        match self.condition {
            Condition::Above | Condition::Below => self.around(at_s).to_s,
            Condition::RisingEdge | Condition::FallingEdge | Condition::Event => at_s,
        }
    }

    /// What is shown around a place (s).
    #[must_use]
    pub fn around(&self, at_s: f64) -> Span {
        Span::new(at_s - self.before_s, at_s - self.before_s + self.window_s)
    }

    /// Up to where there is anything to look at (s). States, and what is derived, come behind the rows of their time: the end of the axis
    /// shows nothing about them.
    fn newest_s(&self, model: &Model) -> f64 {
        if self.condition == Condition::Event {
            return model.end_s();
        }
        let newest = model.series(self.channel).and_then(Series::latest);
        newest.map_or(f64::NEG_INFINITY, |(t_s, _)| t_s)
    }

    /// The first place behind the one time and up to the other (s).
    fn find(&self, model: &Model, behind_s: f64, to_s: f64) -> Option<f64> {
        let from_s = behind_s.max(f64::MIN).next_up();
        if from_s > to_s {
            return None;
        }
        let span = Span { from_s, to_s };
        let level = num::narrow(self.level);
        let up = matches!(self.condition, Condition::RisingEdge | Condition::Above);
        match self.condition {
            Condition::Event => {
                let mut marks = model.events().marks.within(span);
                marks.find(|mark| mark.kind == self.event).map(|mark| mark.t_s)
            }
            Condition::RisingEdge | Condition::FallingEdge => {
                model.series(self.channel)?.crossing(span, level, up)
            }
            Condition::Above | Condition::Below => {
                model.series(self.channel)?.beyond(span, level, up)
            }
        }
    }
}

mod column {
    use crate::Channel;
    use serde::{Deserialize as _, Deserializer, Serializer, de::Error as _};

    #[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes it so")]
    pub(super) fn serialize<S: Serializer>(channel: &Channel, out: S) -> Result<S::Ok, S::Error> {
        out.serialize_str(channel.column())
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Channel, D::Error> {
        let name = String::deserialize(from)?;
        // What every layout of an older version names. Its level, where one was chosen, was in intervals.
        let name = if name == "statistic" { "evidence_s".to_owned() } else { name };
        Channel::of_column(&name).ok_or_else(|| {
            let names = Channel::ALL.map(Channel::column).join(", ");
            D::Error::custom(format!("no channel is called {name:?}; there are {names}"))
        })
    }
}

/// A trigger as oscilloscopes have one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Trigger {
    /// For what it waits.
    pub settings: TriggerSettings,
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
    pub fn new(settings: TriggerSettings) -> Self {
        Self { settings, ..Self::default() }
    }

    /// Whether a single trigger has shown what it found.
    #[must_use]
    pub const fn is_done(&self) -> bool {
        self.done
    }

    /// Looks at what is new: what to show, once all of it is there.
    pub fn poll(&mut self, model: &Model) -> Option<Found> {
        let TriggerSettings { condition, mode, before_s, window_s, .. } = self.settings;
        let end_s = model.end_s();
        let newest_s = self.settings.newest_s(model);
        if self.looked_s.is_none() {
            self.looked_at = model.events().arrived();
        }
        let from_s = *self.looked_s.get_or_insert(newest_s);
        if self.done {
            return None;
        }
        let behind_s = window_s - before_s;
        if self.found_s.is_none() {
            self.found_s = if condition == Condition::Event {
                self.next_arrival(model)
            } else {
                // What comes within the window that was shown last belongs to it.
                let free_s = self.shown_s.map_or(from_s, |at_s| at_s + behind_s);
                self.settings.find(model, from_s.max(free_s), newest_s)
            };
            self.looked_s = Some(newest_s);
        }
        match self.found_s {
            Some(at_s) if end_s >= at_s + behind_s => {
                self.found_s = None;
                self.shown_s = Some(at_s);
                self.done = mode == TriggerMode::Single;
                Some(Found::Hit(self.settings.around(at_s)))
            }
            None if mode == TriggerMode::Auto => {
                let idle = self.shown_s.is_none_or(|at_s| end_s > at_s + 2.0 * window_s);
                idle.then(|| Found::Sweep(Span::new(end_s - window_s, end_s)))
            }
            _ => None,
        }
    }

    /// The next event that has come since the last look. Its time may be before that: a gap is reported when it is over, a mark may be set anywhere.
    fn next_arrival(&mut self, model: &Model) -> Option<f64> {
        let shown = self.shown_s.map(|at_s| self.settings.around(at_s));
        let found = model.events().arrivals_after(self.looked_at).find(|(_, other, t_s)| {
            // What comes within the window that was shown last belongs to it.
            *other == self.settings.event && !shown.is_some_and(|span| span.holds(*t_s))
        });
        self.looked_at = found.map_or_else(|| model.events().arrived(), |(number, ..)| number);
        found.map(|(_, _, t_s)| t_s)
    }
}
