//! One module a target, each with `check(data)`; what they and the peers share stands beside them.

pub mod chunks;
pub mod decoder;
pub mod device;
pub mod directed;
pub mod gripper;
pub mod host;
pub mod input;
pub mod messages;
pub mod peers;
pub mod player;
pub mod reference;
pub mod script;
pub mod words;

/// A target: panics where a promise is broken.
pub type Check = fn(&[u8]);

/// Every target by the name of its seed folder.
pub const TARGETS: [(&str, Check); 5] = [
    ("decoder", decoder::check),
    ("chunks", chunks::check),
    ("messages", messages::check),
    ("device", device::check),
    ("host", host::check),
];
