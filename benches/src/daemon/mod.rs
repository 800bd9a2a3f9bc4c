//! What a test or a program has beside a real gripd, or its hot loop: a gripper and the rings.

pub mod gripper;
pub mod rig;
