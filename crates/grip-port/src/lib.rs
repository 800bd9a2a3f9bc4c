//! The name of a port in; an open line to a gripper, real or simulated, out: what the daemon and the toolbox share of it.
//!
//! Time is told by the caller, here too: the simulator gets its clock as an argument.

mod error;
mod line;
mod simulator;
mod source;

pub use error::PortError;
pub use line::{Line, nonce};
pub use source::{DEFAULT_BAUD, PortArgs, Source};
