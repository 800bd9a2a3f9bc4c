//! Payloads between daemon and clients in, typed messages out, and back: what a socket carries in the same frames as the line.
//!
//! Types, sizes and answers stand on one screen in `protocol/SPEC.md`, chapter 16.
//!
//! Direction bit, session, seq, ACK and NACK are those of the line, with the client in the place of the host's line partner: frames
//! of the daemon bear the bit "to host". Values of the pipeline are f32 in SI units, NaN for what is not known; forces that a
//! client asks for are whole mN, as on the line, so that nothing but a number can be asked for.

mod command;
mod greet;
mod gripper;
mod model;
mod notice;
mod rows;

pub use command::{Command, Object};
pub use greet::{Subscribe, Topics, Welcome, WelcomeFlags};
pub use gripper::Gripper;
pub use model::{Estimates, Load, Setup, Unsure};
pub use notice::Notice;
pub use rows::{ROWS_HEADER, RowOfSample, RowSet, Rows, RowsHeader};
pub use slip_msg::{
    Appended, BadFrames, ClockOffset, Dropped, DroppedClass, EXTRAPOLATED, Goodbye, GripState,
    Health, INFORMATIVE, Latency, LinkState, Method, NoticeKind, Operation, Phase, PipelineState,
    Reading, RealTime, Recording, Scene, Sensor, SensorHealth, SlipReport, SpeedSource,
};

use super::{Ack, Kind, Nack, PayloadError};
use crate::frame::Frame;

/// Every message to a client.
#[derive(Debug, Clone, Copy, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "one lives at a time, and nothing here allocates")]
pub enum ToClient<'a> {
    /// A0
    Welcome(Welcome<'a>),
    /// A1
    Slip(SlipReport),
    /// A2
    State(PipelineState),
    /// A3
    Health(Health),
    /// A4
    Gripper(Gripper),
    /// A5
    Rows(Rows<'a>),
    /// A6
    Notice(Notice<'a>),
    /// A7
    Setup(Setup<'a>),
    /// AE
    Estimates(Estimates),
    /// 8E
    Ack(Ack),
    /// 8F
    Nack(Nack),
}

impl<'a> ToClient<'a> {
    /// Reads the payload of a frame.
    ///
    /// # Errors
    /// [`PayloadError`] when the payload is too short, holds a value outside its range, or the type is unknown.
    pub fn parse(frame: &Frame<'a>) -> Result<Self, PayloadError> {
        let payload = frame.payload;
        Ok(match frame.header.kind {
            Kind::WELCOME => Self::Welcome(Welcome::parse(payload)?),
            Kind::SLIP => Self::Slip(SlipReport::parse(payload)?),
            Kind::STATE => Self::State(PipelineState::parse(payload)?),
            Kind::HEALTH => Self::Health(Health::parse(payload)?),
            Kind::GRIPPER => Self::Gripper(Gripper::parse(payload)?),
            Kind::ROWS => Self::Rows(Rows::parse(payload)?),
            Kind::NOTICE => Self::Notice(Notice::parse(payload)?),
            Kind::SETUP => Self::Setup(Setup::parse(payload)?),
            Kind::ESTIMATES => Self::Estimates(Estimates::parse(payload)?),
            Kind::ACK => Self::Ack(Ack::parse(payload)?),
            Kind::NACK => Self::Nack(Nack::parse(payload)?),
            Kind(kind) => return Err(PayloadError::Kind { kind }),
        })
    }
}

/// Every message to the daemon.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ToDaemon<'a> {
    /// A8
    Subscribe(Subscribe),
    /// A9
    Command(Command),
    /// AA
    Query,
    /// AB
    Load(Load<'a>),
    /// AC
    Object(Object<'a>),
    /// AD
    Shadow(Load<'a>),
}

impl<'a> ToDaemon<'a> {
    /// Reads the payload of a frame.
    ///
    /// # Errors
    /// [`PayloadError`] when the payload is too short, holds a value outside its range, or the type is unknown.
    pub fn parse(frame: &Frame<'a>) -> Result<Self, PayloadError> {
        Ok(match frame.header.kind {
            Kind::SUBSCRIBE => Self::Subscribe(Subscribe::parse(frame.payload)?),
            Kind::COMMAND => Self::Command(Command::parse(frame.payload)?),
            Kind::QUERY => Self::Query,
            Kind::LOAD => Self::Load(Load::parse(frame.payload)?),
            Kind::OBJECT => Self::Object(Object::parse(frame.payload)?),
            Kind::SHADOW => Self::Shadow(Load::parse(frame.payload)?),
            Kind(kind) => return Err(PayloadError::Kind { kind }),
        })
    }
}

/// The text up to the first byte that is not UTF-8.
fn readable(text: &[u8]) -> &str {
    text.utf8_chunks().next().map_or("", |chunk| chunk.valid())
}
