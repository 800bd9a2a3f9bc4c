//! Sizes, COBS lengths, check value, verdicts and counters.

use crate::markdown::{pairs, table};
use grip_link::cobs;
use grip_link::crc::crc32c;
use grip_link::decoder::{Counters, Decoder};
use grip_link::device::DeviceLink;
use grip_link::frame::{HEADER, MAX_BLOCK, MAX_PAYLOAD, MAX_WIRE, OVERHEAD};
use grip_link::host::HostLink;
use grip_link::message::Stats;

/// Names of the numeric fields of a value, in order.
fn field_names(debug: &str) -> Vec<String> {
    let words: Vec<&str> = debug.split([' ', ',', '{', '}']).filter(|w| !w.is_empty()).collect();
    let numeric = |pair: &&[&str]| pair[0].ends_with(':') && pair[1].parse::<u32>().is_ok();
    words.windows(2).filter(numeric).map(|pair| pair[0].trim_end_matches(':').to_owned()).collect()
}

#[test]
fn sizes() {
    let expected = [
        ("MAX_PAYLOAD", MAX_PAYLOAD),
        ("HEADER", HEADER),
        ("OVERHEAD", OVERHEAD),
        ("MAX_BODY", MAX_PAYLOAD + OVERHEAD),
        ("MAX_BLOCK", MAX_BLOCK),
        ("MAX_WIRE", MAX_WIRE),
    ];
    let expected = expected.map(|(name, bytes)| (name.to_owned(), bytes.to_string()));
    assert_eq!(pairs("### Sizes", 0, 1), expected);
}

#[test]
fn encoded_lengths() {
    let rows = table("### COBS");
    assert_eq!(rows.len(), 6);
    for row in rows {
        let number = |cell: usize| row[cell].parse::<usize>().unwrap();
        for (byte, column) in [(1, 1), (0, 2)] {
            let data = vec![byte; number(0)];
            assert_eq!(cobs::encode(&data, &mut [0; 600]), Some(number(column)), "{row:?}");
        }
    }
}

#[test]
fn check_value() {
    let text = format!("{:08X}", crc32c(b"123456789"));
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../protocol/SPEC.md");
    let spec = std::fs::read_to_string(path).unwrap();
    assert!(spec.contains(&format!("`123456789`, is `{text}`")));
}

#[test]
fn counters_stand_in_the_order_of_stats() {
    let stats = field_names(&format!("{:?}", Stats::default()));
    assert_eq!(stats.len(), 16);
    let first = |heading| table(heading).into_iter().map(|row| row[0].clone()).collect::<Vec<_>>();
    assert_eq!(first("### Counters"), stats);
    let sent: Vec<_> = table("### 92 STATS").into_iter().map(|row| row[3].clone()).collect();
    assert_eq!(sent, stats);
}

#[test]
fn verdicts_stand_in_the_order_of_the_checks() {
    let counters = field_names(&format!("{:?}", Counters::default()));
    let (refusals, rest) = counters[1..].split_at(9);
    assert_eq!(rest, ["gap", "garbage_bytes"]);
    let rows = pairs("### Verdicts", 0, 1);
    let expected = refusals.iter().map(String::as_str).chain(["ok"]);
    let expected: Vec<(String, String)> =
        (1..).zip(expected).map(|(n, name): (u32, _)| (n.to_string(), name.to_owned())).collect();
    assert_eq!(rows, expected);
}

#[test]
#[cfg(target_pointer_width = "64")]
fn memory() {
    let sizes = [
        ("Rust DeviceLink, 64-bit", size_of::<DeviceLink>()),
        ("Rust HostLink, 64-bit", size_of::<HostLink>()),
        ("Rust Decoder, 64-bit", size_of::<Decoder>()),
    ];
    let rows = pairs("### Memory", 0, 1);
    for (name, bytes) in sizes {
        let (_, stated) = rows.iter().find(|(what, _)| what == name).unwrap();
        let stated: usize = stated.parse().unwrap();
        // Another compiler may lay fields out otherwise by some bytes.
        assert!(stated.abs_diff(bytes) * 50 <= bytes, "{name}: {stated} stated, {bytes} measured");
    }
}
