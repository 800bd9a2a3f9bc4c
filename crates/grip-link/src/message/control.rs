//! The short messages: PING, PONG, HEARTBEAT, CLEAR_FAULT, ACK, NACK.

use super::FaultCode;
use super::{Kind, NackReason};
use slip_msg::message;

message! {
    /// PING (06), host to MCU.
    #[derive(Eq)]
    Ping {
        0 t1_us: u64, "us, host time of sending; the device only returns it", "Host time of sending.";
    }
}

message! {
    /// PONG (86), MCU to host.
    #[derive(Eq)]
    Pong {
        0 t1_us: u64, "us, that of the PING", "t1 of the PING.";
        8 rx_tick: u64, "tick at which the PING was received", "The PING was received.";
        16 tx_tick: u64, "tick at which the PONG was written", "The PONG was written.";
    }
}

message! {
    /// HEARTBEAT (11), host to MCU: for the log and the watchdog; it does not refresh a GRIP.
    #[derive(Eq)]
    Heartbeat {
        0 turns: u32, "turns of the host's control loop, wraps", "Turns of the hot loop.";
        4 longest_us: u32, "us, longest turn since the last HEARTBEAT, saturates", "Longest turn since the last HEARTBEAT.";
        8 late: u16, "late turns since the last HEARTBEAT, saturates", "Late turns since the last HEARTBEAT.";
        10 flags: u16, "b0 degraded; others 0", "Flags.";
    }
}

message! {
    /// CLEAR_FAULT (13), host to MCU, ACK_REQ. It clears the named fault only, so that one nobody has seen yet stays; the
    /// MCU is LINKED afterwards and must be configured again.
    #[derive(Eq)]
    ClearFault {
        0 fault: FaultCode, "the fault that the host has seen; 0 = NACK OTHER_FAULT", "The fault the host has seen.";
    }
}

message! {
    /// ACK (8E), MCU to host: START, STOP or CLEAR_FAULT was carried out.
    #[derive(Eq)]
    Ack {
        0 kind: Kind, "type of the request", "Type of the request.", reserved 1;
        2 seq as "request_seq": u16, "its seq", "seq of the request.";
    }
}

message! {
    /// NACK (8F), MCU to host: a frame with ACK_REQ was refused.
    #[derive(Eq)]
    Nack {
        0 kind: Kind, "type of the request", "Type of the request.";
        1 reason: NackReason, "NACK reason", "Why.";
        2 seq as "request_seq": u16, "its seq", "seq of the request.";
    }
}
