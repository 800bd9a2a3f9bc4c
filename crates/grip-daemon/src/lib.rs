//! Bytes of a gripper and the time in; force commands, recordings, news for clients and figures out: what runs inside gripd.
//!
//! One hot thread is paced by the data; what it has to tell goes as [`Item`]s through bounded rings to threads that may wait.

pub mod counters;
pub mod hot;
mod item;
pub mod latency;
pub mod realtime;
pub mod rings;
pub mod supply;

pub use grip_host::session::{Beginning, ClientCommand};
pub use item::{Item, LinkNote, State};
