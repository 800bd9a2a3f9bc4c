//! Codes of pipeline, gripper, daemon and clients, except for faults (`fault`): number, name and meaning.

use crate::table::codes;

codes! {
    /// What the gripper is doing, as far as the pipeline is concerned.
    #[derive(Default)]
    open Scene {
        #[default]
        0 => Idle "idle" "nothing is held.",
        1 => Moving "moving" "arm or fingers move: own vibration, no decision on slip.",
        2 => Holding "holding" "an object is held.",
        3 => Slipping "slipping" "an object slips.",
    }

    /// What the force controller does.
    #[derive(Default)]
    open GripState {
        absent #[default] 0 => Observing "observing" "there is none: the pipeline only observes.",
        1 => Open "open" "fingers open, no force.",
        2 => Closing "closing" "the force rises to the trial force.",
        3 => Settling "settling" "the trial force stands; contact transients fade.",
        4 => Holding "holding" "an object is held.",
        5 => Slipping "slipping" "a slip is being stopped.",
        6 => Fault "fault" "no slip sensor can be trusted, the force stays.",
        7 => Released "released" "let go by a client, until it is asked to grasp.",
        8 => Lost "lost" "nothing is touched any more: the object is gone, the force stays.",
    }

    /// How far a slip has come.
    open Phase {
        1 => Incipient "incipient" "shear and first movements, before the object slides.",
        2 => Gross "gross" "the object slides.",
        3 => Ended "ended" "the slip has ended.",
    }

    /// A way to notice a slip.
    open Method {
        absent 0 => None "none" "not known: at the end of a slip.",
        1 => Stylus "stylus" "vibration of the stylus.",
        2 => Travel "travel" "moved distance of the object, from a roller or an encoder.",
        3 => Pressure "pressure" "change of the pressure distribution under the finger.",
    }

    /// Where a slip speed comes from.
    open SpeedSource {
        absent 0 => None "none" "no speed is known.",
        1 => Fixed "fixed" "set in the configuration.",
        2 => Direct "direct" "a velocity channel.",
        3 => Travel "travel" "slope of the travel channel.",
        4 => TwoStyli "two_styli" "delay between two styli.",
        5 => Gravity "gravity" "acceleration by weight since the first notice.",
    }

    /// A reading of the scattered energy of vibration.
    ///
    /// The printed equation gives a power and a periodic function of the ratios. The others are what its terms can mean
    /// physically; for shallow irregularities, mean slope power times contact time is twice the lift work:
    /// SlopePower / n x T = 2 LiftWork with T = sum s / v of n equal irregularities.
    #[derive(Default)]
    open Reading {
        absent 0 => None "none" "no E_sc is known.",
        #[default]
        1 => Literal "literal" "n F v tan(sum cot(delta/s)) (W), as printed.",
        2 => ArcCot "arc_cot" "n F v tan(sum arccot(delta/s)) (W): cot read as the angle whose cotangent is delta/s.",
        3 => SlopePower "slope_power" "F v sum 2 delta/s (W): power to lift along the flanks; n F v tan(mean flank angle) to second order.",
        4 => LiftWork "lift_work" "F sum delta (J): work to lift over every irregularity once.",
        5 => ViscousWork "viscous_work" "(pi^2/2) c v sum delta^2/s (J): what the damper c of the stylus takes at speed v over sinusoidal irregularities.",
    }

    /// A sensor whose health is judged.
    open Sensor {
        1 => Stylus "stylus" "the stylus.",
        2 => Travel "travel" "roller or encoder.",
        3 => Pressure "pressure" "the taxel array.",
        4 => Reference "reference" "the motion reference.",
    }

    /// State of a sensor.
    #[derive(Default)]
    open SensorHealth {
        #[default]
        0 => Good "good" "nothing is wrong; without a daemon also: no such sensor.",
        1 => Frozen "frozen" "always the same value: a broken wire or a hung converter.",
        2 => Saturated "saturated" "at the end of its range.",
        3 => Failed "failed" "too many readings that are none.",
        4 => Drifting "drifting" "moves further than a change of grip force explains.",
        5 => Jumped "jumped" "leaps farther than any object can move.",
        6 => Backwards "backwards" "runs the other way.",
        7 => Lost "lost" "no readings, where there were some before.",
        8 => Doubted "doubted" "contradicted by another sensor.",
        9 => Coarse "coarse" "steps or noise too coarse to show an acceleration.",
        10 => Late "late" "another sensor shows the same at another time: a motion reference is late or early.",
        11 => Uncoupled "uncoupled" "other sensors show nothing of what it shows: a motion reference of another robot.",
        12 => Absent "absent" "the gripper sends nothing of such a sensor.",
    }

    /// State of the link between daemon and gripper.
    #[derive(Default)]
    open LinkState {
        #[default]
        0 => Closed "closed" "no line, or the link has been closed.",
        1 => Open "open" "the line is open, nothing is written yet.",
        2 => Hello "hello" "the daemon asks who is there.",
        3 => Config "config" "gripper known; limits and sampling not agreed, or sampling stopped.",
        4 => Stream "stream" "samples come.",
        5 => Degraded "degraded" "samples are stale or have a gap: the force is not raised.",
    }

    /// State of the recording.
    #[derive(Default)]
    open Recording {
        #[default]
        0 => Off "off" "nothing is recorded.",
        1 => Running "running" "it grows.",
        2 => Stopped "stopped" "it was stopped by a failure; what was written stays.",
    }

    /// What of real-time operation was granted.
    open RealTime {
        0 => NotAsked "not asked" "it was not asked for.",
        1 => Granted "granted" "all of it.",
        2 => Partly "partly" "some of it.",
        3 => Refused "refused" "nothing of it.",
    }

    /// What a NOTICE is about.
    open NoticeKind {
        1 => Dropped "dropped" "frames for this client were dropped; code: what they held.",
        2 => Sensor "sensor" "the health of a sensor changed; code: the sensor, value: its health.",
        3 => Link "link" "something about the link; code: its state.",
        4 => Client "client" "a client's command was carried out; code: the operation.",
        5 => Goodbye "goodbye" "the daemon closes this connection; code: why.",
        6 => Object "object" "what is known of the object in hand or next; count: grasps that have shown it.",
    }

    /// What dropped frames held.
    open DroppedClass {
        1 => Rows "rows" "samples.",
        2 => States "states" "state of the pipeline and figures of the daemon.",
        3 => News "news" "slips, notices and grippers.",
    }

    /// Why the daemon closes a connection.
    open Goodbye {
        1 => Version "version" "no protocol version in common.",
        2 => Silent "silent" "no SUBSCRIBE came in time.",
        3 => Stalled "stalled" "the client took nothing for too long.",
        4 => Garbage "garbage" "too many bytes that are no frames, or no SUBSCRIBE came first.",
        5 => Full "full" "too many clients.",
        6 => Ending "ending" "the daemon ends.",
    }

    /// State of the microcontroller.
    open DeviceState {
        0 => Boot "boot" "starting; actuator passive, link deaf.",
        1 => Idle "idle" "waits for HELLO.",
        2 => Linked "linked" "session open, no CONFIG.",
        3 => Armed "armed" "CONFIG in force, no GRIP yet.",
        4 => Active "active" "a fresh GRIP is followed.",
        5 => Hold "hold" "the last GRIP is older than its ttl.",
        6 => LossAction "loss_action" "the loss action was taken; a new CONFIG is needed.",
        7 => Fault "fault" "a fault is latched.",
        8 => Estop "estop" "a stop is latched.",
    }

    /// Why the microcontroller started.
    open ResetReason {
        0 => Unknown "unknown" "not known.",
        1 => PowerOn "power_on" "power came on.",
        2 => Pin "pin" "reset pin, or the port was opened.",
        3 => Watchdog "watchdog" "watchdog.",
        4 => Software "software" "the firmware asked for it.",
        5 => Brownout "brownout" "supply voltage too low.",
    }

    /// What a channel measures.
    open ChannelKind {
        1 => Stylus "stylus" "displacement of the stylus. In any other unit it is a vibration, for example of an accelerometer in the finger: slips are found, heights are not known.",
        2 => NormalForce "normal_force" "normal force.",
        3 => TangentialForce "tangential_force" "tangential force.",
        4 => Travel "travel" "moved distance of the object, from a roller or encoder.",
        5 => Velocity "velocity" "speed of the object.",
        6 => SecondStylus "second_stylus" "displacement of a second stylus.",
        7 => Reference "reference" "motion reference: accelerometer on gripper or arm.",
        8 => Pressure "pressure" "contact pressure.",
        9 => PressureArray "pressure_array" "contact pressures, `count` elements a row.",
    }

    /// Unit of a channel after scaling.
    open Unit {
        absent 0 => None "none" "a bare number, uncalibrated.",
        1 => Metre "m" "m.",
        2 => Newton "N" "N.",
        3 => MetrePerSecond "m/s" "m/s.",
        4 => MetrePerSecond2 "m/s2" "m/s2.",
        5 => Pascal "Pa" "Pa.",
    }

    /// What happened on the microcontroller.
    open EventKind {
        1 => State "state" "the state changed; `value` 0.",
        2 => Fault "fault" "a fault was latched; `value` is its code, also beneath an ESTOP.",
        3 => FaultCleared "fault_cleared" "a fault was cleared; `value` is its code.",
        4 => CommandRejected "command_rejected" "a GRIP was rejected; `value` is its force in mN.",
    }

    /// Why a request was refused.
    open NackReason {
        1 => UnknownType "unknown_type" "the type is not known.",
        2 => Malformed "malformed" "payload too short, a value outside its range, or no channel left.",
        3 => WrongState "wrong_state" "START without CONFIG; RELEASE or GRASP of a client while no gripper streams.",
        4 => Latched "latched" "CONFIG, or RELEASE or GRASP of a client, while a fault or stop is latched.",
        5 => OtherFault "other_fault" "CLEAR_FAULT named another fault than the latched one.",
        6 => Version "version" "kept for later; a device of version 1 answers a HELLO of other versions with IDENT.",
        7 => Forbidden "forbidden" "daemon only: the configuration does not allow commands of clients.",
        8 => Token "token" "daemon only: RELEASE without the token of WELCOME.",
        9 => Busy "busy" "daemon only: too many commands wait.",
    }

    /// How serious a line of LOG is.
    open LogLevel {
        0 => Error "error" "something failed.",
        1 => Warn "warn" "something is odd.",
        2 => Info "info" "good to know.",
        3 => Debug "debug" "for developers.",
    }
}

codes! {
    /// What a client wants done.
    closed Operation {
        1 => AtLeast "at_least" "hold with at least `force_mn`, within the limits; the answer to a slip stays free to press harder.",
        2 => Release "release" "let go: the fingers open until GRASP.",
        3 => Grasp "grasp" "close again after a release.",
        4 => Stop "stop" "stop in software, latched by the gripper; not a safety function.",
        5 => ClearFault "clear_fault" "clear the fault `fault`.",
        6 => Expect "expect" "the next objects are known to be held with `force_mn`, margin included: grasp them with that; 0: nothing is known.",
    }

    /// How the elements of a row stand in SAMPLES.
    closed SampleFormat {
        0 => I16 "i16" "steps of `scale`; -32768 = no reading.",
        1 => F32 "f32" "the unit itself; NaN = no reading.",
    }

    /// What a GRIP asks for; 0 is no mode.
    closed GripMode {
        1 => Force "force" "press with `force_mn`.",
        2 => Open "open" "open the fingers.",
        3 => Passive "passive" "torque off.",
    }

    /// What the gripper does when no command came for ttl + `loss_after`.
    closed LossAction {
        0 => Hold "hold" "go on holding.",
        1 => Open "open" "open the fingers.",
        2 => Passive "passive" "torque off.",
    }
}

impl Reading {
    /// The formula in plain text; empty where there is no reading.
    #[must_use]
    pub const fn formula(self) -> &'static str {
        match self {
            Self::Literal => "n F v tan(sum cot(delta/s))",
            Self::ArcCot => "n F v tan(sum arccot(delta/s))",
            Self::SlopePower => "F v sum 2 delta/s",
            Self::LiftWork => "F sum delta",
            Self::ViscousWork => "(pi^2/2) c v sum delta^2/s",
            Self::None | Self::Other(_) => "",
        }
    }

    /// The symbol of its unit: `W` or `J`.
    #[must_use]
    pub const fn unit(self) -> &'static str {
        match self {
            Self::LiftWork | Self::ViscousWork => "J",
            _ => "W",
        }
    }
}

impl Method {
    /// What a sentence calls it: a stylus and every other sensor of its kind feel vibration.
    #[must_use]
    pub const fn felt(self) -> &'static str {
        if let Self::Stylus = self { "vibration" } else { self.name() }
    }
}

impl LinkState {
    /// Whether samples come.
    #[must_use]
    pub const fn streams(self) -> bool {
        matches!(self, Self::Stream | Self::Degraded)
    }
}

impl ChannelKind {
    /// The unit that the channel is meant to have.
    #[must_use]
    pub const fn unit(self) -> Unit {
        match self {
            Self::Stylus | Self::Travel | Self::SecondStylus => Unit::Metre,
            Self::NormalForce | Self::TangentialForce => Unit::Newton,
            Self::Velocity => Unit::MetrePerSecond,
            Self::Reference => Unit::MetrePerSecond2,
            Self::Pressure | Self::PressureArray => Unit::Pascal,
            Self::Other(_) => Unit::None,
        }
    }
}

impl SampleFormat {
    /// Bytes of one element.
    #[must_use]
    pub const fn size(self) -> usize {
        match self {
            Self::I16 => 2,
            Self::F32 => 4,
        }
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::{DeviceState, Method, Operation, Reading};
    use std::string::String;

    #[test]
    fn codes_and_names_come_back_and_codes_of_later_protocols_are_kept() {
        for code in 0..=255 {
            assert_eq!(Reading::from_code(code).code(), code);
            assert!(Operation::from_code(code).is_none_or(|operation| operation.code() == code));
        }
        for reading in Reading::ALL {
            assert_eq!(Reading::from_name(reading.name()), Some(reading));
        }
        assert_eq!(Reading::from_name("lift-work"), Some(Reading::LiftWork));
        assert_eq!((Reading::from_name("none"), Reading::Other(9).name()), (None, "other"));
        assert_eq!((Method::ALL.len(), Method::TABLE.len()), (3, 4), "no method is none of them");
    }

    #[test]
    fn constants_of_other_languages_follow_the_names() {
        let names: [String; 2] = [6, 8].map(|row| DeviceState::TABLE[row].constant().collect());
        assert_eq!(names, ["LOSS_ACTION", "ESTOP"]);
    }
}
