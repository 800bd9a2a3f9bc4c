//! Robotiq's devices, sans-IO: requests, states and samples from bytes and time.
//!
//! [`gripper`] drives a 2F-85, 2F-140 or Hand-E over Modbus RTU, [`tsf85`] reads the fingertips TSF-85. Register map and frame format
//! are those that Robotiq publishes (manuals of the grippers, public repositories `robotiq/grippers` and `robotiq/tactile_sensors`).
//! Nothing here was run on a device.

pub mod gripper;
mod modbus;
mod model;
mod status;
pub mod tsf85;

pub use modbus::BusCounters;
pub use model::{Model, ModelError};
pub use status::{Fault, ObjectDetection, Severity, Status};
