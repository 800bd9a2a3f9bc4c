//! Codes of the wire in, named values out, and back.

macro_rules! open_codes {
    ($(#[$about:meta])* $name:ident { $($code:literal => $variant:ident $text:literal $doc:literal,)+ }) => {
        $(#[$about])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
        #[non_exhaustive]
        pub enum $name {
            $(#[doc = concat!(stringify!($code), ": ", $doc)] $variant,)+
            /// A code of a later protocol.
            Other(u8),
        }

        impl $name {
            /// From the wire.
            #[must_use]
            pub const fn from_code(code: u8) -> Self {
                match code {
                    $($code => Self::$variant,)+
                    other => Self::Other(other),
                }
            }

            /// To the wire.
            #[must_use]
            pub const fn code(self) -> u8 {
                match self {
                    $(Self::$variant => $code,)+
                    Self::Other(code) => code,
                }
            }

            /// Its name in output lines and JSON; `other` for a code of a later protocol.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $text,)+
                    Self::Other(_) => "other",
                }
            }
        }
    };
}

open_codes! {
    /// How far a slip has come.
    Phase {
        1 => Incipient "incipient" "shear and first movements, before the object slides.",
        2 => Gross "gross" "the object slides.",
        3 => Ended "ended" "the slip has ended.",
    }
}

open_codes! {
    /// Which method noticed a slip.
    Method {
        0 => None "none" "not known: at the end of a slip.",
        1 => Stylus "stylus" "the stylus.",
        2 => Travel "travel" "roller or encoder.",
        3 => Pressure "pressure" "the pressure distribution.",
    }
}

open_codes! {
    /// Where a slip speed comes from.
    SpeedSource {
        0 => None "none" "no speed is known.",
        1 => Fixed "fixed" "set in the configuration.",
        2 => Direct "direct" "a velocity channel.",
        3 => Travel "travel" "slope of the travel channel.",
        4 => TwoStyli "two_styli" "delay between two styli.",
        5 => Gravity "gravity" "balance of weight and friction.",
    }
}

open_codes! {
    /// A reading of E_sc.
    EscKind {
        0 => None "none" "no E_sc is known.",
        1 => Literal "literal" "as printed, in W.",
        2 => ArcCot "arc_cot" "cot read as an angle, in W.",
        3 => SlopePower "slope_power" "power to lift along the flanks, in W.",
        4 => LiftWork "lift_work" "work to lift over every irregularity, in J.",
        5 => ViscousWork "viscous_work" "what the damper of the stylus takes, in J.",
    }
}

open_codes! {
    /// What the grasp is doing.
    SceneCode {
        0 => Idle "idle" "nothing is held.",
        1 => Moving "moving" "arm or fingers move.",
        2 => Holding "holding" "an object is held.",
        3 => Slipping "slipping" "an object slips.",
    }
}

open_codes! {
    /// What the force controller does.
    GripStage {
        0 => Observing "observing" "there is none: the pipeline only observes.",
        1 => Open "open" "fingers open, no force.",
        2 => Closing "closing" "the force rises to the trial force.",
        3 => Settling "settling" "the trial force stands.",
        4 => Holding "holding" "an object is held.",
        5 => Slipping "slipping" "a slip is being stopped.",
        6 => Fault "fault" "the stylus cannot be trusted, the force stays.",
        7 => Released "released" "let go by a client, until it is told to grasp.",
    }
}

open_codes! {
    /// A sensor whose health is judged.
    Sensor {
        1 => Stylus "stylus" "the stylus.",
        2 => Travel "travel" "roller or encoder.",
        3 => Pressure "pressure" "the taxel array.",
        4 => Reference "reference" "the motion reference.",
    }
}

open_codes! {
    /// State of a sensor.
    SensorHealth {
        0 => Good "good" "nothing is wrong, or the gripper has no such sensor.",
        1 => Frozen "frozen" "always the same value.",
        2 => Saturated "saturated" "at the end of its range.",
        3 => Failed "failed" "too many readings that are none.",
        4 => Drifting "drifting" "wanders although nothing changes.",
        5 => Jumped "jumped" "leaps that no object makes.",
        6 => Backwards "backwards" "runs the other way.",
        7 => Lost "lost" "no readings.",
        8 => Doubted "doubted" "contradicted by another sensor.",
        9 => Coarse "coarse" "steps or noise too coarse to show an acceleration.",
        10 => Late "late" "another sensor shows the same at another time.",
        11 => Uncoupled "uncoupled" "other sensors show nothing of what it shows.",
    }
}

open_codes! {
    /// State of the link between daemon and gripper.
    LinkState {
        0 => Closed "closed" "no line, or the link has been closed.",
        1 => Open "open" "the line is open.",
        2 => Hello "hello" "the daemon asks who is there.",
        3 => Config "config" "limits are being agreed.",
        4 => Stream "stream" "samples come.",
        5 => Degraded "degraded" "the gripper is silent, or has lost the session.",
    }
}

open_codes! {
    /// State of the recording.
    Recording {
        0 => Off "off" "nothing is recorded.",
        1 => Running "running" "it grows.",
        2 => Stopped "stopped" "it was stopped by a failure; what was written stays.",
    }
}

open_codes! {
    /// What of real-time operation was granted.
    RealTime {
        0 => NotAsked "not asked" "it was not asked for.",
        1 => Granted "granted" "all of it.",
        2 => Partly "partly" "some of it.",
        3 => Refused "refused" "nothing of it.",
    }
}

open_codes! {
    /// What a NOTICE is about.
    NoticeKind {
        1 => Dropped "dropped" "frames for this client were dropped; code: what they held.",
        2 => Sensor "sensor" "the health of a sensor changed; code: the sensor, value: its health.",
        3 => Link "link" "something about the link; code: its state.",
        4 => Client "client" "a client's command was carried out; code: the operation.",
        5 => Goodbye "goodbye" "the daemon closes this connection; code: why.",
    }
}

open_codes! {
    /// What dropped frames held.
    DroppedClass {
        1 => Rows "rows" "samples.",
        2 => States "states" "state of the pipeline and figures of the daemon.",
        3 => News "news" "slips, notices and grippers.",
    }
}

open_codes! {
    /// Why the daemon closes a connection.
    Goodbye {
        1 => Version "version" "no protocol version in common.",
        2 => Silent "silent" "no SUBSCRIBE came in time.",
        3 => Stalled "stalled" "the client took nothing for too long.",
        4 => Garbage "garbage" "too many bytes that are no frames.",
        5 => Full "full" "too many clients.",
        6 => Ending "ending" "the daemon ends.",
    }
}

/// What a client wants done; the number is the code on the wire.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Operation {
    /// 1: hold with at least this force.
    AtLeast,
    /// 2: let go, until GRASP.
    Release,
    /// 3: close again after a release.
    Grasp,
    /// 4: stop in software, latched by the gripper; not a safety function.
    Stop,
    /// 5: clear the named fault.
    ClearFault,
}

impl Operation {
    /// From the wire.
    #[must_use]
    pub const fn from_code(code: u8) -> Option<Self> {
        Some(match code {
            1 => Self::AtLeast,
            2 => Self::Release,
            3 => Self::Grasp,
            4 => Self::Stop,
            5 => Self::ClearFault,
            _ => return None,
        })
    }

    /// To the wire.
    #[must_use]
    pub const fn code(self) -> u8 {
        match self {
            Self::AtLeast => 1,
            Self::Release => 2,
            Self::Grasp => 3,
            Self::Stop => 4,
            Self::ClearFault => 5,
        }
    }
}
