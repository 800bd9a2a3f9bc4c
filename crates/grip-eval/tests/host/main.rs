//! Configuration, model, session and replay together, on objects made by hand and by the simulator.
#![expect(
    clippy::unwrap_used,
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "test code"
)]

mod estimate;
mod faults;
mod grasp;
mod methods;
mod session;
mod velocity;
