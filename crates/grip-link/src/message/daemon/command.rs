//! COMMAND and OBJECT: what a client wants the gripper to do, and with what.

use super::Operation;
use crate::message::FaultCode;
use slip_msg::message;

message! {
    /// COMMAND (A9), client to daemon.
    #[derive(Eq)]
    Command {
        0 operation: Operation, "an unknown one is malformed", "What to do.", reserved 1;
        2 fault: FaultCode, "", "The fault to clear, of `ClearFault`.";
        4 force_mn: i32, "mN, not negative", "The force to hold with, of `AtLeast` and `Expect`.", in 0..;
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

message! {
    /// OBJECT (AC), client to daemon: the name of the next object.
    #[derive(Eq)]
    Object<'a> {
        0 text: &'a [u8], "bytes of text m, then UTF-8", "Its name; empty for one without. At most 64 bytes name an object.";
    }
}

impl<'a> Object<'a> {
    /// The text up to the first byte that is not UTF-8.
    #[must_use]
    pub fn name(&self) -> &'a str {
        super::readable(self.text)
    }
}
