//! Writer of an MCAP file, from JSON messages of any topics.

use core::fmt;
use core::sync::atomic::{AtomicU64, Ordering};
use std::collections::BTreeMap;
use std::io::Write;
use std::sync::Arc;

use mcap::Writer;
use mcap::records::MessageHeader;
use mcap::write::NoSeek;

use super::error::McapWriteError;
use super::write::{Tally, options};

/// When a message was written and when what it is about happened (ns since 1970).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct JsonTimes {
    /// Log time; one before that of the last message counts as that.
    pub log_ns: u64,
    /// Publish time.
    pub publish_ns: u64,
}

/// Writes JSON messages with JSON Schemas, in chunks compressed with lz4; as [`McapWriter`](super::McapWriter) it never seeks, and a file
/// that was not finished can be [recovered](super::recover).
pub struct JsonWriter<W: Write> {
    out: Writer<NoSeek<Tally<W>>>,
    bytes: Arc<AtomicU64>,
    last_ns: u64,
    messages: u32,
}

impl<W: Write> fmt::Debug for JsonWriter<W> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("JsonWriter").field("bytes", &self.bytes()).finish_non_exhaustive()
    }
}

impl<W: Write> JsonWriter<W> {
    /// Begins a file. `program` names who writes, with its version.
    ///
    /// # Errors
    /// Where `out` refuses the bytes.
    pub fn new(out: W, program: &str) -> Result<Self, McapWriteError> {
        let bytes = Arc::new(AtomicU64::new(0));
        let tally = NoSeek::new(Tally::new(out, &bytes));
        let out = Writer::with_options(tally, options("", program))?;
        Ok(Self { out, bytes, last_ns: 0, messages: 0 })
    }

    /// The number of the channel of a topic, whose messages are as the JSON Schema of that name describes; there may be 65,535.
    ///
    /// # Errors
    /// Where there are too many, or the output refuses the bytes.
    pub fn channel(
        &mut self,
        topic: &str,
        name: &str,
        schema: &str,
    ) -> Result<u16, McapWriteError> {
        let schema = self.out.add_schema(name, "jsonschema", schema.as_bytes())?;
        Ok(self.out.add_channel(schema, topic, "json", &BTreeMap::new())?)
    }

    /// Writes a message of a channel.
    ///
    /// # Errors
    /// Where the channel is none, or the output refuses the bytes: nothing more can be written then.
    pub fn write(
        &mut self,
        channel: u16,
        times: JsonTimes,
        json: &str,
    ) -> Result<(), McapWriteError> {
        self.last_ns = times.log_ns.max(self.last_ns);
        let header = MessageHeader {
            channel_id: channel,
            sequence: self.messages,
            log_time: self.last_ns,
            publish_time: times.publish_ns,
        };
        self.messages = self.messages.wrapping_add(1);
        Ok(self.out.write_to_known_channel(&header, json.as_bytes())?)
    }

    /// Ends the chunk and hands everything to the operating system.
    ///
    /// # Errors
    /// Where the output refuses the bytes.
    pub fn flush(&mut self) -> Result<(), McapWriteError> {
        Ok(self.out.flush()?)
    }

    /// Ends the file with its index and statistics.
    ///
    /// # Errors
    /// Where the output refuses the bytes.
    pub fn finish(mut self) -> Result<(), McapWriteError> {
        self.out.finish()?;
        Ok(())
    }

    /// Bytes handed to the output; what waits in the chunk is not among them.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.bytes.load(Ordering::Relaxed)
    }
}

#[cfg(test)]
mod tests {
    use super::{JsonTimes, JsonWriter};
    use crate::mcap::{Foreign, ForeignReader, no_unpack, recover};
    use std::path::Path;

    fn file(finished: bool) -> Vec<u8> {
        let mut out = Vec::new();
        let mut writer = JsonWriter::new(&mut out, "test").unwrap();
        for (at, topic) in ["/a", "/b", "/a"].into_iter().enumerate() {
            let channel = writer.channel(topic, "Event", r#"{"type":"object"}"#).unwrap();
            let times = JsonTimes { log_ns: 9 - at as u64, publish_ns: 5 };
            writer.write(channel, times, &format!("{{\"at\":{at}}}")).unwrap();
        }
        writer.flush().unwrap();
        let flushed = usize::try_from(writer.bytes()).unwrap();
        writer.finish().unwrap();
        out.truncate(if finished { out.len() } else { flushed });
        out
    }

    /// Topics and messages in their order, with their log times.
    fn read(bytes: &[u8]) -> Vec<String> {
        let mut reader = ForeignReader::new(Path::new("x"), bytes, no_unpack).unwrap();
        let mut found = Vec::new();
        while let Ok(Some(item)) = reader.next_item() {
            found.push(match item {
                Foreign::Channel { channel, .. } => {
                    format!("{} {} {}", channel.topic, channel.encoding, channel.schema_encoding)
                }
                Foreign::Message { log_ns, data, .. } => {
                    format!("{log_ns} {}", String::from_utf8_lossy(data))
                }
            });
        }
        found
    }

    #[test]
    fn messages_come_back_also_from_a_file_that_was_cut_off_behind_a_flush() {
        let wanted = [
            "/a json jsonschema",
            "9 {\"at\":0}",
            "/b json jsonschema",
            "9 {\"at\":1}",
            "9 {\"at\":2}",
        ];
        assert_eq!(read(&file(true)), wanted);
        let mut whole = Vec::new();
        let recovered =
            recover(Path::new("x"), &*file(false), &mut whole, "test", no_unpack).unwrap();
        assert_eq!((recovered.messages, recovered.holes.len()), (3, 0));
        assert_eq!(read(&whole), wanted);
    }
}
