//! What the board and the host have in common, from readings of a sensor to slips and frames of the link.
#![cfg_attr(not(test), no_std)]

pub mod adxl345;
pub mod detector;
pub mod end;
pub mod float;
pub mod notice;
pub mod sensor;
