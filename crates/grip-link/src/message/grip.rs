//! GRIP and STATUS: the force wanted and the force that is.

use super::DeviceState;
use super::FaultCode;
use super::bits::bits;
use slip_msg::message;

message! {
    /// GRIP (10), host to MCU: an absolute set point, sent every cycle. Not acknowledged: STATUS.last_cmd_id states what
    /// arrived. Values outside their range are judged by the force guard of the MCU.
    #[derive(Eq)]
    Grip {
        0 cmd_id: u32, "+1 a command, wraps; not newer = ignored: newer means (`cmd_id` - last) mod 2^32 in 1 .. 2^31 - 1", "Command number.";
        4 mode: u8, "grip mode; an unknown one is rejected", "Mode, as it travels.";
        5 flags: u8, "b0 the command answers a slip; others 0 and ignored", "b0 answers a slip.";
        6 ttl_ms: u16, "ms; 0 = that of CONFIG, else clamped to 20..100", "Life.";
        8 force_mn: i32, "mN; above F_max is clamped; negative is rejected, in every mode", "Force.";
        12 slew_mn_s: u32, "mN/s; 0 = that of CONFIG; above that is clamped", "Change of force.";
        16 cause_sample: u32, "number of the row that led to the command; for the record", "Sample index that caused it.";
    }
}

impl Grip {
    /// Flag: the command answers a slip.
    pub const ANSWERS_SLIP: u8 = 1;
}

bits! {
    /// What the force guard did to the last command: a bit set.
    ForceClamp(u8) {
        0 FORCE "force above F_max.",
        1 SLEW "slew above that of CONFIG.",
        2 TTL "ttl not 0 and outside 20..100 ms.",
        3 REJECTED "a GRIP was rejected.",
        4 HOLD_CAP "the hold cap lowered the force.",
        5 TRAVEL "the fingers are outside their travel, the force may not rise.",
    }
}

bits! {
    /// Flags of STATUS: a bit set.
    StatusFlags(u16) {
        0 SAMPLING "between START and STOP.",
        1 DROPPING "rows were dropped since the last STATUS.",
        2 PASSIVE "torque off.",
        3 OPEN "opening or open.",
        4 NO_COMMAND "no GRIP accepted since CONFIG: `last_cmd_id` is 0, `age_us` is 4294967295.",
        5 MOTION "the device reports its motion: without MOVING it stands still; not set = nothing is known of motion.",
        6 MOVING "the fingers travel without pressing on anything, or the device knows that the arm moves.",
    }
}

message! {
    /// STATUS (91), MCU to host: at least every 10 ms and after every GRIP.
    #[derive(Eq)]
    Status {
        0 last_cmd_id: u32, "newest accepted GRIP since CONFIG", "cmd_id of the newest accepted GRIP.";
        4 state: DeviceState, "device state", "State.";
        5 clamp: ForceClamp, "clamp bits", "What was clamped.";
        6 fault: FaultCode, "latched fault, 0 = none; ESTOP hides another", "Latched fault.";
        8 applied_mn: i32, "mN, force measured where the gripper can, else the force set at the actuator now; a measurement may be negative", "Force set at the actuator now, or measured where the gripper can.";
        12 target_mn: i32, "mN, force aimed at; 0 when passive or open", "Force aimed at.";
        16 age_us: u32, "us since the newest accepted GRIP, saturates", "Age of the newest accepted GRIP.";
        20 flags: StatusFlags, "status flags", "Flags.";
        22 rejected: u16, "GRIPs rejected since the start, wraps", "GRIPs rejected since the start.";
    }
}
