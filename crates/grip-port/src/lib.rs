//! The name of a port in; an open line to a gripper, real or simulated, out: what the daemon and the toolbox share of it.
//!
//! Time is told by the caller, here too: the simulator gets its clock as an argument, and pauses between tries are for the caller to
//! wait.

mod error;
mod find;
mod line;
mod open;
mod places;
mod simulator;
mod source;

pub use error::PortError;
pub use find::{Backoff, Finder, Wanted, describe, describe_usb};
pub use line::{Line, LineCounters, LineKind, Written, least_interval_us, nonce};
pub use open::check_baud;
pub use places::{Places, PortInfo, UsbPort};
pub use source::{DEFAULT_BAUD, PortArgs, READ_TIMEOUT, Source};
