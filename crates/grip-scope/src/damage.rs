//! Damage in a recording: what can be read is read, and the parts that cannot are passed over and counted.

use grip_record::mcap::{McapError, McapIndex, McapReader};
use std::io::{Read, Seek};

/// What of a recording could not be read.
#[derive(Default)]
pub(crate) struct Damage {
    pub(crate) first: Option<McapError>,
    last_at: Option<u64>,
    /// Damaged parts that were passed over.
    pub(crate) passed: u32,
    /// Why reading stopped before the end.
    pub(crate) end: Option<McapError>,
}

impl Damage {
    /// Goes to what can be read behind the damage, by the index where nothing else reports it: `false` where nothing can be. Where the
    /// damaged part begins (byte), where it is another one than before: each message in a damaged part is reported.
    pub(crate) fn pass<R: Read + Seek>(
        &mut self,
        error: McapError,
        reader: &mut McapReader<R>,
        index: Option<&McapIndex>,
    ) -> (bool, Option<u64>) {
        let Some(at_byte) = error.damaged_at() else {
            self.end = Some(error);
            return (false, None);
        };
        let next = || index?.chunks.iter().find(|chunk| chunk.offset > at_byte);
        let more =
            reader.goes_on() || next().is_some_and(|chunk| reader.jump(chunk.offset).is_ok());
        let new = self.last_at.replace(at_byte) != Some(at_byte);
        if !more {
            self.end = Some(error);
            return (false, None);
        }
        self.passed += u32::from(new);
        self.first.get_or_insert(error);
        (true, new.then_some(at_byte))
    }
}
