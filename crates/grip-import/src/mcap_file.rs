//! An MCAP file of any program in: a stream for each topic with JSON or ROS 2 messages.

use crate::{
    ImportOptions,
    error::ImportError,
    topic::{Topic, Topics},
    zstd::unpack,
};
use grip_record::mcap::{Foreign, ForeignChannel, ForeignReader, McapError, Topic as Own};
use std::{collections::BTreeMap, path::Path};

pub(crate) fn read(
    file: &Path,
    options: &ImportOptions,
    topics: &mut Topics,
) -> Result<(), ImportError> {
    let mut reader = ForeignReader::open(file, unpack)?;
    // A publisher that started again has another number, and the same topic.
    let mut places: BTreeMap<u16, usize> = BTreeMap::new();
    loop {
        match reader.next_item() {
            Ok(None) => return Ok(()),
            Ok(Some(Foreign::Channel { id, channel })) => {
                if Own::from_name(&channel.topic).is_some()
                    && channel.schema.starts_with("grip_msgs/")
                {
                    let name = grip_record::shell(&file.display().to_string());
                    let what = format!(
                        "it is a recording of gripd: `gripctl replay {name}` takes it as it is, `gripctl csv {name} -o run.csv` writes its samples"
                    );
                    return Err(ImportError::nothing(file, &what));
                }
                let ForeignChannel { topic, encoding, schema, definition, .. } = &channel;
                if options.topics.is_empty() || options.topics.contains(topic) {
                    let key = (topic.clone(), format!("{encoding} {schema}"), definition.clone());
                    if let Some(at) = topics.place(key, || topic_of(&channel)) {
                        places.insert(id, at);
                    }
                }
            }
            Ok(Some(Foreign::Message { channel, log_ns, data })) => {
                if let Some(at) = places.get(&channel) {
                    let log_ns = i64::try_from(log_ns).unwrap_or(i64::MAX);
                    topics.push(file, *at, log_ns, data)?;
                }
            }
            // A recorder that was killed leaves no end; what is there is whole.
            Err(McapError::Truncated { offset, .. }) if !places.is_empty() => {
                let file = file.display();
                topics.note(format!("{file} ends early, at byte {offset}; what is before is used"));
                return Ok(());
            }
            Err(error) => return Err(error.into()),
        }
    }
}

fn topic_of(channel: &ForeignChannel) -> Result<Topic, String> {
    match (channel.encoding.as_str(), channel.schema_encoding.as_str()) {
        ("json", _) => Ok(Topic::json(&channel.topic)),
        ("cdr", "ros2msg" | "") => {
            let text = String::from_utf8_lossy(&channel.definition);
            Topic::ros(&channel.topic, &channel.schema, &text)
        }
        (encoding, schema) => Err(format!(
            "is encoded as {encoding:?} with {schema:?}; JSON and ROS 2 (cdr with ros2msg) are read"
        )),
    }
}
