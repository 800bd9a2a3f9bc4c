//! COMMAND: a client wants the gripper to do something.

use super::Operation;
use crate::message::FaultCode;
use slip_msg::message;

message! {
    /// COMMAND (A9), client to daemon.
    #[derive(Eq)]
    Command {
        0 operation: Operation, "an unknown one is malformed", "What to do.", reserved 1;
        2 fault: FaultCode, "", "The fault to clear, of `ClearFault`.";
        4 force_mn: i32, "mN, not negative", "The force to hold with, of `AtLeast`.", in 0..;
        8 token: u32, "", "That of WELCOME, of `Release`.";
    }
}

impl Command {
    /// An operation without force, fault and token.
    #[must_use]
    pub const fn new(operation: Operation) -> Self {
        Self { operation, fault: FaultCode::NONE, force_mn: 0, token: 0 }
    }
}
