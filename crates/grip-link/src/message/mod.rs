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
//! | 92 | STATS | to host | 64 | | [`Stats`] |
//! | 93 | EVENT | to host | 20 | | [`Event`] |
//! | 94 | LOG | to host | 10 + text | | [`Log`] |
//! | A0..FF | | daemon and clients | | | not for the serial line: [`daemon`] |
//!
//! Payloads grow only by appending: a reader takes the bytes it knows and ignores what follows. A payload
//! shorter than its size is malformed: it is counted, and answered with NACK `Malformed` when ACK_REQ is set.

mod channel;
mod config;
mod control;
pub mod daemon;
mod grip;
mod ident;
mod report;
mod samples;

pub use channel::{Channel, Column, Layout, MAX_CHANNELS};
pub use config::{Clamped, Config, ConfigAck};
pub use control::{Ack, ClearFault, Heartbeat, Nack, Ping, Pong};
pub use grip::{ForceClamp, Grip, Status, StatusFlags};
pub use ident::{Firmware, Hello, Ident, Limits, Versions};
pub use report::{Event, Log, Stats};
pub use samples::{Row, Rows, SAMPLES_HEADER, Samples, SamplesHeader};
pub(crate) use slip_msg::wire;
pub use slip_msg::{
    ChannelKind, DeviceState, EventKind, FaultCode, GripMode, LogLevel, LossAction, NackReason,
    PayloadError, Reaction, ResetReason, SampleFormat, Unit,
};

use crate::frame::Frame;

/// A message type byte; the known ones are constants.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Kind(pub u8);

impl Kind {
    /// Host asks who is there.
    pub const HELLO: Self = Self(0x01);
    /// The gripper describes itself.
    pub const IDENT: Self = Self(0x81);
    /// Sampling and limits wanted.
    pub const CONFIG: Self = Self(0x03);
    /// Sampling and limits in force.
    pub const CONFIG_ACK: Self = Self(0x83);
    /// Send samples.
    pub const START: Self = Self(0x04);
    /// Send no more samples; the force rules go on.
    pub const STOP: Self = Self(0x05);
    /// Clock question.
    pub const PING: Self = Self(0x06);
    /// Clock answer.
    pub const PONG: Self = Self(0x86);
    /// Force set point.
    pub const GRIP: Self = Self(0x10);
    /// Health of the host's loop.
    pub const HEARTBEAT: Self = Self(0x11);
    /// Software stop, latched.
    pub const ESTOP: Self = Self(0x12);
    /// Releases one latched fault.
    pub const CLEAR_FAULT: Self = Self(0x13);
    /// Request carried out.
    pub const ACK: Self = Self(0x8E);
    /// Request refused.
    pub const NACK: Self = Self(0x8F);
    /// A batch of samples.
    pub const SAMPLES: Self = Self(0x90);
    /// State of the gripper.
    pub const STATUS: Self = Self(0x91);
    /// Link counters of the microcontroller.
    pub const STATS: Self = Self(0x92);
    /// Fault or change of state.
    pub const EVENT: Self = Self(0x93);
    /// Text.
    pub const LOG: Self = Self(0x94);
    /// First of the types between daemon and clients.
    pub const CLIENT_FIRST: Self = Self(0xA0);
    /// The daemon introduces itself to a client.
    pub const WELCOME: Self = Self(0xA0);
    /// A slip was noticed, became gross, or ended.
    pub const SLIP: Self = Self(0xA1);
    /// What the pipeline thinks.
    pub const STATE: Self = Self(0xA2);
    /// Figures of the daemon.
    pub const HEALTH: Self = Self(0xA3);
    /// Which gripper is there.
    pub const GRIPPER: Self = Self(0xA4);
    /// Samples as the pipeline got them.
    pub const ROWS: Self = Self(0xA5);
    /// Something a client should know: dropped frames, sensors, link, the end.
    pub const NOTICE: Self = Self(0xA6);
    /// A client says what it wants to hear.
    pub const SUBSCRIBE: Self = Self(0xA8);
    /// A client wants the gripper to do something.
    pub const COMMAND: Self = Self(0xA9);
    /// A client asks for everything known now.
    pub const QUERY: Self = Self(0xAA);

    /// Whether a microcontroller knows this type.
    #[must_use]
    pub const fn is_to_device(self) -> bool {
        matches!(
            self,
            Self::HELLO
                | Self::CONFIG
                | Self::START
                | Self::STOP
                | Self::PING
                | Self::GRIP
                | Self::HEARTBEAT
                | Self::ESTOP
                | Self::CLEAR_FAULT
        )
    }

    /// Whether a daemon knows this type from its clients.
    #[must_use]
    pub const fn is_to_daemon(self) -> bool {
        matches!(self, Self::SUBSCRIBE | Self::COMMAND | Self::QUERY)
    }

    /// Whether a client of the daemon knows this type.
    #[must_use]
    pub const fn is_to_client(self) -> bool {
        matches!(
            self,
            Self::WELCOME
                | Self::SLIP
                | Self::STATE
                | Self::HEALTH
                | Self::GRIPPER
                | Self::ROWS
                | Self::NOTICE
                | Self::ACK
                | Self::NACK
        )
    }

    /// Whether a host knows this type.
    #[must_use]
    pub const fn is_to_host(self) -> bool {
        matches!(
            self,
            Self::IDENT
                | Self::CONFIG_ACK
                | Self::PONG
                | Self::ACK
                | Self::NACK
                | Self::SAMPLES
                | Self::STATUS
                | Self::STATS
                | Self::EVENT
                | Self::LOG
        )
    }
}

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
