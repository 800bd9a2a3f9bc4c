//! Writer and reader of what leaves a gripper's daemon, as MCAP recordings that PlotJuggler, Foxglove and `gripctl` open.
//!
//! A recording is an MCAP file (mcap.dev/spec) in chunks compressed with lz4. Its messages are CDR with ROS 2 definitions
//! ([`Topic`], [`Record`]); log times are wall time at host time 0 plus the monotonic host time, so they never go back, whatever
//! the wall clock does. Configuration, model and calibration are attachments, versions and identities metadata.

mod cdr;
mod chunk;
mod codes;
mod error;
mod foreign;
mod health;
mod index;
mod json;
mod raw;
mod read;
mod record;
mod recover;
mod schema;
mod write;

pub use cdr::{CdrError, CdrReader, CdrWriter};
pub use error::{McapError, McapWriteError};
pub use foreign::{Foreign, ForeignChannel, ForeignReader, no_unpack};
pub use health::HealthRecord;
pub use index::{ChunkPlace, McapIndex};
pub use json::{JsonTimes, JsonWriter};
pub use raw::Unpack;
pub use read::{Entry, McapReader};
pub use record::{
    CommandRecord, EventRecord, LinkRecord, PipelineRecord, Record, SampleRecord, WireRecord,
};
pub use recover::{RecoverError, Recovered, recover};
pub use schema::{MESSAGE_ENCODING, SCHEMA_ENCODING, Topic};
pub use slip_core::PipelineState;
pub use write::{Attached, McapWriter, Written};
