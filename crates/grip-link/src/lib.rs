//! The serial link between bytes and gripper messages, in both directions: framing, messages, both
//! link state machines and clock synchronisation.
//!
//! Nothing here opens a port or reads a clock: bytes and time are arguments. The crate is `no_std`,
//! allocates nothing and does not panic. [`host::HostLink`] is the computer's side,
//! [`device::DeviceLink`] the microcontroller's; both stand on [`decoder::Decoder`] and
//! [`frame::encode`]. The payload tables stand with the types in [`message`]; `protocol/SPEC.md` of the
//! repository specifies the link for other languages.
//!
#![doc = include_str!("../README.md")]
#![no_std]

pub mod clock;
pub mod cobs;
pub mod crc;
pub mod decoder;
pub mod device;
pub mod frame;
pub mod host;
mod kind;
pub mod message;

/// Protocol version spoken by this crate: the high nibble of the first body byte.
pub const PROTOCOL: u8 = 1;
