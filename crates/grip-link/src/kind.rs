//! The type byte of a message, which frames carry.

use slip_msg::wire::{Reader, Writer};
use slip_msg::{PayloadError, Wire};

/// A message type byte; the known ones are constants.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Kind(pub u8);

macro_rules! kinds {
    ($($code:literal $name:ident: $($to:ident)+, $doc:literal;)+) => {
        impl Kind {
            $(#[doc = $doc] pub const $name: Self = Self($code);)+
            /// Every type, by its name.
            pub const ALL: &[(&str, Self)] = &[$((stringify!($name), Self::$name)),+];

            /// What it is, in a sentence; empty of a type that is not known.
            #[must_use]
            pub const fn about(self) -> &'static str {
                match self {
                    $(Self::$name => $doc,)+
                    _ => "",
                }
            }

            /// Who knows it, as bits.
            const fn to(self) -> u8 {
                match self {
                    $(Self::$name => 0 $(| Self::$to)+,)+
                    _ => 0,
                }
            }
        }
    };
}

kinds! {
    0x01 HELLO: DEVICE, "Host asks who is there.";
    0x81 IDENT: HOST, "The gripper describes itself.";
    0x03 CONFIG: DEVICE, "Sampling and limits wanted.";
    0x83 CONFIG_ACK: HOST, "Sampling and limits in force.";
    0x04 START: DEVICE, "Send samples.";
    0x05 STOP: DEVICE, "Send no more samples; the force rules go on.";
    0x06 PING: DEVICE, "Clock question.";
    0x86 PONG: HOST, "Clock answer.";
    0x10 GRIP: DEVICE, "Force set point.";
    0x11 HEARTBEAT: DEVICE, "Health of the host's loop.";
    0x12 ESTOP: DEVICE, "Software stop, latched.";
    0x13 CLEAR_FAULT: DEVICE, "Releases one latched fault.";
    0x8E ACK: HOST CLIENT, "Request carried out.";
    0x8F NACK: HOST CLIENT, "Request refused.";
    0x90 SAMPLES: HOST, "A batch of samples.";
    0x91 STATUS: HOST, "State of the gripper.";
    0x92 STATS: HOST, "Link counters of the microcontroller.";
    0x93 EVENT: HOST, "Fault or change of state.";
    0x94 LOG: HOST, "Text.";
    0xA0 WELCOME: CLIENT, "The daemon introduces itself to a client.";
    0xA1 SLIP: CLIENT, "A slip was noticed, became gross, or ended.";
    0xA2 STATE: CLIENT, "What the pipeline thinks.";
    0xA3 HEALTH: CLIENT, "Numbers of the daemon.";
    0xA4 GRIPPER: CLIENT, "Which gripper is there.";
    0xA5 ROWS: CLIENT, "Samples as the pipeline got them.";
    0xA6 NOTICE: CLIENT, "Something a client should know: dropped frames, sensors, link, the end.";
    0xA7 SETUP: CLIENT, "What the daemon works with: firmware, models, settings.";
    0xA8 SUBSCRIBE: DAEMON, "A client asks for topics.";
    0xA9 COMMAND: DAEMON, "A client wants the gripper to do something.";
    0xAA QUERY: DAEMON, "A client asks for everything known now.";
    0xAB LOAD: DAEMON, "A client brings a piece of a model.";
    0xAC OBJECT: DAEMON, "A client names the next object.";
    0xAD SHADOW: DAEMON, "A client brings a piece of a model that estimates beside the one in force.";
    0xAE ESTIMATES: CLIENT, "What two models made of a slip.";
}

impl Kind {
    const DEVICE: u8 = 1;
    const HOST: u8 = 2;
    const DAEMON: u8 = 4;
    const CLIENT: u8 = 8;

    /// Whether a microcontroller knows this type.
    #[must_use]
    pub const fn is_to_device(self) -> bool {
        self.to() & Self::DEVICE != 0
    }

    /// Whether a daemon knows this type from its clients.
    #[must_use]
    pub const fn is_to_daemon(self) -> bool {
        self.to() & Self::DAEMON != 0
    }

    /// Whether a client of the daemon knows this type.
    #[must_use]
    pub const fn is_to_client(self) -> bool {
        self.to() & Self::CLIENT != 0
    }

    /// Whether a host knows this type.
    #[must_use]
    pub const fn is_to_host(self) -> bool {
        self.to() & Self::HOST != 0
    }
}

impl<'a> Wire<'a> for Kind {
    const SIZE: usize = 1;
    const TYPE: &'static str = "u8";

    fn read(r: &mut Reader<'a>) -> Result<Self, PayloadError> {
        r.u8().map(Self)
    }

    fn append(self, w: Writer<'_>) -> Writer<'_> {
        w.u8(self.0)
    }
}
