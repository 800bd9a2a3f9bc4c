//! Payload bytes in, typed messages out, and back; every offset is fixed and little-endian.
//!
//! Types, directions, sizes and answers stand on one screen in `protocol/SPEC.md`, chapter 4; fields follow from the tables here. Types
//! A0..FF are not for the serial line: [`daemon`].
//!
//! Payloads grow only by appending: a reader takes the bytes it knows and ignores what follows. A payload
//! shorter than its size is malformed: it is counted, and answered with NACK `Malformed` when ACK_REQ is set.

mod bits;
mod config;
mod control;
pub mod daemon;
mod grip;
mod ident;
mod report;
mod samples;

pub use config::{Clamped, Config, ConfigAck, ConfigAckHead};
pub use control::{Ack, ClearFault, Heartbeat, Nack, Ping, Pong};
pub use grip::{ForceClamp, Grip, Status, StatusFlags};
pub use ident::{
    Channel, Firmware, Hello, Ident, IdentHead, Limits, MAX_CHANNELS, MAX_ELEMENTS, Versions,
};
pub use report::{Event, Log, Stats};
pub use samples::{Column, Layout, Row, Rows, SAMPLES_HEADER, Samples, SamplesHeader};
pub(crate) use slip_msg::wire;
pub use slip_msg::{
    ChannelKind, DeviceState, EventKind, FaultCode, GripMode, LogLevel, LossAction, NackReason,
    PayloadError, Reaction, ResetReason, SampleFormat, Unit,
};

pub use crate::kind::Kind;

use crate::frame::Frame;

/// Every message to the microcontroller.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ToDevice {
    /// 01
    Hello(Hello),
    /// 03
    Config(Config),
    /// 04
    Start,
    /// 05
    Stop,
    /// 06
    Ping(Ping),
    /// 10
    Grip(Grip),
    /// 11
    Heartbeat(Heartbeat),
    /// 12
    Estop,
    /// 13
    ClearFault(ClearFault),
}

impl ToDevice {
    /// Reads the payload of a frame.
    ///
    /// # Errors
    /// [`PayloadError`] when the payload is too short, holds a value outside its range, or the type is unknown.
    pub fn parse(frame: &Frame<'_>) -> Result<Self, PayloadError> {
        let payload = frame.payload;
        Ok(match frame.header.kind {
            Kind::HELLO => Self::Hello(Hello::parse(payload)?),
            Kind::CONFIG => Self::Config(Config::parse(payload)?),
            Kind::START => Self::Start,
            Kind::STOP => Self::Stop,
            Kind::PING => Self::Ping(Ping::parse(payload)?),
            Kind::GRIP => Self::Grip(Grip::parse(payload)?),
            Kind::HEARTBEAT => Self::Heartbeat(Heartbeat::parse(payload)?),
            Kind::ESTOP => Self::Estop,
            Kind::CLEAR_FAULT => Self::ClearFault(ClearFault::parse(payload)?),
            Kind(kind) => return Err(PayloadError::Kind { kind }),
        })
    }
}
