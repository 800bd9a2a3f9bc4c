//! The tables of transitions name the states and ends that the crate has.

use crate::codes::upper;
use crate::page::assert_states;
use grip_link::host::{CloseReason, LinkState};
use grip_link::message::{DeviceState, NackReason};

#[test]
fn transitions_name_every_state() {
    for code in 0..=8 {
        assert_states("SPEC.md", &[format!(" {} ", upper(&DeviceState::from_code(code)))]);
    }
    use LinkState as S;
    for state in [S::Closed, S::Open, S::Hello, S::Config, S::Stream, S::Degraded] {
        assert_states("HOST.md", &[format!(" {} ", upper(&state))]);
    }
}

#[test]
fn host_transitions_name_every_end() {
    let (kind, reason) = (0, NackReason::Latched);
    let ends = [
        CloseReason::Requested,
        CloseReason::NoAnswer {
            hellos: 0,
            bytes: 0,
            garbage_bytes: 0,
            echoes: 0,
            frames: 0,
            last: [0; _],
        },
        CloseReason::VersionMismatch { min: 0, max: 0 },
        CloseReason::NoStylus,
        CloseReason::BadIdent,
        CloseReason::Unanswered { kind },
        CloseReason::Refused { kind, reason },
        CloseReason::BadConfig { sample_rate_hz: 0, force_max_mn: 0, slew_mn_s: 0 },
        CloseReason::Lost { silent_us: 0 },
    ];
    for end in ends {
        // A new end has to be added above, and to the table.
        match end {
            CloseReason::Requested
            | CloseReason::NoAnswer { .. }
            | CloseReason::VersionMismatch { .. }
            | CloseReason::NoStylus
            | CloseReason::BadIdent
            | CloseReason::Unanswered { .. }
            | CloseReason::Refused { .. }
            | CloseReason::BadConfig { .. }
            | CloseReason::Lost { .. } => {}
        }
        let name = format!("{end:?}");
        let name = name.split([' ', '{']).next().unwrap();
        assert_states("HOST.md", &[format!("| close, `{name}`")]);
    }
}
