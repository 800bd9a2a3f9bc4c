//! Publisher of frames of a gripper's daemon, as names and events that survive a lost network, and receiver for those who watch many grippers.
//!
//! What travels are the frames that clients of the daemon get at its socket (`protocol/CLIENTS.md`), unchanged, under names
//! that [`Member::key`] makes. Nothing but the module `net` and the server in [`live`] knows a
//! network:
//!
//! * [`Bridge`]: what is to be published of the bytes of the daemon;
//! * [`EventLog`]: events in, numbered once and kept as long as there is room, in memory or in a [`Spool`];
//! * [`archive`]: events and HEALTH of many grippers as MCAP files by day, each event once through kills;
//! * [`json`]: the JSON object that stands for a message;
//! * [`live`]: messages of one daemon as those of a live view for Foxglove;
//! * [`recordings`]: what a daemon has recorded, and copies of it elsewhere;
//! * [`Follower`]: receiver of the numbered events of one gripper, each of them once and in order, or the request for what is missing;
//! * [`deploy`]: whether a model that comes to one gripper may be tried, stays or goes back;
//! * [`rollout`]: who of many grippers gets a model next, and who gives it back, by what each reports;
//! * [`ros`]: the same messages as the node of a ROS 2 gripper would report them.

mod about;
pub mod archive;
mod bridge;
pub mod deploy;
mod follower;
mod id;
pub mod json;
mod key;
pub mod live;
mod log;
mod message;
pub mod net;
pub mod recordings;
pub mod rollout;
pub mod ros;
mod spool;
mod store;

pub use about::About;
pub use bridge::{Bridge, Greeting, Incoming, LastReceived, Publication, Setup};
pub use follower::{Follower, Since, Verdict};
pub use grip_session::config::{Site, Uid};
pub use id::{EventId, IdError, Stamp, WallTime};
pub use key::{Member, Part, Selector};
pub use log::{EventLog, Logged};
pub use message::{Message, MessageError, wire};
pub use spool::Spool;
pub use store::StoreError;
