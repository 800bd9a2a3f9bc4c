//! Bytes of a gripper and the time in; force commands, recordings, news for clients and figures out: what runs inside gripd.
//!
//! One hot thread is paced by the data; what it has to tell goes as [`Item`]s through bounded rings to threads that may wait.

mod item;
pub mod realtime;

pub use item::{Beginning, ClientCommand, Item, LinkNote, State};
