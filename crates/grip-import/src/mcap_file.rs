//! An MCAP file of any program in: a stream for each topic with JSON or ROS 2 messages.

use crate::{
    ImportOptions,
    error::ImportError,
    stream::{Room, Stream},
    topic::Topic,
    zstd::unpack,
};
use grip_record::mcap::{Foreign, ForeignChannel, ForeignReader, McapError, Topic as Own};
use std::{collections::BTreeMap, path::Path};

pub(crate) fn read(file: &Path, options: &ImportOptions) -> Result<Vec<Stream>, ImportError> {
    let mut reader = ForeignReader::open(file, unpack)?;
    let mut topics: BTreeMap<u16, Topic> = BTreeMap::new();
    let (mut notes, mut room) = (Vec::new(), Room::default());
    loop {
        match reader.next_item() {
            Ok(None) => break,
            Ok(Some(Foreign::Channel { id, channel })) => {
                let known = topics.contains_key(&id);
                let wanted = options.topics.is_empty() || options.topics.contains(&channel.topic);
                if Own::from_name(&channel.topic).is_some()
                    && channel.schema.starts_with("grip_msgs/")
                {
                    let what = "it is a recording of gripd: `gripctl replay` takes it as it is, `gripctl csv` writes its samples";
                    return Err(ImportError::nothing(file, what));
                }
                match topic_of(&channel) {
                    Ok(topic) if wanted && !known => drop(topics.insert(id, topic)),
                    Err(fault) if wanted => notes.push(format!("{} {fault}", channel.topic)),
                    _ => {}
                }
            }
            Ok(Some(Foreign::Message { channel, log_ns, data })) => {
                if let Some(topic) = topics.get_mut(&channel) {
                    let log_ns = i64::try_from(log_ns).unwrap_or(i64::MAX);
                    topic.push(file, &mut room, log_ns, data)?;
                }
            }
            // A recorder that was killed leaves no end; what is there is whole.
            Err(McapError::Truncated { offset, .. }) if !topics.is_empty() => {
                notes
                    .push(format!("the file ends early, at byte {offset}; what is before is used"));
                break;
            }
            Err(error) => return Err(error.into()),
        }
    }
    if topics.is_empty() {
        let what = format!("no topic can be read: {}", notes.join("; "));
        return Err(ImportError::nothing(
            file,
            if notes.is_empty() { "it has no topics" } else { &what },
        ));
    }
    let mut streams: Vec<Stream> = topics.into_values().map(Topic::finish).collect();
    if let Some(first) = streams.first_mut() {
        first.notes.extend(notes);
    }
    Ok(streams)
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
