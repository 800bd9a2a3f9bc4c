//! The tables of transitions name the states and ends that the crate has.

use crate::codes::upper;
use crate::markdown::{Row, table};
use grip_link::host::CloseReason;
use grip_link::message::{DeviceState, NackReason};
use std::collections::BTreeSet;

/// Words in capitals of some columns.
fn capitals(rows: &[Row], columns: &[usize]) -> BTreeSet<String> {
    let cells = rows.iter().flat_map(|row| columns.iter().map(|column| row[*column].clone()));
    let words = cells.flat_map(|cell| {
        let split = cell.split(|c: char| !(c.is_ascii_uppercase() || c == '_'));
        split.filter(|word| word.len() > 2).map(str::to_owned).collect::<Vec<_>>()
    });
    words.collect()
}

#[test]
fn device_transitions_name_every_state_and_no_other() {
    let states: BTreeSet<String> =
        (0..=8).map(|code| upper(&DeviceState::from_code(code))).collect();
    let rows = table("### Device transitions");
    assert!(rows.iter().all(|row| row.len() == 4));
    assert_eq!(capitals(&rows, &[0, 3]), states);
}

#[test]
fn host_transitions_name_every_state_and_every_end() {
    let states: BTreeSet<String> =
        table("### Host states").into_iter().map(|row| row[0].clone()).collect();
    let rows = table("### Host transitions");
    assert!(rows.iter().all(|row| row.len() == 4));
    assert_eq!(capitals(&rows, &[0, 3]), states);
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
    let names: BTreeSet<String> = ends
        .iter()
        .map(|end| {
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
            format!("{end:?}").split([' ', '{']).next().unwrap().to_owned()
        })
        .collect();
    let reported: BTreeSet<String> =
        rows.iter().filter_map(|row| Some(row[2].split_once("close, ")?.1.to_owned())).collect();
    assert_eq!(reported, names);
}
