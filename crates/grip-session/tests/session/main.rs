//! The session over a line that is late, lost or bent, with the virtual gripper at its other end.
#![expect(
    clippy::unwrap_used,
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "test code"
)]

mod clocks;
mod link_loss;
mod sensor_board;
