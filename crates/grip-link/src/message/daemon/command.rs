//! COMMAND and OBJECT: what a client wants the gripper to do, and with what.

use super::Operation;
use crate::message::FaultCode;
use slip_msg::message;

message! {
    /// COMMAND (A9), client to daemon.
    #[derive(Eq)]
    Command {
        0 operation: Operation, "client operation; another is malformed", "What to do.", reserved 1;
        2 fault: FaultCode, "of CLEAR_FAULT", "The fault to clear, of `ClearFault`.";
        4 force_mn: i32, "mN, of AT_LEAST and EXPECT; negative is malformed", "The force to hold with, of `AtLeast` and `Expect`.", in 0..;
        8 token: u32, "of RELEASE: that of WELCOME, else NACK TOKEN", "That of WELCOME, of `Release`.";
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
        0 text: &'a [u8], "name of the next object, UTF-8", "Its name; empty for one without. At most 64 bytes name an object.";
    }
}

impl<'a> Object<'a> {
    /// The text up to the first byte that is not UTF-8.
    #[must_use]
    pub fn name(&self) -> &'a str {
        super::readable(self.text)
    }
}
