//! Typed messages between daemon and clients, to and from payloads: what a socket carries in the same frames as the line.
//!
//! `protocol/CLIENTS.md` has the rules.
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

use super::{Ack, Kind, Nack, PayloadError, received};

received! {
    /// Every message to a client.
    ToClient<'a> {
        WELCOME => Welcome(Welcome<'a>),
        SLIP => Slip(SlipReport),
        STATE => State(PipelineState),
        HEALTH => Health(Health),
        GRIPPER => Gripper(Gripper),
        ROWS => Rows(Rows<'a>),
        NOTICE => Notice(Notice<'a>),
        SETUP => Setup(Setup<'a>),
        ESTIMATES => Estimates(Estimates),
        ACK => Ack(Ack),
        NACK => Nack(Nack),
    }
}

received! {
    /// Every message to the daemon.
    #[derive(Eq)]
    ToDaemon<'a> {
        SUBSCRIBE => Subscribe(Subscribe),
        COMMAND => Command(Command),
        QUERY => Query,
        LOAD => Load(Load<'a>),
        OBJECT => Object(Object<'a>),
        SHADOW => Shadow(Load<'a>),
    }
}

/// The text up to the first byte that is not UTF-8.
fn readable(text: &[u8]) -> &str {
    text.utf8_chunks().next().map_or("", |chunk| chunk.valid())
}
