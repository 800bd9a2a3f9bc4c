//! What only Linux has, beside what `serialport` does everywhere:
//!
//! - `places`: of each port the link that keeps its name, the driver, the speed of its bus and the latency timer of an FTDI converter;
//!   ports on buses that `serialport` does not know (UARTs of many boards), and none for UARTs that were never found.
//! - `open`: a port that is held against root as well, whose modem lines stay up when it is closed (no HUPCL), at any baud rate, and an
//!   error that states what the system said. `serialport` does not open it here, for three reasons: its errors do not show an absent device
//!   from one that is no port; a try of root that fails clears the mark (TIOCEXCL) of the program that holds the port; and its
//!   descriptor, which the real-time path needs, cannot be owned without `unsafe`.
//! - `wire`: poll(2) that waits for microseconds, reads and writes that never wait and allocate nothing; lines over sockets.

mod open;
mod places;
mod wire;

pub(crate) use open::{connect, open};
pub use places::Places;
pub(crate) use wire::Wire;
