//! The trigger as its panel has it.

use grip_scope::trigger::{Trigger, TriggerMode, TriggerSource};
use grip_scope::{Channel, EventKind};

/// What the trigger waits for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TriggerKind {
    /// A channel crosses a level upwards.
    Rising,
    /// A channel crosses a level downwards.
    Falling,
    /// A channel is above a level.
    Above,
    /// A channel is below a level.
    Below,
    /// Something happens.
    Event(EventKind),
}

/// The trigger as its panel has it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriggerForm {
    /// Whether it waits.
    pub armed: bool,
    /// For what.
    pub kind: TriggerKind,
    /// Of which channel.
    pub channel: Channel,
    /// At which level (unit of the channel).
    pub level: f64,
    /// How often.
    pub mode: TriggerMode,
    /// How much is seen before it (s).
    pub pre_s: f64,
    /// How much is seen in all (s).
    pub window_s: f64,
}

impl Default for TriggerForm {
    fn default() -> Self {
        Self {
            armed: false,
            kind: TriggerKind::Event(EventKind::Gross),
            channel: Channel::Statistic,
            level: 1.0,
            mode: TriggerMode::Normal,
            pre_s: 0.1,
            window_s: 0.5,
        }
    }
}

impl TriggerForm {
    /// The trigger that does this.
    #[must_use]
    pub const fn trigger(&self) -> Trigger {
        let (channel, level) = (self.channel, crate::num::narrow(self.level));
        let source = match self.kind {
            TriggerKind::Rising => TriggerSource::Edge { channel, level, rising: true },
            TriggerKind::Falling => TriggerSource::Edge { channel, level, rising: false },
            TriggerKind::Above => TriggerSource::Level { channel, level, above: true },
            TriggerKind::Below => TriggerSource::Level { channel, level, above: false },
            TriggerKind::Event(kind) => TriggerSource::Event(kind),
        };
        Trigger::new(source, self.mode, self.pre_s, self.window_s)
    }
}
