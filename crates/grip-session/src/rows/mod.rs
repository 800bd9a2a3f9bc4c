//! Rows of numbers that another program sends, as frames of the link: a program with samples, as a board with sensors.
//!
//! A header of one line names columns and rate, `vibration,force_n,rate=1600`. Rows follow, as CSV or as packed f32. A
//! [`RowBoard`] answers the host as a device does, so that nothing else knows where the samples come from.

mod board;
mod clock;
mod cut;
mod header;

pub use board::{
    Actuator, BoardOptions, GripperForce, GripperReading, RowBoard, RowCounters, RowsError,
};
pub use cut::{CutError, RowCutter};
pub use header::{Header, HeaderError, RowFormat};
