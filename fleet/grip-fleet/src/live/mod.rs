//! Messages of a live view of one daemon: the topics, schemas and bytes that a recording has, so that the same
//! layout shows both.
//!
//! [`Translator`] is that without a network and without a clock; [`Server`] serves it to any number of Foxglove apps.

mod convert;
mod server;
mod time;
mod translator;

pub use server::{ServeError, Server};
pub use translator::{Out, Translator};

use grip_link::message::Versions;
use grip_link::message::daemon::{Subscribe, Topics};
use grip_record::mcap::{self, HealthRecord};

/// Milliseconds between two STATE, as between two states of a recording.
const STATE_MS: u16 = 10;

/// What a message of a live view is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Topic {
    /// Sensor readings.
    Sample,
    /// What the pipeline thinks.
    State,
    /// Slips, and sensors whose health changes.
    Event,
    /// Updates of daemon, link and gripper.
    Link,
    /// Figures of the daemon; recordings have none.
    Health,
}

impl Topic {
    /// Every topic.
    pub const ALL: [Self; 5] = [Self::Sample, Self::State, Self::Event, Self::Link, Self::Health];

    /// Name of the topic, that of a recording.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self.recorded() {
            Some(topic) => topic.name(),
            None => HealthRecord::TOPIC,
        }
    }

    /// Name of its schema.
    #[must_use]
    pub const fn schema(self) -> &'static str {
        match self.recorded() {
            Some(topic) => topic.schema(),
            None => HealthRecord::SCHEMA,
        }
    }

    /// The definition of its message.
    #[must_use]
    pub fn definition(self) -> String {
        self.recorded().map_or_else(HealthRecord::definition, mcap::Topic::definition)
    }

    /// The topic of a recording that it is.
    #[must_use]
    pub const fn recorded(self) -> Option<mcap::Topic> {
        Some(match self {
            Self::Sample => mcap::Topic::Sample,
            Self::State => mcap::Topic::State,
            Self::Event => mcap::Topic::Event,
            Self::Link => mcap::Topic::Link,
            Self::Health => return None,
        })
    }

    const fn index(self) -> usize {
        self as usize
    }
}

/// The topics that somebody looks at.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Wanted([bool; Topic::ALL.len()]);

impl Wanted {
    /// Those for which `wanted` holds.
    #[must_use]
    pub fn of(wanted: impl FnMut(Topic) -> bool) -> Self {
        Self(Topic::ALL.map(wanted))
    }

    /// Whether somebody looks at this one.
    #[must_use]
    pub const fn has(self, topic: Topic) -> bool {
        self.0[topic.index()]
    }

    /// What the daemon is asked for, and every n-th sample (n at least 1): samples, states and slips only while somebody looks. Figures
    /// and events come always: they are rare, report that the daemon lives, and place samples in time.
    #[must_use]
    pub fn subscribe(self, every_nth: u16) -> Subscribe {
        let mut topics = Topics::HEALTH.and(Topics::NEWS);
        for (topic, asked) in [(Topic::State, Topics::STATE), (Topic::Event, Topics::SLIP)] {
            topics = if self.has(topic) { topics.and(asked) } else { topics };
        }
        let every_nth = if self.has(Topic::Sample) { every_nth.max(1) } else { 0 };
        Subscribe { versions: Versions::OURS, topics, every_nth, state_ms: STATE_MS }
    }
}

#[cfg(test)]
mod tests;
