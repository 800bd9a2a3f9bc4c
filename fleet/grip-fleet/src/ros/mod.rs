//! Names, bytes and stamps of what a gripper's daemon reports, as a ROS 2 node on Zenoh would give them. No ROS, no network, no clock.
//!
//! A ROS 2 computer whose middleware is `rmw_zenoh_cpp` finds nodes by liveliness tokens, and receives publications whose name is made of domain,
//! topic, type and a hash of the type's fields. Who keeps these rules is a node, whatever it is written in. Sources:
//!
//! * names, tokens and their form of the quality of service: `docs/design.md`, `liveliness_utils.cpp` and `qos.cpp` of
//!   [rmw_zenoh](https://github.com/ros2/rmw_zenoh), as in the versions 0.2.9 (Jazzy) and 0.6.6 (Kilted);
//! * what stands beside each publication: `attachment_helpers.cpp` there, in the form it has since 0.2.4 and 0.6.0 (change 601);
//! * hashes: REP-2011 and `rosidl_generator_type_description`, RIHS01;
//! * messages: plain CDR, little-endian ([`CdrWriter`](grip_record::mcap::CdrWriter)), as Fast-CDR writes them for both distributions.
//!
//! The definitions of the messages of our own are a ROS package, `ros/grip_msgs`.

mod attachment;
mod message;
mod node;
mod topic;

pub use attachment::{Attachment, Gid};
pub use message::{Stamp, grip_state, joint_state, messages, slip_event};
pub use node::RosNode;
pub use topic::RosTopic;
