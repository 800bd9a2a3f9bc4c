//! Typed messages to and from payload bytes; every offset is fixed and little-endian.
//!
//! `protocol/MESSAGES.md` is printed from the tables here. Types A0..FF are not for the serial line: [`daemon`].
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

use slip_msg::{Field, Wire};

/// The messages that one side receives: a row a type and what its payload is.
macro_rules! received {
    (
        @made $wire:lifetime [$($life:lifetime)?]
        $(#[$about:meta])* $name:ident { $($code:ident => $variant:ident $(($payload:ty))?,)+ }
    ) => {
        $(#[$about])*
        #[derive(Debug, Clone, Copy, PartialEq)]
        pub enum $name $(<$life>)? {
            $(#[doc = concat!(stringify!($code), ".")] $variant $(($payload))?,)+
        }

        impl<$wire> $name $(<$life>)? {
            /// Reads the payload of a frame.
            ///
            /// # Errors
            /// [`PayloadError`] when the payload is too short, holds a value outside its range, or the type is unknown.
            pub fn parse(frame: &crate::frame::Frame<$wire>) -> Result<Self, PayloadError> {
                let payload = frame.payload;
                Ok(match frame.header.kind {
                    $(Kind::$code => Self::$variant $((<$payload>::parse(payload)?))?,)+
                    Kind(kind) => return Err(PayloadError::Kind { kind }),
                })
            }
        }
    };
    ($(#[$about:meta])* $name:ident<$life:lifetime> { $($rows:tt)+ }) => {
        received! { @made $life [$life] $(#[$about])* $name { $($rows)+ } }
    };
    ($(#[$about:meta])* $name:ident { $($rows:tt)+ }) => {
        received! { @made 'w [] $(#[$about])* $name { $($rows)+ } }
    };
}
use received;

received! {
    /// Every message to the microcontroller.
    ToDevice {
        HELLO => Hello(Hello),
        CONFIG => Config(Config),
        START => Start,
        STOP => Stop,
        PING => Ping(Ping),
        GRIP => Grip(Grip),
        HEARTBEAT => Heartbeat(Heartbeat),
        ESTOP => Estop,
        CLEAR_FAULT => ClearFault(ClearFault),
    }
}

macro_rules! payloads {
    ($($code:ident => $payload:ty),+ $(,)?) => {
        impl Kind {
            /// The fields of its payload, rows, channel table and the CONFIG of CONFIG_ACK left out.
            #[must_use]
            pub const fn fields(self) -> &'static [Field] {
                match self {
                    $(Self::$code => <$payload as Wire<'_>>::FIELDS,)+
                    _ => &[],
                }
            }
        }
    };
}

payloads! {
    HELLO => Hello, IDENT => IdentHead, CONFIG => Config, CONFIG_ACK => ConfigAckHead, PING => Ping, PONG => Pong,
    GRIP => Grip, HEARTBEAT => Heartbeat, CLEAR_FAULT => ClearFault, ACK => Ack, NACK => Nack,
    SAMPLES => SamplesHeader, STATUS => Status, STATS => Stats, EVENT => Event, LOG => Log<'_>,
    WELCOME => daemon::Welcome<'_>, SLIP => daemon::SlipReport, STATE => daemon::PipelineState,
    HEALTH => daemon::Health, GRIPPER => daemon::Gripper, ROWS => daemon::RowsHeader,
    NOTICE => daemon::Notice<'_>, SETUP => daemon::Setup<'_>, SUBSCRIBE => daemon::Subscribe,
    COMMAND => daemon::Command, LOAD => daemon::Load<'_>, OBJECT => daemon::Object<'_>,
    SHADOW => daemon::Load<'_>, ESTIMATES => daemon::Estimates,
}

impl Kind {
    /// Bytes of its payload without and with what was appended; text, rows and channels come on top.
    #[must_use]
    pub fn sizes(self) -> (usize, usize) {
        let (mut first, mut whole) = (0, 0);
        Field::each(self.fields(), &mut |Field { at, size, appended, .. }| {
            whole = at + size;
            first = if appended { first } else { whole };
        });
        (first, whole)
    }
}
