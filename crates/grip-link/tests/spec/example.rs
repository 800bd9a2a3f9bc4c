//! The worked example is the row of the vectors that it names, and its annotation covers each byte once.

use crate::page::{assert_states, row};
use crate::table::rows;
use crate::targets::words::unhex;
use grip_link::cobs;

/// Bytes of each line of the annotation.
const LENGTHS: [usize; 16] = [1, 1, 1, 1, 2, 2, 2, 4, 1, 1, 2, 4, 4, 4, 4, 1];

#[test]
fn the_annotation_is_the_row_of_the_vectors() {
    let vectors = rows::<7>("valid.tsv");
    let wire = unhex(&vectors.iter().find(|row| row[0] == "grip_reference").unwrap()[6]);
    let mut body = wire[1..wire.len() - 1].to_vec();
    let decoded = cobs::decode_in_place(&mut body).unwrap().to_vec();
    let hex = |bytes: &[u8]| {
        let bytes: Vec<String> = bytes.iter().map(|byte| format!("{byte:02X}")).collect();
        format!("`{}`", bytes.join(" "))
    };
    // Behind delimiter and first code byte each byte of the wire is one of the body.
    let mut at = 0;
    let mut expected = Vec::new();
    for length in LENGTHS {
        let part = hex(&wire[at..at + length]);
        let inside = at.checked_sub(2).and_then(|from| decoded.get(from..from + length)).map(hex);
        expected.push(match inside {
            Some(inside) => row(&[&part, &inside]),
            None => format!(" | {part} | |"),
        });
        at += length;
    }
    assert_eq!(at, wire.len());
    assert_states("vectors/README.md", &expected);
}
