//! The trigger as its panel has it and as the layout remembers it, with names that people can read and write.

use grip_scope::trigger::{Trigger, TriggerMode, TriggerSource};
use grip_scope::{Channel, EventKind};
use serde::{Deserialize, Serialize};
use slip_core::detector::DetectorConfig;

/// What the trigger waits for.
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
    /// A channel is above a level.
    Above,
    /// A channel is below a level.
    Below,
}

/// The trigger as its panel has it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TriggerForm {
    /// Whether it waits. It is not remembered: a window that is opened shows what comes.
    #[serde(skip)]
    pub armed: bool,
    /// For what.
    pub condition: Condition,
    /// For which event.
    #[serde(with = "event")]
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

impl Default for TriggerForm {
    fn default() -> Self {
        Self {
            armed: false,
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

impl TriggerForm {
    /// The trigger that does this.
    #[must_use]
    pub const fn trigger(&self) -> Trigger {
        let (channel, level) = (self.channel, crate::num::narrow(self.level));
        let source = match self.condition {
            Condition::RisingEdge => TriggerSource::Edge { channel, level, rising: true },
            Condition::FallingEdge => TriggerSource::Edge { channel, level, rising: false },
            Condition::Above => TriggerSource::Level { channel, level, above: true },
            Condition::Below => TriggerSource::Level { channel, level, above: false },
            Condition::Event => TriggerSource::Event(self.event),
        };
        Trigger::new(source, self.mode, self.before_s, self.window_s)
    }

    /// The same with every number in its range.
    #[must_use]
    pub fn within_limits(mut self) -> Self {
        let usual = Self::default();
        let in_range = |value: f64, usual: f64| {
            if value.is_finite() { value.clamp(1e-3, 600.0) } else { usual }
        };
        self.level = if self.level.is_finite() { self.level } else { usual.level };
        self.before_s = in_range(self.before_s, usual.before_s);
        self.window_s = in_range(self.window_s, usual.window_s).max(self.before_s);
        self
    }
}

mod event {
    use grip_scope::EventKind;
    use serde::{Deserialize as _, Deserializer, Serializer, de::Error as _};

    #[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes it so")]
    pub(super) fn serialize<S: Serializer>(kind: &EventKind, out: S) -> Result<S::Ok, S::Error> {
        out.serialize_str(kind.name())
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<EventKind, D::Error> {
        let name = String::deserialize(from)?;
        EventKind::ALL.into_iter().find(|kind| kind.name() == name).ok_or_else(|| {
            let names = EventKind::ALL.map(EventKind::name).join(", ");
            D::Error::custom(format!("no event is called {name:?}; there are {names}"))
        })
    }
}

mod column {
    use grip_scope::Channel;
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

#[cfg(test)]
mod tests {
    use super::{Condition, TriggerForm};
    use crate::layout::Layout;
    use grip_scope::trigger::TriggerMode;
    use grip_scope::{Channel, EventKind};

    #[test]
    fn every_form_comes_back_as_it_was_but_not_armed() {
        let conditions = [
            (Condition::RisingEdge, EventKind::Gross),
            (Condition::FallingEdge, EventKind::Gross),
            (Condition::Above, EventKind::Gross),
            (Condition::Below, EventKind::Gross),
            (Condition::Event, EventKind::Gap),
        ];
        let modes = [TriggerMode::Single, TriggerMode::Normal, TriggerMode::Auto];
        for (waits, mode) in conditions.into_iter().flat_map(|of| modes.map(|mode| (of, mode))) {
            let ((condition, event), channel) = (waits, Channel::Band3);
            let (armed, level, before_s, window_s) = (true, -2.5e-6, 0.25, 2.0);
            let form =
                TriggerForm { armed, condition, event, channel, level, mode, before_s, window_s };
            let layout = Layout { trigger: form, ..Layout::default() };
            let text = toml::to_string(&layout).unwrap();
            let read = Layout::parse(&text).unwrap().trigger;
            assert_eq!(read, TriggerForm { armed: false, ..form }, "{text}");
        }
    }

    #[test]
    fn wrong_names_are_reported_and_odd_numbers_mended() {
        let reported = |text: &str| Layout::parse(text).unwrap_err().to_string();
        let event = reported("[trigger]\nevent = \"earthquake\"\n");
        assert!(event.contains("line 2") && event.contains("gross slip"), "{event}");
        let channel = reported("[trigger]\nchannel = \"height\"\n");
        assert!(channel.contains("force_n"), "{channel}");
        let older = Layout::parse("[trigger]\nchannel = \"statistic\"\n").unwrap().trigger;
        assert_eq!(older.channel, Channel::Statistic);
        let odd = "[trigger]\nlevel = nan\nbefore_s = 5.0\nwindow_s = -1.0\n";
        let form = Layout::parse(odd).unwrap().trigger;
        assert_eq!((form.level, form.before_s, form.window_s), (600.0, 5.0, 5.0));
    }
}
