//! The reason why a link closed in, a sentence for people out.

use grip_link::{host::CloseReason, message::Kind};

/// What a closed link means to the person at the keyboard, and what to do about it.
#[must_use]
pub fn explain(reason: &CloseReason) -> String {
    match *reason {
        CloseReason::Requested => "the link was closed".to_owned(),
        CloseReason::NoAnswer { hellos, bytes: 0, .. } => format!(
            "no gripper answered: {hellos} HELLOs were sent and not one byte came back. Is it powered, and is this its port?"
        ),
        CloseReason::NoAnswer { echoes, .. } if echoes > 0 => format!(
            "no gripper answered: the line echoed {echoes} of our own frames. Turn the echo off, or check that TX and RX are not joined"
        ),
        CloseReason::NoAnswer { hellos, bytes, garbage_bytes, .. } => format!(
            "no gripper answered: {hellos} HELLOs were sent, {bytes} bytes came back, {garbage_bytes} of them no frames. \
             Another kind of device, or a wrong --baud"
        ),
        CloseReason::VersionMismatch { min, max } => format!(
            "the gripper speaks protocol versions {min} to {max}, this program speaks {}. Update the older of the two",
            grip_link::PROTOCOL
        ),
        CloseReason::NoStylus => {
            "the gripper has no stylus channel; slip cannot be felt".to_owned()
        }
        CloseReason::BadIdent => {
            "the gripper describes itself in a way the protocol does not allow; its firmware needs an update"
                .to_owned()
        }
        CloseReason::Unanswered { kind } => {
            format!(
                "the gripper did not answer {}, sent three times; restart it, and update its firmware if that does not help",
                request_name(kind)
            )
        }
        CloseReason::Refused { kind, reason } => {
            format!("the gripper refused {}: {reason}", request_name(kind))
        }
        CloseReason::BadConfig { sample_rate_hz, force_max_mn, slew_mn_s } => format!(
            "the gripper put {sample_rate_hz} Hz, at most {} N and {} N/s in force, which these settings cannot work with",
            f64::from(force_max_mn) / 1000.0,
            f64::from(slew_mn_s) / 1000.0
        ),
        CloseReason::Lost { silent_us } => {
            format!("the gripper fell silent ({} ms without a frame)", silent_us / 1000)
        }
    }
}

/// A request by the name it has in the protocol.
fn request_name(kind: u8) -> String {
    let name = match Kind(kind) {
        Kind::CONFIG => "CONFIG",
        Kind::START => "START",
        Kind::STOP => "STOP",
        Kind::CLEAR_FAULT => "CLEAR_FAULT",
        _ => return format!("a request of type {kind:02X}"),
    };
    name.to_owned()
}
