//! Open lines to grippers, by the name of the port.
//!
//! Ports are listed, described and, but for Linux, opened with the crate `serialport`. What only Linux has stands in the module
//! `linux`, what every other system gets instead in `elsewhere`; both give the same names to the rest.
//!
//! Nothing here waits between tries: pauses ([`Backoff`]) are for the caller.

// Tests run it on Linux as well.
#[cfg(any(not(target_os = "linux"), test))]
#[cfg_attr(target_os = "linux", expect(unreachable_pub, reason = "public on other systems"))]
mod elsewhere;
mod error;
mod find;
mod line;
#[cfg(target_os = "linux")]
mod linux;
mod list;
mod open;
mod source;

#[cfg(not(target_os = "linux"))]
use elsewhere as system;
#[cfg(target_os = "linux")]
use linux as system;

pub use error::PortError;
pub use find::{Backoff, Finder, UsbFilter, Wanted, describe, describe_usb};
pub use line::{Line, LineCounters, LineKind, Written, least_interval_us, nonce};
pub use list::{PortInfo, UsbPort};
pub use open::check_baud;
pub use source::{DEFAULT_BAUD, READ_TIMEOUT, Source};
pub use system::Places;
