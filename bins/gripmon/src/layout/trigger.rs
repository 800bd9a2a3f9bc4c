//! The trigger as it is remembered: names that people can read and write in, a form of the trigger out.

use crate::form::{TriggerForm, TriggerKind};
use grip_scope::trigger::TriggerMode;
use grip_scope::{Channel, EventKind};
use serde::{Deserialize, Serialize};

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
    /// A channel is above a level.
    Above,
    /// A channel is below a level.
    Below,
}

/// How often it shows what it found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Mode {
    /// Once.
    Single,
    /// Every time.
    #[default]
    Normal,
    /// Every time, and the newest data where nothing comes.
    Auto,
}

/// The settings of the trigger. Whether it waits is not remembered: a window that is opened shows what comes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TriggerLayout {
    /// What is waited for.
    pub condition: Condition,
    /// Which event.
    #[serde(with = "event")]
    pub event: EventKind,
    /// Of which channel, as a CSV file calls it.
    #[serde(with = "column")]
    pub channel: Channel,
    /// At which level (unit of the channel, without prefix).
    pub level: f64,
    /// How often.
    pub mode: Mode,
    /// How much is seen before it (s).
    pub before_s: f64,
    /// How much is seen in all (s).
    pub window_s: f64,
}

impl Default for TriggerLayout {
    fn default() -> Self {
        Self::of(&TriggerForm::default())
    }
}

impl TriggerLayout {
    /// What is remembered of a form.
    #[must_use]
    pub const fn of(form: &TriggerForm) -> Self {
        let (condition, event) = match form.kind {
            TriggerKind::Event(kind) => (Condition::Event, kind),
            TriggerKind::Rising => (Condition::RisingEdge, EventKind::Gross),
            TriggerKind::Falling => (Condition::FallingEdge, EventKind::Gross),
            TriggerKind::Above => (Condition::Above, EventKind::Gross),
            TriggerKind::Below => (Condition::Below, EventKind::Gross),
        };
        let mode = match form.mode {
            TriggerMode::Single => Mode::Single,
            TriggerMode::Normal => Mode::Normal,
            TriggerMode::Auto => Mode::Auto,
        };
        let TriggerForm { channel, level, pre_s, window_s, .. } = *form;
        Self { condition, event, channel, level, mode, before_s: pre_s, window_s }
    }

    /// The form, not armed.
    #[must_use]
    pub const fn form(&self) -> TriggerForm {
        let kind = match self.condition {
            Condition::Event => TriggerKind::Event(self.event),
            Condition::RisingEdge => TriggerKind::Rising,
            Condition::FallingEdge => TriggerKind::Falling,
            Condition::Above => TriggerKind::Above,
            Condition::Below => TriggerKind::Below,
        };
        let mode = match self.mode {
            Mode::Single => TriggerMode::Single,
            Mode::Normal => TriggerMode::Normal,
            Mode::Auto => TriggerMode::Auto,
        };
        let Self { channel, level, before_s: pre_s, window_s, .. } = *self;
        TriggerForm { armed: false, kind, channel, level, mode, pre_s, window_s }
    }

    /// The same with every number in its range.
    #[must_use]
    pub fn mended(mut self) -> Self {
        let usual = TriggerForm::default();
        let in_range = |value: f64, usual: f64| {
            if value.is_finite() { value.clamp(1e-3, 600.0) } else { usual }
        };
        self.level = if self.level.is_finite() { self.level } else { usual.level };
        self.before_s = in_range(self.before_s, usual.pre_s);
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
        out.serialize_str(&channel.column())
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Channel, D::Error> {
        let name = String::deserialize(from)?;
        Channel::of_column(&name).ok_or_else(|| {
            let names: Vec<String> = Channel::all().map(Channel::column).collect();
            let names = names.join(", ");
            D::Error::custom(format!("no channel is called {name:?}; there are {names}"))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::TriggerLayout;
    use crate::form::{TriggerForm, TriggerKind};
    use crate::layout::Layout;
    use grip_scope::trigger::TriggerMode;
    use grip_scope::{Channel, EventKind};

    #[test]
    fn every_form_comes_back_as_it_was_but_not_armed() {
        let kinds = [
            TriggerKind::Rising,
            TriggerKind::Falling,
            TriggerKind::Above,
            TriggerKind::Below,
            TriggerKind::Event(EventKind::Gap),
        ];
        let modes = [TriggerMode::Single, TriggerMode::Normal, TriggerMode::Auto];
        for (kind, mode) in kinds.into_iter().flat_map(|kind| modes.map(|mode| (kind, mode))) {
            let channel = Channel::BandEnergy(3);
            let (level, pre_s, window_s) = (-2.5e-6, 0.25, 2.0);
            let form = TriggerForm { armed: true, kind, channel, level, mode, pre_s, window_s };
            let trigger = TriggerLayout::of(&form);
            let layout = Layout { trigger, ..Layout::default() };
            let text = toml::to_string(&layout).unwrap();
            let read = Layout::parse(&text).unwrap().trigger.form();
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
        let odd = "[trigger]\nlevel = nan\nbefore_s = 5.0\nwindow_s = -1.0\n";
        let form = Layout::parse(odd).unwrap().trigger.form();
        assert_eq!((form.level, form.pre_s, form.window_s), (1.0, 5.0, 5.0));
    }
}
