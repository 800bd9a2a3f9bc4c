//! The topics of a recording and the definitions of their messages, as PlotJuggler and Foxglove want them.

slip_msg::named! {
    /// What a message is about; each topic has its own schema.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
    pub enum Topic {
        fn name: "Name of the topic in a file.";
        fn schema: "Name of its schema.";
    }
    Sample: "Sensor readings.", "/gripper/sample", "grip_msgs/msg/Sample";
    State: "What the pipeline thinks.", "/gripper/state", "grip_msgs/msg/State";
    Event: "Lines worth reading.", "/gripper/event", "grip_msgs/msg/Event";
    Command: "Force commands.", "/gripper/command", "grip_msgs/msg/Command";
    Client: "Commands of clients.", "/gripper/client", "grip_msgs/msg/Client";
    Link: "Updates of the link.", "/gripper/link", "grip_msgs/msg/Link";
    Wire: "Raw bytes of the line.", "/gripper/wire", "grip_msgs/msg/Wire";
    Pipeline: "What a pipeline begins with.", "/gripper/pipeline", "grip_msgs/msg/Pipeline";
}

/// Encoding of the messages, as MCAP names it.
pub const MESSAGE_ENCODING: &str = "cdr";
/// Encoding of the schemas, as MCAP names it.
pub const SCHEMA_ENCODING: &str = "ros2msg";

const TIME: &str = include_str!("msg/Time.msg");
/// Stands between the definitions of a message and those it uses.
const BORDER: &str = "================================================================================\nMSG: builtin_interfaces/Time\n";

impl Topic {
    /// The definition of its message, that of the time included.
    #[must_use]
    pub fn definition(self) -> String {
        let own = match self {
            Self::Sample => include_str!("msg/Sample.msg"),
            Self::State => include_str!("msg/State.msg"),
            Self::Event => include_str!("msg/Event.msg"),
            Self::Command => include_str!("msg/Command.msg"),
            Self::Client => include_str!("msg/Client.msg"),
            Self::Link => include_str!("msg/Link.msg"),
            Self::Wire => include_str!("msg/Wire.msg"),
            Self::Pipeline => include_str!("msg/Pipeline.msg"),
        };
        whole(own)
    }

    /// The topic of that name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|topic| topic.name() == name)
    }

    /// Place in [`Topic::ALL`].
    #[must_use]
    pub const fn index(self) -> usize {
        self as usize
    }
}

/// The definition of a message with that of the time behind it.
pub(super) fn whole(own: &str) -> String {
    format!("{own}{BORDER}{TIME}")
}

/// The fields of a definition, comments and constants left out: what decides whether a message can be read.
pub(super) fn fields(definition: &str) -> Vec<String> {
    let lines = definition.lines().take_while(|line| !line.starts_with("===="));
    let bare = lines.map(|line| line.split('#').next().unwrap_or_default().trim());
    bare.filter(|line| !line.is_empty() && !line.contains('='))
        .map(|line| line.split_whitespace().collect::<Vec<_>>().join(" "))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::{Topic, fields};

    #[test]
    fn topics_are_found_by_their_names() {
        for (index, topic) in Topic::ALL.into_iter().enumerate() {
            assert_eq!((Topic::from_name(topic.name()), topic.index()), (Some(topic), index));
            assert!(topic.definition().contains("builtin_interfaces/Time stamp\n"), "{topic:?}");
        }
        assert_eq!(Topic::from_name("/gripper"), None);
    }

    #[test]
    fn comments_and_constants_are_no_fields() {
        let text = "# a\nuint8 A=1\n\nuint8  a # b\nstring s\n=====\nMSG: x\nint32 y\n";
        assert_eq!(fields(text), ["uint8 a", "string s"]);
    }
}
