//! The whole pipeline on hand-made objects: broken sensors, gaps in time, every sample rate.
#![expect(clippy::unwrap_used, reason = "test code")]

mod faults;
mod object;
mod timing;
