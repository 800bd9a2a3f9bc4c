//! One module a target, each with `check(data)`; what they share stands in `gripper`, `input` and `reference`.

pub mod chunks;
pub mod decoder;
pub mod device;
pub mod gripper;
pub mod host;
pub mod input;
pub mod messages;
pub mod peers;
pub mod reference;
pub mod script;

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
