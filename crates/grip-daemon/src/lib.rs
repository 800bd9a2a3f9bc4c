//! The inside of gripd: force commands, recordings, messages for clients and metrics from the bytes of a gripper and the time.
//!
//! One hot thread is paced by the data; what it has to report goes as [`Item`]s through bounded rings to threads that may wait.

pub mod board;
pub mod client;
pub mod clients;
pub mod counters;
pub mod dump;
pub mod ends;
pub mod exposition;
pub mod hot;
pub mod http;
pub mod latency;
pub mod live;
pub mod log;
pub mod metrics;
pub mod pages;
pub mod port_manager;
pub mod realtime;
pub mod recorder;
mod rhythm;
pub mod rings;
pub mod rows;
pub mod status;

pub use board::Board;
pub use counters::HotCounters;
pub use grip_session::session::Beginning;
pub use latency::Latency;
pub use rings::{Item, LinkNote};
