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
        0 cmd_id: u32, "+1 a command, wraps; older or equal is ignored", "Command number.";
        4 mode: u8, "`GripMode` code; others are rejected", "Mode, as it travels.";
        5 flags: u8, "others 0", "b0 answers a slip.";
        6 ttl_ms: u16, "ms, 0 = that of CONFIG, else clamped to 20..=100", "Life.";
        8 force_mn: i32, "mN, 0..= F_max; above is clamped, negative is rejected", "Force.";
        12 slew_mn_s: u32, "mN/s, 0 = that of CONFIG, above it is clamped", "Change of force.";
        16 cause_sample: u32, "", "Sample index that caused it.";
    }
}

impl Grip {
    /// Flag: the command answers a slip.
    pub const ANSWERS_SLIP: u8 = 1;
}

bits! {
    /// What the force guard did to the last command: a bit set.
    ForceClamp(u8) {
        0 FORCE "force over F_max.",
        1 SLEW "slew over that of CONFIG.",
        2 TTL "ttl outside 20..=100 ms.",
        3 REJECTED "the command was rejected: negative force, unknown mode or not armed.",
        4 HOLD_CAP "the hold cap limits the force.",
        5 TRAVEL "the fingers are at the end of their travel.",
    }
}

bits! {
    /// Flags of STATUS: a bit set.
    StatusFlags(u16) {
        0 SAMPLING "samples are being sent.",
        1 DROPPING "batches were dropped since the last STATUS.",
        2 PASSIVE "the torque is off.",
        3 OPEN "opening or open.",
        4 NO_COMMAND "no command was accepted since CONFIG; `last_cmd_id` and `age` mean nothing.",
        5 MOTION "the gripper reports its motion, so that a missing `MOVING` means standing still.",
        6 MOVING "the fingers travel without pressing on anything, or the gripper knows that the arm moves.",
    }
}

message! {
    /// STATUS (91), MCU to host: at least every 10 ms and after every GRIP.
    #[derive(Eq)]
    Status {
        0 last_cmd_id: u32, "", "cmd_id of the newest accepted GRIP.";
        4 state: DeviceState, "", "State.";
        5 clamp: ForceClamp, "", "What was clamped.";
        6 fault: FaultCode, "0 = none", "Latched fault.";
        8 applied_mn: i32, "mN", "Force set at the actuator now, or measured where the gripper can.";
        12 target_mn: i32, "mN", "Force aimed at.";
        16 age_us: u32, "us, saturates", "Age of the newest accepted GRIP.";
        20 flags: StatusFlags, "", "Flags.";
        22 rejected: u16, "wraps", "GRIPs rejected since the start.";
    }
}
