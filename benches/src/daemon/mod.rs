//! A virtual gripper in; what gripd makes of it out: latency, lost samples, processor time, memory.
//!
//! Nothing here reads a clock of its own: the programs hand one in.

pub mod gripper;
pub mod rig;
pub mod soak;
pub mod usage;
