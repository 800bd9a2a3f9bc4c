//! The whole pipeline on hand-made objects: broken sensors, gaps in time, every sample rate.
#![expect(
    clippy::unwrap_used,
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "test code"
)]

mod causes;
mod faults;
mod no_rest;
mod object;
mod reference;
mod taxels;
mod timing;
