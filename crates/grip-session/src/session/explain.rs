//! Sentences for people about the reason why a link closed.

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
        CloseReason::NoAnswer { hellos, bytes, frames, last, .. } => {
            let came = format!(
                "no gripper answered: {hellos} HELLOs were sent, {bytes} bytes came back, {}",
                if frames > 0 { "none of it is an answer" } else { "none of it is a frame" }
            );
            match text(&last) {
                Some(line) => format!(
                    "{came}; it looks like text: `{line}`. A device that sends numbers as lines of text is read as rows of \
                     another program: docs/rows.md"
                ),
                None => {
                    let shown = last.iter().rev().take(8).rev().map(|byte| format!(" {byte:02x}"));
                    let shown: String = shown.collect();
                    format!("{came}; it ends in{shown}. Another kind of device, or a wrong --baud")
                }
            }
        }
        CloseReason::VersionMismatch { min, max } => format!(
            "the gripper speaks protocol versions {min} to {max}, this program speaks {}. Update the older of the two",
            grip_link::PROTOCOL
        ),
        CloseReason::NoStylus => {
            "the gripper has no stylus, no travel and no array of taxels; slip cannot be felt".to_owned()
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

/// A line of them, where the bytes are text: a whole one where there is one.
fn text(last: &[u8]) -> Option<&str> {
    let text = str::from_utf8(last).ok()?.trim_matches('\0');
    let is_text = |c| matches!(c, '\r' | '\n' | '\0' | '\t' | ' '..='~');
    let lines = text.split(['\r', '\n', '\0']).map(str::trim).filter(|line| !line.is_empty());
    let lines: Vec<&str> = lines.collect();
    // The first one and the last one may be cut.
    let line = lines.get(1).filter(|_| lines.len() > 2).or(lines.first())?;
    (text.chars().all(is_text) && line.len() > 3).then_some(line)
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

#[cfg(test)]
mod tests {
    use super::{CloseReason, explain};
    use grip_link::host::LAST_BYTES;

    fn explained(came: &[u8]) -> String {
        let mut last = [0; LAST_BYTES];
        last.iter_mut().rev().zip(came.iter().rev()).for_each(|(place, byte)| *place = *byte);
        let bytes = came.len() as u64;
        explain(&CloseReason::NoAnswer {
            hellos: 30,
            bytes,
            garbage_bytes: 0,
            echoes: 0,
            frames: 0,
            last,
        })
    }

    #[test]
    fn a_device_that_prints_text_is_shown_its_own_line_and_led_to_rows() {
        let text = b"12 I=0.331\r\nF=5.12 I=0.331\r\nF=5.1";
        let reported = explained(text);
        for word in ["none of it is a frame", "`F=5.12 I=0.331`", "docs/rows.md"] {
            assert!(reported.contains(word), "{reported}");
        }
        let noise = explained(&[0x91, 0x00, 0xFF, b'a']);
        assert!(
            noise.contains("ends in 00 00 00 00 91 00 ff 61") && noise.contains("--baud"),
            "{noise}"
        );
        assert!(!explained(b"F\x1b[2J\x07=5.12").contains("text"), "nothing that moves a cursor");
    }
}
