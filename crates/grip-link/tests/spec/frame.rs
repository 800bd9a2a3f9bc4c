//! Sizes, check value, verdicts and counters.

use crate::page::{assert_states, row};
use grip_link::crc::crc32c;
use grip_link::decoder::Counters;
use grip_link::frame::{HEADER, MAX_BLOCK, MAX_PAYLOAD, MAX_WIRE, OVERHEAD};
use grip_link::message::Stats;
#[cfg(target_pointer_width = "64")]
use grip_link::{decoder::Decoder, device::DeviceLink, host::HostLink};

/// Names of the numeric fields of a value, in order.
fn field_names(debug: &str) -> Vec<String> {
    let words: Vec<&str> = debug.split([' ', ',', '{', '}']).filter(|w| !w.is_empty()).collect();
    let numeric = |pair: &&[&str]| pair[0].ends_with(':') && pair[1].parse::<u32>().is_ok();
    words.windows(2).filter(numeric).map(|pair| pair[0].trim_end_matches(':').to_owned()).collect()
}

#[test]
fn sizes() {
    assert_states(
        "SPEC.md",
        &[
            format!("header ({HEADER}) | payload (0..{MAX_PAYLOAD}) | CRC ({})", OVERHEAD - HEADER),
            format!("payload {MAX_PAYLOAD} bytes, body {}, ", MAX_PAYLOAD + OVERHEAD),
            format!("block (the body in COBS) {MAX_BLOCK}, and with both delimiters {MAX_WIRE}."),
            format!("`123456789`, is `{:08X}`", crc32c(b"123456789")),
        ],
    );
}

#[test]
fn verdicts_stand_in_the_order_of_the_checks() {
    let counters = field_names(&format!("{:?}", Counters::default()));
    let (refusals, rest) = counters[1..].split_at(9);
    assert_eq!(rest, ["gap", "garbage_bytes"]);
    let names = refusals.iter().map(String::as_str).chain(["ok"]);
    let rows: Vec<String> = (1..)
        .zip(names)
        .map(|(n, name): (u32, _)| row(&[&n.to_string(), &format!("`{name}`")]))
        .collect();
    assert_states("SPEC.md", &rows);
    let stats = field_names(&format!("{:?}", Stats::default()));
    assert_eq!((stats.len(), &stats[..12]), (19, &counters[..]));
}

#[test]
#[cfg(target_pointer_width = "64")]
fn memory() {
    // Another compiler may lay fields out otherwise by some bytes.
    let stated = [
        (4368, size_of::<DeviceLink>()),
        (3432, size_of::<HostLink>()),
        (584, size_of::<Decoder>()),
    ];
    for (stated, bytes) in stated {
        assert!(bytes.abs_diff(stated) * 50 <= bytes, "{stated} stated, {bytes} measured");
    }
    let [device, host, decoder] = stated.map(|(stated, _)| stated.to_string());
    assert_states(
        "../crates/grip-link/README.md",
        &[format!("take {host} and {device} bytes"), decoder],
    );
}
