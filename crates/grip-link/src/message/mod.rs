//! Payload bytes in, typed messages out, and back; every offset is fixed and little-endian.
//!
//! | type | name | direction | size | ACK_REQ | type in Rust |
//! |---|---|---|---|---|---|
//! | 01 | HELLO | to MCU | 16 | yes: IDENT | [`Hello`] |
//! | 81 | IDENT | to host | 72 + 8 a channel | | [`Ident`] |
//! | 03 | CONFIG | to MCU | 28 | yes: CONFIG_ACK | [`Config`] |
//! | 83 | CONFIG_ACK | to host | 36 | | [`ConfigAck`] |
//! | 04 | START | to MCU | 0 | yes | |
//! | 05 | STOP | to MCU | 0 | yes | |
//! | 06 | PING | to MCU | 8 | | [`Ping`] |
//! | 86 | PONG | to host | 24 | | [`Pong`] |
//! | 10 | GRIP | to MCU | 20 | | [`Grip`] |
//! | 11 | HEARTBEAT | to MCU | 12 | | [`Heartbeat`] |
//! | 12 | ESTOP | to MCU, session 0 | 0 | yes | |
//! | 13 | CLEAR_FAULT | to MCU | 2 | yes | [`ClearFault`] |
//! | 8E | ACK | to host | 4 | | [`Ack`] |
//! | 8F | NACK | to host | 4 | | [`Nack`] |
//! | 90 | SAMPLES | to host | 20 + rows | | [`Samples`] |
//! | 91 | STATUS | to host | 24 | | [`Status`] |
//! | 92 | STATS | to host | 76 | | [`Stats`] |
//! | 93 | EVENT | to host | 20 | | [`Event`] |
//! | 94 | LOG | to host | 10 + text | | [`Log`] |
//! | A0..FF | | daemon and clients | | | not for the serial line: [`daemon`] |
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

pub use config::{Clamped, Config, ConfigAck};
pub use control::{Ack, ClearFault, Heartbeat, Nack, Ping, Pong};
pub use grip::{ForceClamp, Grip, Status, StatusFlags};
pub use ident::{Channel, Firmware, Hello, Ident, Limits, MAX_CHANNELS, MAX_ELEMENTS, Versions};
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
